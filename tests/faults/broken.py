"""Files that are not stages, or that mislead; each function writes one into a folder and returns its path."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Callable
from pathlib import Path

from pxr import Sdf, UsdUtils

from tests.faults.mutations import Random, pick, prims

Breakage = Callable[[str, Path, Random], Path]
ENDINGS = (".usda", ".usdc", ".usd", ".usdz")
# what eight bytes are overwritten with
EIGHT = (b"\xff" * 8, b"\0" * 8, b"\x7f" + b"\xff" * 7, b"\0" * 4 + b"\xff" * 4)
# how a prim, a list and a dictionary begin and end
NESTED = (('def Xform "a" {\n', "}\n"), ("[", "]"), ("dictionary a = {\n", "}\n"))


def truncated_text(text: str, folder: Path, random: Random) -> Path:
    """The file was cut short."""
    return _write(folder / "case.usda", text.encode()[: int(random.integers(len(text)))])


def flipped_text(text: str, folder: Path, random: Random) -> Path:
    """Some bytes are others."""
    return _write(folder / "case.usda", _flipped(text.encode(), random))


def swapped_text(text: str, folder: Path, random: Random) -> Path:
    """Lines are missing, doubled, or in another place."""
    lines = text.splitlines(keepends=True)
    for _ in range(int(random.integers(1, 4))):
        a, b = (int(number) for number in random.integers(len(lines), size=2))
        how = int(random.integers(3))
        lines[a : a + how] = lines[b : b + 1] if how < 2 else []
    return _write(folder / "case.usda", "".join(lines).encode())


def truncated_crate(text: str, folder: Path, random: Random) -> Path:
    """A binary file was cut short."""
    data = _crate(text, folder)
    return _write(folder / "case.usdc", data[: int(random.integers(len(data)))])


def flipped_crate(text: str, folder: Path, random: Random) -> Path:
    """Some bytes of a binary file are others."""
    data = _crate(text, folder)
    if random.random() < 0.5:
        # its table of contents stands at the end, the most tender part
        return _write(folder / "case.usdc", data[:-400] + _flipped(data[-400:], random))
    return _write(folder / "case.usdc", _flipped(data, random))


def flipped_layer(text: str, folder: Path, random: Random) -> Path:
    """A sound stage is composed of a damaged binary file."""
    _write(folder / "part.usdc", _flipped(_crate(text, folder), random))
    return _write(folder / "case.usda", b"#usda 1.0\n(\n    subLayers = [@./part.usdc@]\n)\n")


def damaged_package(text: str, folder: Path, random: Random) -> Path:
    """A package is cut short, or some of its bytes are others."""
    part = _write(folder / f"part{pick(random, ('.usda', '.usdc'))}", b"")
    layer = Sdf.Layer.CreateAnonymous(part.suffix)
    layer.ImportFromString(text)
    layer.Export(str(part))
    UsdUtils.CreateNewUsdzPackage(str(part), str(folder / "case.usdz"))
    data = (folder / "case.usdz").read_bytes()
    data = data[: int(random.integers(len(data)))] if random.random() < 0.3 else _flipped(data, random)
    return _write(folder / "case.usdz", data)


def archive(text: str, folder: Path, random: Random) -> Path:
    """A zip file that is no package: compressed, or with something else in it."""
    path, kind = folder / "case.usdz", pick(random, (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))
    with zipfile.ZipFile(path, "w", kind) as file:
        file.writestr(pick(random, ("a.usda", "a.txt", "../a.usda", "a.usdz")), text)
    return path


def noise(text: str, folder: Path, random: Random) -> Path:
    """Nothing, zeros, noise, or a file of another kind under a stage's name."""
    heads = (b"", b"\0" * 100, b"#usda 1.0\n", b"PXR-USDC", b"PXR-USDC\0\x08", b"PK\x03\x04", b"\xff\xfe#\0u\0")
    data = pick(random, heads) + random.bytes(int(pick(random, (0, 1, 100, 10_000))))
    return _write(folder / f"case{pick(random, ENDINGS)}", data)


def disguised(text: str, folder: Path, random: Random) -> Path:
    """A binary file is called one of text, and the other way round."""
    if random.random() < 0.5:
        return _write(folder / f"case{pick(random, ('.usdc', '.usd', '.usdz'))}", text.encode())
    return _write(folder / f"case{pick(random, ('.usda', '.usd', '.usdz'))}", _crate(text, folder))


def encoded(text: str, folder: Path, random: Random) -> Path:
    """The text is in another encoding."""
    lines = text.splitlines(keepends=True)
    lines.insert(int(random.integers(len(lines))), "# \u00e9t\u00e9 \u00df\n")
    encoding = pick(random, ("latin-1", "utf-16", "utf-8-sig", "cp037"))
    return _write(folder / "case.usda", "".join(lines).encode(encoding))


def no_file(text: str, folder: Path, random: Random) -> Path:
    """A folder, a pipe, a device, a link to itself or to nothing."""
    path = folder / f"case{pick(random, ENDINGS)}"
    how = pick(random, ("folder", "pipe", "device", "loop", "nothing", "long"))
    if how == "folder":
        path.mkdir()
    elif how == "pipe":
        os.mkfifo(path)
    elif how == "long":
        return folder / ("x" * 300 + ".usda")
    else:
        path.symlink_to({"device": "/dev/zero", "loop": path.name, "nothing": "nowhere.usda"}[how])
    return path


def deep(text: str, folder: Path, random: Random) -> Path:
    """Prims, lists, dictionaries or nested brackets, far too deep."""
    n = pick(random, (100, 3000, 100_000, 1_000_000))
    prim, value, dictionary = (opened * n + closed * n for opened, closed in NESTED)
    bodies = (
        *(prim, "(" * n, "{" * n, '"' + "\\" * n, "'''" + "x" * n, f'def "{"a" * n}" {{\n}}'),
        f'def "a" {{\ndouble[] b = {value}\n}}',
        f'def "a" (\ncustomData = {{\n{dictionary}}}\n) {{\n}}',
        f'def "a" {{\nrel b = </{"a/" * n}a>\n}}',
        f'def "a" (\nvariantSets = "v"\n) {{\nvariantSet "v" = {{\n"x" {{\n{prim}}}\n}}\n}}',
    )
    body = pick(random, bodies)
    return _write(folder / "case.usda", f"{text}\n{body}\n".encode())


def cyclic(text: str, folder: Path, random: Random) -> Path:
    """Layers that lead to themselves, to each other, to nothing or to a crowd of others."""
    arc = pick(random, ("subLayers = [{0}]", "references = {0}", "payload = {0}"))
    targets = ("case.usda", "./case.usda", "b.usda", "missing.usda", "", ".", "b.usda</Nowhere>", "text.png")
    target = pick(random, targets)
    path, other = folder / "case.usda", folder / "b.usda"
    _write(folder / "text.png", b"\x89PNG")
    for file, to in ((path, target), (other, pick(random, ("case.usda", "b.usda", "missing.usda")))):
        name, _, prim = to.partition("<")
        item = f"@{name}@" + (f"<{prim}" if prim and "subLayers" not in arc else "")
        _write(file, _with_arc(text, arc.format(item), prim=arc[0] != "s").encode())
    return path


def crowd(text: str, folder: Path, random: Random) -> Path:
    """Each layer refers twice to the next one: two to the power of the layers prims."""
    count = int(pick(random, (8, 30)))
    for number in range(count):
        body = "".join(f'    def "{name}" ( references = @./{number + 1}.usda@ ) {{ }}\n' for name in "ab")
        head = '#usda 1.0\n( defaultPrim = "R" )\n'
        _write(folder / f"{number}.usda", f'{head}def "R"\n{{\n{body if number + 1 < count else ""}}}\n'.encode())
    return _write(folder / "case.usda", _with_arc(text, "references = @./0.usda@", prim=True).encode())


def outside(text: str, folder: Path, random: Random) -> Path:
    """A layer leads out of its folder: up, to an absolute path, through a link, to a network, to a device."""
    home = folder / "home"
    home.mkdir()
    _write(folder / "other.usda", text.encode())
    (home / "link.usda").symlink_to("../other.usda")
    targets = ("../other.usda", str(folder / "other.usda"), "link.usda", "./link.usda", "/etc/passwd", "/dev/zero",
               "http://localhost/x.usda", "https://localhost/x.usda", "file:///etc/passwd", "s3://a/b.usda", "anon:1:x",
               "a.usdz[b.usda]", "../../../../../../etc/hostname", "~/x.usda", "x.usda:SDF_FORMAT_ARGS:a=b",
               "`\"x\"`")  # fmt: skip
    arc = pick(random, ("subLayers = [@{0}@]", "references = @{0}@", "payload = @{0}@", "clips = {0}"))
    if arc[0] == "c":
        paths = f"asset[] assetPaths = [@{pick(random, targets)}@]"
        default = f'{paths}\nstring primPath = "/World"\ndouble2[] active = [(0, 0)]'
        clips = f"{{\ndictionary default = {{\n{default}\n}}\n}}"
        return _write(home / "case.usda", _with_arc(text, f"clips = {clips}", prim=True).encode())
    return _write(home / "case.usda", _with_arc(text, arc.format(pick(random, targets)), prim=arc[0] != "s").encode())


def _write(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


def _flipped(data: bytes, random: Random) -> bytes:
    changed = bytearray(data)
    for _ in range(int(pick(random, (1, 1, 2, 10, 100)))):
        how, at = int(random.integers(4)), int(random.integers(max(1, len(changed))))
        if how == 0:
            changed[at] ^= 1 << int(random.integers(8))
        elif how == 1:
            changed[at] = int(random.integers(256))
        elif how == 2:
            changed[at : at + 8] = pick(random, EIGHT)
        else:
            changed[at : at + 1] = random.bytes(int(random.integers(3)))
    return bytes(changed)


def _crate(text: str, folder: Path) -> bytes:
    """A stage as a binary file."""
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    layer.ImportFromString(text)
    path = folder / "sound.usdc"
    layer.Export(str(path))
    data = path.read_bytes()
    path.unlink()
    return data


def _with_arc(text: str, arc: str, *, prim: bool) -> str:
    """The text of a stage with metadata added to it, or to its first prim."""
    if not prim:
        return text.replace("(\n", f"(\n    {arc}\n", 1)
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(text)
    first = prims(layer)[0].name
    return text + f'\nover "{first}_" (\n{arc}\n)\n{{\n}}\n'


BREAKAGES: dict[str, Breakage] = {
    "truncated .usda": truncated_text,
    "flipped bytes of .usda": flipped_text,
    "swapped lines of .usda": swapped_text,
    "truncated .usdc": truncated_crate,
    "flipped bytes of .usdc": flipped_crate,
    "damaged .usdc as a layer": flipped_layer,
    "damaged .usdz": damaged_package,
    "zip that is no stage": archive,
    "empty, zeros, noise": noise,
    "wrong ending": disguised,
    "other encoding": encoded,
    "folder, pipe, device": no_file,
    "deep nesting": deep,
    "cyclic and missing layers": cyclic,
    "crowd of references": crowd,
    "layers from outside": outside,
}
