"""Layers of a stage: files beside it are read, others only if that is allowed, and damaged ones are refused."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from pxr import Sdf, UsdUtils

from tests.usd.case.stages import HEAD, write
from tests.usd.case.test_refusals import refusal
from warp_mps.app.cli import main
from warp_mps.errors import InputError
from warp_mps.usd.case.read import read_stage

HEAD_SI = HEAD.format(length=1, mass=1, up="Y")
ARCS = {
    "subLayers": "    subLayers = [@{0}@]\n",
    "references": "references = @{0}@</Beam>",
    "payload": "payload = @{0}@</Beam>",
}


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """A folder for stages, in one that holds a sound stage, case.usda, with a beam."""
    write(tmp_path)
    folder = tmp_path / "home"
    folder.mkdir()
    return folder


def composed(folder: Path, field: str, asset: str) -> Path:
    """A stage of a beam that comes from another file, by one of `ARCS`."""
    arc = ARCS[field].format(asset)
    if field == "subLayers":
        return _write(folder / "main.usda", HEAD_SI.replace("(\n", f"(\n{arc}", 1))
    path = write(folder)
    path.write_text(path.read_text().replace('def Cube "Beam"\n', f'def Cube "Beam" (\n    {arc}\n)\n'))
    return path.rename(folder / "main.usda")


@pytest.mark.parametrize("field", ARCS)
@pytest.mark.parametrize(
    "form", ["{up}/case.usda", "../case.usda", "link.usda", "./link.usda", "below/../../case.usda"]
)
def test_layers_outside_the_folder_are_refused_unless_they_are_allowed(home: Path, field: str, form: str) -> None:
    (home / "link.usda").symlink_to("../case.usda")
    asset = form.format(up=home.parent)
    path = composed(home, field, asset)
    error = refusal(path)
    assert (error.where, error.attribute) == ((str(path) if field == "subLayers" else "/Beam"), field)
    assert error.reason == f"refers to @{asset}@, outside the folder of the stage; allow it by --allow-external"
    assert read_stage(path, allow_external=True).bodies[0].name == "Beam"


@pytest.mark.parametrize("field", ARCS)
def test_layers_in_the_folder_and_below_need_no_leave(home: Path, field: str) -> None:
    below = home / "parts" / "beams"
    below.mkdir(parents=True)
    write(below)
    (home / "link.usda").symlink_to("parts/beams/case.usda")
    for asset in ("parts/beams/case.usda", "./parts/../parts/beams/case.usda", str(below / "case.usda"), "./link.usda"):
        assert read_stage(composed(home, field, asset)).bodies[0].name == "Beam"


def test_the_folder_is_the_one_that_a_link_to_a_folder_leads_to(home: Path) -> None:
    (home.parent / "alias").symlink_to("home")
    composed(home, "references", str(home / "case.usda"))
    write(home)
    assert read_stage(home.parent / "alias" / "main.usda").bodies[0].name == "Beam"


def test_layers_of_layers_lie_in_the_folder_of_the_stage(home: Path) -> None:
    below = home / "parts"
    below.mkdir()
    composed(below, "references", "../../case.usda")
    assert "@../../case.usda@, outside" in refusal(composed(home, "references", "parts/main.usda")).reason
    composed(below, "subLayers", "../more.usda")
    write(home).rename(home / "more.usda")
    assert read_stage(composed(home, "subLayers", "parts/main.usda")).bodies[0].name == "Beam"


@pytest.mark.parametrize(
    "asset", ["http://localhost/a.usda", "https://a/b.usdz", "file:///etc/passwd", "s3://a/b.usda", '`"a"`']
)
def test_what_is_no_path_of_a_file_is_never_followed(home: Path, asset: str) -> None:
    path = composed(home, "references", asset)
    assert (refusal(path).where, refusal(path).attribute) == ("/Beam", "references")
    assert refusal(path, allow_external=True).reason.endswith("which is not the path of a file")


def test_references_in_a_variant_that_is_not_chosen_count_as_well(home: Path) -> None:
    path = write(home)
    variant = 'variantSet "v" = {\n"a" (\nreferences = @../case.usda@\n) {\n}\n}\n'
    path.write_text(path.read_text() + f'def "Other" (\nprepend variantSets = "v"\n)\n{{\n{variant}}}\n')
    assert (refusal(path).where, refusal(path).attribute) == ("/Other", "references")


def test_value_clips_are_refused_before_they_are_opened(home: Path) -> None:
    clips = 'dictionary default = {\nasset[] assetPaths = [@../case.usda@]\nstring primPath = "/Beam"\n}'
    path = write(home, text=f'over "Beam" (\nclips = {{\n{clips}\n}}\n)\n{{\n}}\n')
    path.write_text(path.read_text().replace('over "Beam"', 'over "Beam2"'))
    assert (refusal(path).where, refusal(path).attribute) == ("/Beam2", "clips")
    assert "may vary in time" in refusal(path, allow_external=True).reason


def test_assets_that_are_not_read_may_lie_anywhere(home: Path) -> None:
    texture = ("Shader", "asset inputs:file = @/etc/passwd@")
    assert read_stage(write(home, Texture=texture)).bodies[0].name == "Beam"


@pytest.mark.parametrize("names", [("main",), ("main", "other")])
def test_sublayers_in_a_circle_are_refused_in_a_line(home: Path, names: tuple[str, ...]) -> None:
    # the first is written last, for each is called main.usda at first
    for name, following in list(zip(names, (*names[1:], names[0]), strict=True))[::-1]:
        composed(home, "subLayers", f"{following}.usda").rename(home / f"{name}.usda")
    assert "cycle" in refusal(home / "main.usda").reason


@pytest.mark.long
def test_references_that_double_in_every_layer_are_given_up(home: Path) -> None:
    for number in range(30):
        arc = f"references = @./{number + 1}.usda@"
        body = "".join(f'def "{name}" (\n{arc}\n)\n{{\n}}\n' for name in "ab") if number < 29 else ""
        _write(home / f"{number}.usda", f'#usda 1.0\n(\ndefaultPrim = "R"\n)\ndef "R"\n{{\n{body}}}\n')
    path = write(home, text='def "Crowd" (\nreferences = @./0.usda@\n)\n{\n}\n')
    assert refusal(path).reason == "takes USD more than 6 s of processor time to compose"


@pytest.mark.parametrize("suffix", [".usdc", ".usd"])
def test_binary_stages_are_read_and_damaged_ones_refused(home: Path, suffix: str) -> None:
    path = home / f"case{suffix}"
    Sdf.Layer.FindOrOpen(str(write(home))).Export(str(path))
    assert read_stage(path).bodies[0].name == "Beam"
    data = path.read_bytes()
    for cut in (10, len(data) - 1):
        path.write_bytes(data[:cut])
        assert "is not a USD stage that can be read" in refusal(path).reason
    # where its table of contents begins
    path.write_bytes(data[:16] + b"\xff\xff\xff\xff\xff\xff\xff\x7f" + data[24:])
    refusal(path)


def test_packages_are_read_and_referred_to(home: Path) -> None:
    (home / "parts").mkdir()
    write(home)
    package = home / "parts" / "beam.usdz"
    assert UsdUtils.CreateNewUsdzPackage(str(home / "case.usda"), str(package))
    assert read_stage(package).bodies[0].name == "Beam"
    assert read_stage(composed(home, "references", "parts/beam.usdz")).bodies[0].name == "Beam"
    package.rename(home.parent / "beam.usdz")
    assert "outside the folder" in refusal(composed(home, "references", "../beam.usdz")).reason
    package.write_bytes((home.parent / "beam.usdz").read_bytes()[:500])
    refusal(package)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "it is empty"),
        (b"#usda 1.0\n# a comment\n# \xe9\xe8\n", "line 3 is not UTF-8"),
        (b'#usda 1.0\ndef "A"\n{\n    double x = "hi"\n}\n', "line 4"),
        (b"#usda 1.0\n" + b'def "a" {\n' * 600 + b"}\n" * 600, "more than 500 nested brackets"),
        (b'#usda 1.0\ndef PhysicsScene "A"\n{\n    int mps:dimension = 2.5\n}\n', "is 2.5, must be a whole number"),
        (b"#usda 1.0\n" + b"(" * 10**6, "more than 500 nested brackets"),
        (b'#usda 1.0\ndef "' + b"a" * 10**6 + b'" {', "is not a USD stage"),
    ],
)
def test_texts_that_are_no_stages_are_refused_in_a_line(home: Path, data: bytes, reason: str) -> None:
    path = home / "case.usda"
    path.write_bytes(data)
    error = refusal(path)
    assert reason in error.reason
    assert len(str(error)) < 1000


def test_brackets_in_texts_and_comments_are_not_counted(home: Path) -> None:
    words = ("Scope", f'string a = "{"(" * 600}"', f"string b = '''{'[' * 600}'''", f'string c = """{"{" * 600}"""')
    path = write(home, Words=words, text="# " + "(" * 600 + "\n/* " + "[" * 600 + " */\n")
    assert read_stage(path).bodies[0].name == "Beam"


@pytest.mark.skipif(sys.platform == "win32", reason="pipes and links are made by the means of Unix")
def test_what_is_no_file_is_not_opened(home: Path) -> None:
    os.mkfifo(home / "pipe.usda")
    (home / "loop.usda").symlink_to("loop.usda")
    for path in (home, home / "pipe.usda", home / "loop.usda", home / ("x" * 300 + ".usda")):
        assert "there is no such file" in refusal(path).reason
    assert "is not a file" in refusal(composed(home, "references", "pipe.usda")).reason


def test_the_command_line_has_an_option_for_it(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(composed(home, "references", "../case.usda"))
    for command in ("check", "run", "validate"):
        assert main([command, path]) == 2
        captured = capsys.readouterr()
        assert captured.err.count("\n") <= 2
        assert "/Beam references: refers to @../case.usda@, outside the folder of the stage" in captured.err
    assert main(["check", path, "--allow-external"]) == 0


def _write(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def test_a_path_that_is_not_utf_8_is_refused() -> None:
    with pytest.raises(InputError, match=r"^'a\\udcff.usda': cannot be read: its path is not UTF-8, which USD needs"):
        read_stage("a\udcff.usda")
