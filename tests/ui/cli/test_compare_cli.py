"""`cdpr compare` as a user calls it: real processes, terminal, JSON, page, exit codes."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest
from command_line import cdpr_here
from compare_cases import ENGINES, INSTALLED, SCENARIOS, SOUND, comparison

from cdpr.analysis.jobs.cases import Outcome
from cdpr.base.errors import CdprError, ExitCode
from cdpr.ui.cli.compare import command
from cdpr.ui.report.text.compare import lines

CAROCA = str(SCENARIOS / "caroca.yaml")
SHORT = ("--set", "simulation.duration=0.1")
ONE = ("--backends", ENGINES[0])


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    """A comparison, refined, with its folder."""
    folder = tmp_path_factory.mktemp("compare") / "out"
    done = cdpr_here("compare", CAROCA, "--refine", *ONE, *SHORT, "--json", "--out", folder)
    return json.loads(done.stdout), folder


def test_json_is_complete(compared):
    figures, folder = compared
    assert figures["agrees"] is True
    assert figures["judge"] == {"backend": "reference", "order": 4}
    (group,) = figures["groups"]
    (row,) = group["engines"]
    assert (row["backend"], len(row["checks"])) == (ENGINES[0], 6)
    assert row["step_us"] > 0.0
    assert {each["backend"] for each in group["orders"]} == {"reference", ENGINES[0]}
    assert {"cdpr", "numpy"} < set(figures["versions"])
    assert json.loads((folder / "compare.json").read_text()) == figures


def test_text_fits_a_terminal(compared):
    text = list(lines(compared[0]))
    text += lines(comparison("caroca", changes={"simulation.duration": 0.1}, solvers=["lp"]).figures)
    assert text[0].startswith("agree: caroca")
    assert max(map(len, text)) <= 80, max(text, key=len)
    said = "\n".join(text)
    assert "its tensions may jump, the pose is judged" in said
    assert re.search(rf"{ENGINES[0]} +1\.0\d\d of 1 +as declared|{ENGINES[0]} +0\.9\d\d of 1", said)


def test_page_needs_nothing_else(compared):
    html = (compared[1] / "compare.html").read_text()
    assert html.index("The engines agree") < html.index('id="verdict"') < html.index("<svg xmlns")
    assert not re.search(r'(?:src|href)="(?!#)', html.replace("http://www.w3.org", ""))
    for title in (
        "Differences from the reference",
        "Differences beyond the scheme",
        "Pose",
        "Tensions",
        "Measured orders",
    ):
        assert title in html
    assert ENGINES[0] in html
    assert "NaN" not in html[: html.index("<script")]
    verdict = html[html.index('id="verdict"') : html.index('id="robot"')]
    _, row = re.findall(r'<tr><th scope="row">.*?</tr>', verdict)
    assert re.search(r"<td>agrees</td><td>(0\.\d+|\d.*e−\d+) \(", row)  # the worst share of its bound


def test_runs_are_kept_and_can_be_compared_again(compared):
    runs = [compared[1] / "runs" / name for name in ("reference_qp", f"{ENGINES[0]}_qp")]
    said = cdpr_here("compare", *runs, code=7).stdout  # a gate must not accept unjudged differences as agreement
    assert said.startswith("not judged: caroca")
    assert f"{ENGINES[0]}_qp: not judged: no other run has the same scheme" in " ".join(said.split())


@pytest.mark.slow
def test_all_is_all_that_are_installed():
    rows = json.loads(cdpr_here("compare", CAROCA, *SHORT, "--json").stdout)["groups"][0]["engines"]
    assert {row["backend"] for row in rows} == INSTALLED - {"reference"}
    assert {row["outcome"] for row in rows} == {"agrees"}


def test_a_folder_that_is_taken_is_refused(compared):
    assert "not empty" in cdpr_here("compare", CAROCA, *ONE, *SHORT, "--out", compared[1], code=8).stderr


@pytest.mark.slow
def test_an_interrupt_leaves_the_folder_to_the_next_comparison(tmp_path, monkeypatch):
    """With and without an existing folder."""

    def interrupted(cases, *, done, **options):
        for case in cases[:1]:
            (Path(case.out)).mkdir(parents=True)
            done(Outcome(case.key, "finished", "", case.out))
        raise KeyboardInterrupt

    for folder in (tmp_path / "new", tmp_path / "there"):
        with monkeypatch.context() as patch:
            patch.setattr("cdpr.analysis.compare.runs.run_cases", interrupted)
            if folder.name == "there":
                folder.mkdir()
            done = cdpr_here("compare", CAROCA, *ONE, *SHORT, "--out", folder, code=130)
        assert not done.stdout
        told = f"interrupted after 1 of 3 runs: no result of the comparison is stored, and {folder} can be used again"
        assert done.stderr.splitlines()[-1] == told
        assert [path.name for path in tmp_path.iterdir()] == [folder.name] * (folder.name == "there")
        cdpr_here("compare", CAROCA, *ONE, *SHORT, "--out", folder)
        assert sorted(path.name for path in folder.iterdir()) == ["compare.html", "compare.json", "runs"]
        shutil.rmtree(folder)


def test_a_full_disk_is_no_disagreement(tmp_path, monkeypatch):
    def full(cases, *, done, **options):
        done(
            Outcome(
                cases[0].key, "failed", "log.mcap: cannot be written: No space left", "", code=ExitCode.NOT_WRITABLE
            )
        )

    monkeypatch.setattr("cdpr.analysis.compare.runs.run_cases", full)
    phase = ("--set", 'events=[{"type": "sine", "time": 0, "force": [1, 0, 0], "frequency": 1, "phase": 90}]')
    done = cdpr_here("compare", CAROCA, *ONE, *SHORT, *phase, "--out", tmp_path / "out", code=8)
    assert "events[0].phase: 90 rad is more than a whole turn" in done.stderr  # compare prints the scenario's notes
    assert done.stderr.splitlines()[-1] == "log.mcap: cannot be written: No space left"
    assert "DISAGREE" not in done.stdout
    assert not list(tmp_path.iterdir())


def test_a_folder_of_others_is_not_emptied_by_an_interrupt(tmp_path):
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / "mine").write_text("years of work")
    cdpr_here("compare", CAROCA, *ONE, *SHORT, "--out", tmp_path, code=8)
    assert (tmp_path / "runs" / "mine").read_text() == "years of work"


@pytest.mark.slow
@pytest.mark.usefixtures("traps_plugin")
def test_a_trap_ends_with_seven(tmp_path):
    """In workers, too; the top of the page states plugin and reason."""
    options = ("--set", f"backend_options.traps.engine={ENGINES[0]}", "--set", "backend_options.traps.trap=lag")
    words = ("compare", CAROCA, "--backends", "traps", *options, *SHORT, "--out", str(tmp_path / "out"))
    done = cdpr_here(*words, code=7)
    assert done.stdout.startswith("DISAGREE: caroca")
    assert "traps: DISAGREES: position beyond its bound" in done.stdout
    html = (tmp_path / "out" / "compare.html").read_text()
    assert html.index("traps with qp: position beyond its bound") < html.index("<svg")


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        ((CAROCA, "--backends", "mujuco"), 3, "did you mean 'mujoco'"),
        ((CAROCA, "--backends", "reference"), 2, "nothing to compare"),
        ((CAROCA, "--solvers", "qq"), 3, "no solver is named 'qq'"),
        (("missing.yaml",), 2, "missing.yaml"),
        ((CAROCA, "--set", "simulation.duration=-1"), 2, "simulation.duration"),
        ((str(SCENARIOS), "--refine"), 2, "finished runs cannot be changed"),
        ((str(SCENARIOS),), 2, "two or more runs, got one"),
        ((CAROCA, str(SCENARIOS)), 2, "is not a run: give either one SCENARIO"),
    ],
)
def test_incomparable_runs_are_rejected(arguments, code, said):
    with pytest.raises(CdprError, match=said) as caught:
        command.main(list(arguments), standalone_mode=False)
    assert caught.value.exit_code == code


@pytest.mark.slow
@pytest.mark.parametrize("name", SOUND)
def test_sound_engines_agree_and_are_of_their_order(name):
    """Every scenario to its end, refined: 1.0 +- 0.1, and 4 +- 0.3 above round-off."""
    figures = json.loads(cdpr_here("compare", SCENARIOS / f"{name}.yaml", "--refine", "--json").stdout)
    assert figures["agrees"] is True
    for each in figures["groups"][0]["orders"]:
        room = 0.3 if each["declared"] == 4 else 0.1
        assert each["outcome"] == "as declared"
        assert each["order"] == pytest.approx(each["declared"], abs=room)
