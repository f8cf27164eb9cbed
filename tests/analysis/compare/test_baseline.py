"""Baselines: equal runs are equal to the bit; differences are reported with place and size."""

from __future__ import annotations

import json
import shutil
import weakref

import pytest
from command_line import cdpr_here
from compare_cases import ENGINES, SCENARIOS

from cdpr.analysis.compare import baseline, baseline_check, baseline_file
from cdpr.base.checksums import sealed
from cdpr.base.errors import CdprError, OutputError

SHORT = ["simulation.duration=0.1"]


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """A copy of the scenarios, with a baseline beside them."""
    root = tmp_path_factory.mktemp("home")
    shutil.copytree(SCENARIOS, root / "scenarios")
    baseline_check.save([str(root / "scenarios" / "caroca.yaml")], root / "kept", overrides=SHORT)
    return root


@pytest.fixture
def kept(home, tmp_path):
    """Scenarios and baseline, to be spoilt."""
    shutil.copytree(home, tmp_path / "home")
    return tmp_path / "home"


def edit(home, change):
    """Change the content of the baseline; return the output of a check."""
    (path,) = (home / "kept").iterdir()
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(sealed(data)))
    (found,) = baseline_check.check(home / "kept")
    return found


def test_the_same_again_is_bit_equal(kept):
    (found,) = baseline_check.check(kept / "kept")
    assert (found.name, found.outcome, found.detail) == ("caroca_reference", "bit-equal", "")


def test_it_is_self_contained(kept):
    """Without the scenario's file it is checked by what it holds."""
    shutil.rmtree(kept / "scenarios")
    (found,) = baseline_check.check(kept / "kept")
    assert found.outcome == "bit-equal"


def test_it_can_be_read_by_people_and_loses_nothing(home):
    (path,) = (home / "kept").iterdir()
    text = path.read_text()
    assert len(text) < 16_000
    assert max(map(len, text.splitlines())) < 600  # a sample a line
    read = baseline_file.read(path)
    assert len(read.samples["time"]) == baseline.SAMPLES
    assert read.samples["time"][[0, -1]].tolist() == [0.0, 0.1]
    assert baseline_file.text_of(read) == text
    assert "kp: 100" in read.scenario_yaml


def spoil(data, column, by, row=3):
    data["digest"] = "0" * 64
    data["samples"][row][column] += by


def test_another_tension_is_reported_with_cable_time_and_size(kept):
    found = edit(kept, lambda data: spoil(data, 1 + 13 + 4, 0.5))
    assert (found.outcome, found.agrees) == ("differs", False)
    assert "tension of cable_5 differs first at t = 0.012 s, by 5.00e-01 N (allowed 1e-07)" in found.detail


def test_another_position_is_reported(kept):
    found = edit(kept, lambda data: spoil(data, 2, 1e-6, row=-1))
    assert "position differs first at t = 0.1 s, by 1.00e-06 m" in found.detail


def test_the_last_bit_counts_on_the_same_versions_and_machine(kept):
    found = edit(kept, lambda data: spoil(data, 2, 1e-15))
    assert found.outcome == "differs"
    assert (
        "not bit-equal, though versions and machine are the same; largest differences: position 1.0e-15" in found.detail
    )


@pytest.mark.parametrize(("part", "key"), [("versions", "numpy"), ("machine", "processor")])
def test_bounds_count_on_others(kept, part, key):
    def change(data):
        spoil(data, 2, 1e-15)
        data[part][key] = "other"

    found = edit(kept, change)
    assert (found.outcome, found.agrees) == ("within bounds", True)
    assert f"{key} other -> " in found.detail


def test_bounds_are_those_of_the_file(kept):
    def change(data):
        spoil(data, 2, 1e-6)
        data["machine"]["processor"] = "other"
        data["bounds"]["position"] = 1e-5

    assert edit(kept, change).outcome == "within bounds"


def test_a_changed_scenario_is_reported_as_changed(kept):
    path = kept / "scenarios" / "caroca.yaml"
    path.write_text(path.read_text().replace("kp: 100 ", "kp: 90 "))
    (found,) = baseline_check.check(kept / "kept")
    assert found.outcome == "differs"
    remedy = "if the change is intended, save the baseline again (--force)"
    assert f"caroca.yaml has changed: controller.kp was 100.0, is 90.0; {remedy}" in found.detail
    path.write_text("robot: 7\n")
    (found,) = baseline_check.check(kept / "kept")
    assert "has changed and is now invalid" in found.detail


def test_another_end_is_reported(kept):
    assert "was infeasible and is finished" in edit(kept, lambda data: data.update(status="infeasible")).detail
    found = edit(kept, lambda data: data.update(status="finished", count=102))
    assert "had 102 samples and has 101" in found.detail


def test_a_jumping_solver_is_not_held_to_its_tensions(home, tmp_path):
    (path,) = baseline_check.save(
        [str(SCENARIOS / "caroca.yaml")], tmp_path, overrides=[*SHORT, "solver.type=lp"], backends=[ENGINES[0]]
    )
    assert path.name == f"caroca_{ENGINES[0]}.baseline.json"
    assert set(baseline_file.read(path).bounds) == {"position", "attitude"}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda data: data["samples"].pop(3), "the numbers of indices and samples differ"),
        (lambda data: data["samples"][3].pop(), "the numbers of columns and values in a sample differ"),
        (lambda data: data["samples"][3].append("x"), "samples: 3: 22: expected a number, got 'x'"),
        (lambda data: data["indices"].reverse(), "the numbers of indices and samples differ"),
        (lambda data: data.update(count=7), "the numbers of indices and samples differ"),
        (lambda data: data.update(samples=[], indices=[]), "samples: "),
        (lambda data: data.update(bounds=None), "bounds: expected a mapping, got null"),
        (lambda data: data["bounds"].update(taste=1.0), "not of taste"),
        (lambda data: data["bounds"].update(position=-1.0), "bounds: position: "),
        (lambda data: data.update(columns={}), "columns are those of position, "),
        (lambda data: data.update(versions=["numpy"]), "versions: "),
        (lambda data: data.update(more=1), "more: "),
        (lambda data: data.pop("digest"), "digest: "),
    ],
)
def test_a_spoilt_baseline_is_refused(kept, change, said):
    with pytest.raises(CdprError, match=r"cannot be read as a baseline: .*; save it again") as caught:
        edit(kept, change)
    assert said in str(caught.value)


def test_samples_of_another_robot_are_reported(kept):
    def change(data):
        data["columns"]["tension"] -= 1
        data["samples"] = [row[:-1] for row in data["samples"]]

    assert "it has 8 cables, the samples have 7" in edit(kept, change).detail


def test_the_file_contains_the_indices_of_its_samples(kept, monkeypatch):
    """Another number for new baselines leaves older ones as they are."""
    monkeypatch.setattr(baseline, "SAMPLES", 10)
    found = edit(kept, lambda data: spoil(data, 2, 1e-6, row=-1))
    assert "position differs first at t = 0.1 s, by 1.00e-06 m" in found.detail


@pytest.mark.slow
def test_runs_are_not_kept_in_memory(kept, tmp_path, monkeypatch):
    """Each is let go before the next is read."""
    alive, most, read = [], [], baseline_check.read

    def spy(outcome):
        most.append(sum(run() is not None for run in alive))
        made = read(outcome)
        alive.append(weakref.ref(made.run))
        return made

    monkeypatch.setattr(baseline_check, "read", spy)
    planar, caroca = (str(kept / "scenarios" / f"{name}.yaml") for name in ("planar", "caroca"))
    baseline_check.save([planar, caroca], tmp_path / "two", overrides=SHORT)
    assert len(baseline_check.check(tmp_path / "two")) == 2
    assert most == [0, 0, 0, 0]


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": 9}', '{"format": 1, "samples": 3}'])
def test_invalid_baselines_are_rejected(tmp_path, text):
    (tmp_path / "x.baseline.json").write_text(text)
    with pytest.raises(CdprError, match=r"x\.baseline\.json: cannot be read as a baseline"):
        baseline_check.check(tmp_path)


def test_none_at_all_is_an_error(tmp_path):
    with pytest.raises(CdprError, match="contains no baseline"):
        baseline_check.check(tmp_path)


def test_nothing_is_kept_of_a_run_that_fails(tmp_path):
    wild = ["controller.kp=5e6", "controller.kd=4000", "robot.tension.max=1e7"]
    with pytest.raises(CdprError, match="no baseline of a run that diverged"):
        baseline_check.save([str(SCENARIOS / "caroca.yaml")], tmp_path / "out", overrides=wild)
    assert not (tmp_path / "out").exists()


@pytest.fixture
def no_runs(monkeypatch):
    """Let no baseline run its scenario."""
    monkeypatch.setattr(baseline_check, "run_cases", lambda *_, **__: pytest.fail("a run began"))


def test_two_of_one_name_are_refused(tmp_path, no_runs):
    with pytest.raises(CdprError, match="two baselines would have the name"):
        baseline_check.save([str(SCENARIOS / "caroca.yaml")] * 2, tmp_path / "out", overrides=SHORT)


def test_an_existing_baseline_is_refused_before_the_runs(kept, no_runs):
    with pytest.raises(OutputError, match=r"caroca_reference\.baseline\.json' already exists"):
        baseline_check.save([str(kept / "scenarios" / "caroca.yaml")], kept / "kept", overrides=SHORT)


def test_a_file_in_the_way(tmp_path, home):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        baseline_check.save([str(home / "scenarios" / "caroca.yaml")], tmp_path / "file", overrides=SHORT)


def cdpr(*arguments, code=0):
    return cdpr_here("baseline", *arguments, code=code)


def test_commands(kept):
    planar = kept / "scenarios" / "planar.yaml"
    said = cdpr("save", planar, "--set", SHORT[0], "--out", kept / "kept").stdout
    file = kept / "kept" / "planar_reference.baseline.json"
    assert said.strip() == str(file)
    assert cdpr("check", file).stdout == "planar_reference  bit-equal\n"
    planar.write_text(planar.read_text().replace("kp: 100 ", "kp: 90 "))
    (found,) = json.loads(cdpr("check", file, "--json", code=7).stdout)
    assert found["outcome"] == "differs"
