"""The page's text for runs of all kinds; names and messages are not taken for HTML."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from tests.app.report.runs import MEASURED, write_run, write_tables
from tests.app.results import write_result
from warp_mps.app.cli import main
from warp_mps.app.report import watch
from warp_mps.app.report.diagrams import POINTS, make_diagrams
from warp_mps.app.report.run_data import read_run
from warp_mps.results.history import TIME_LABEL, History, energy_labels, write_history
from warp_mps.results.summary import RunSummary
from warp_mps.run.locks import lock_folder


def report(folder: Path, *options: str) -> str:
    assert main(["report", str(folder), "--overwrite", *options]) == 0
    return (folder / "report.html").read_text(encoding="utf-8")


def data(text: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found
    return json.loads(found[1])


def test_a_page_has_everything_and_asks_for_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_run(tmp_path)
    text = report(tmp_path)
    assert capsys.readouterr().out == f"{tmp_path / 'report.html'}\n"
    assert "<title>resting</title>" in text
    assert "finished" in text
    assert "+1.25 %" in text
    assert "2e-16" in text
    assert '<td class="n">0.019 m</td><td class="n">0.02 m</td><td class="n">-5.00 %</td>' in text
    assert "bodies: block" in text
    assert "spacing [m]</td><td>0.1<" in text
    assert "http" not in text.replace("http-equiv", "").replace("http://www.w3.org/2000/svg", "")
    found = data(text)
    assert [item["title"] for item in found["diagrams"]] == ["tip", "energies"]
    lines = found["diagrams"][0]["lines"]
    assert lines[1]["references"] == [{"name": "height <b>", "times": [0.0, 0.02], "value": 0.02}]
    assert found["diagrams"][0]["measured"] == ["height <b>: 0.019 m, reference 0.02 m (-5.00 %)"]
    assert found["reload"] is None
    assert text.count('<script type="text/plain" id="block') == len(re.findall('"block":', json.dumps(found)))


def test_no_text_becomes_part_of_the_page(tmp_path: Path) -> None:
    evil = '</script><img src=x onerror="alert(1)">&'
    rows = [{**MEASURED[0], "name": evil, "source": evil, "unit": evil, "reason": evil}]
    settings = {"description": evil, evil: evil, "bodies": {evil: {evil: [evil]}}}
    write_run(
        tmp_path, case=evil, status="failed", reason=evil, measurements=rows, settings=settings, versions={evil: evil}
    )
    text = report(tmp_path)
    assert "<img" not in text
    assert "&lt;/script&gt;&lt;img" in text
    # the scripts, their data and the blocks, and nothing else
    assert text.count("</script>") == 2 + text.count('<script type="text/plain"')
    assert data(text)["diagrams"][0]["measured"][0].startswith(evil)


def test_what_is_missing_is_said_and_the_rest_is_shown(tmp_path: Path) -> None:
    write_tables(tmp_path)
    text = report(tmp_path)
    assert "There is no animation: the run has saved no frame." in text
    assert data(text)["frames"] is None
    (tmp_path / "probes.csv").write_text("damaged", encoding="utf-8")
    (tmp_path / "run.usdc").write_text("damaged", encoding="utf-8")
    text = report(tmp_path)
    assert "There is no animation: run.usdc is not a USD stage that can be read" in text
    assert "There are no diagrams: probes.csv is not a table of probes" in text
    (tmp_path / "probes.csv").unlink()
    (tmp_path / "run.usdc").unlink()
    (tmp_path / "run.json").write_text("{", encoding="utf-8")
    assert "There is no summary of the run: is not valid JSON" in report(tmp_path)


def test_an_animation_alone_is_enough(tmp_path: Path) -> None:
    write_result(tmp_path, frames=1)
    text = report(tmp_path)
    assert "<title>resting</title>" in text
    assert len(data(text)["frames"]["times"]) == 1
    assert "There is no summary of the run" in text
    assert "There are no diagrams" in text


@pytest.mark.parametrize(
    ("facts", "words"),
    [
        ({"status": "failed", "reason": "a particle left"}, "failed: a particle left"),
        (
            {"status": "failed", "reason": "interrupted; continue with --resume"},
            ">interrupted; continue with --resume<",
        ),
        ({"status": "running"}, "stopped without an error message"),
    ],
)
def test_runs_that_did_not_end_well_say_so(tmp_path: Path, facts: dict[str, Any], words: str) -> None:
    write_run(tmp_path, measurements=[], **facts)
    text = report(tmp_path)
    assert words in text
    assert "None were made." in text


def test_the_remarks_of_a_run_are_shown(tmp_path: Path) -> None:
    write_run(tmp_path, remarks=["3 fluid particles are outside the tank at the end: over the top of 'right' & <left>"])
    assert "<li>3 fluid particles are outside the tank" in (text := report(tmp_path))
    assert "&amp; &lt;left&gt;</li>" in text


def test_a_static_run_goes_by_load_factors(tmp_path: Path) -> None:
    write_run(tmp_path, settings={"analysis": "static"}, time=1.0)
    text = report(tmp_path)
    assert "<dt>load factor</dt><dd>1</dd>" in text
    assert (data(text)["timeLabel"], data(text)["timeUnit"]) == ("load factor", "")


def test_long_histories_keep_their_peaks(tmp_path: Path) -> None:
    rows = [(0.001 * k, 1.0 if k == 4321 else 0.0, *[0.0] * 6) for k in range(50_000)]
    write_tables(tmp_path)
    write_history(tmp_path / "probes.csv", History([TIME_LABEL, "push [N]", *energy_labels(2)], rows))
    (diagram,) = make_diagrams(read_run(tmp_path))
    assert len(diagram["times"]) <= POINTS + 2
    assert max(diagram["lines"][0]["values"]) == 1.0
    assert diagram["times"][diagram["lines"][0]["values"].index(1.0)] == 4.321
    assert (diagram["times"][0], diagram["times"][-1]) == (0.0, 49.999)


def test_a_run_is_watched_until_it_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_run(tmp_path, status="running", measurements=[], time=0.0)
    pages = []

    def sleep(seconds: float) -> None:
        assert seconds == 2.0
        pages.append((tmp_path / "report.html").read_text(encoding="utf-8"))
        if len(pages) == 3:
            write_tables(tmp_path)

    monkeypatch.setattr(watch.time, "sleep", sleep)
    with lock_folder(tmp_path):
        last = report(tmp_path, "--watch", "--interval", "2")
    assert len(pages) == 3
    for page in pages:
        assert data(page)["reload"] == 2.0
        # run.json says nothing yet of how far the run is, its history does
        assert "<dt>simulated</dt><dd>0.02 s</dd>" in page
        assert "They are made at the end of the run." in page
    assert data(last)["reload"] is None
    assert "finished" in last


def test_a_watch_ends_with_a_run_that_was_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_run(tmp_path, status="running")
    monkeypatch.setattr(watch.time, "sleep", lambda seconds: pytest.fail("there is nothing to wait for"))
    assert "stopped without an error message" in report(tmp_path, "--watch")


def test_a_run_that_ends_while_it_is_looked_at_is_finished(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_run(tmp_path, status="running")

    def let_go(folder: Path) -> bool:
        write_tables(folder)
        return False

    monkeypatch.setattr("warp_mps.app.report.run_data.is_locked", let_go)
    assert read_run(tmp_path).state == "done"


def test_what_cannot_be_reported_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def refusal(*arguments: str) -> str:
        assert main(["report", *arguments]) == 2
        text = capsys.readouterr().err
        assert text.count("\n") == 1
        return text

    assert "is not a folder" in refusal(str(tmp_path / "none"))
    assert "does not contain a run" in refusal(str(tmp_path))
    RunSummary(case="early").write(tmp_path / "run.json")
    assert "must end in .html" in refusal(str(tmp_path), "--out", "a.pdf")
    assert "must be 1 or more seconds" in refusal(str(tmp_path), "--watch", "--interval", "0")
    (tmp_path / "report.html").write_text("kept", encoding="utf-8")
    assert "exists; use --overwrite" in refusal(str(tmp_path))
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == "kept"
    assert "cannot be written" in refusal(str(tmp_path), "--out", str(tmp_path / "run.json" / "a.html"))
