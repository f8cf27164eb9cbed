"""The pages in docs/: tables as their scripts write them, claims as new runs have them."""

from __future__ import annotations

import itertools
import json
import re
import xml.etree.ElementTree as ET

import columns
import numpy as np
import pytest
import scenario_files
import teaching
import teaching_controllers
import teaching_vision
import thesis
import works_where
import yaml
from click.testing import CliRunner
from conftest import ROOT
from docs_cases import PAGES, commands, words
from plants import installed

from cdpr.ui.cli import cli

DOCS = ROOT / "docs"
SCRIPTS = {
    "thesis.md": thesis,
    "teaching.md": teaching,
    "columns.md": columns,
    "works_where.md": works_where,
    "scenario_files.md": scenario_files,
}
ROWS = thesis.results()
STUDY, BELIEF = (yaml.safe_load(each.read_text()) for each in (thesis.STUDY, thesis.BELIEF))
CASE = ("caroca", "three", "pseudo_inverse")
POINTS = {axis["name"]: axis["points"] for axis in STUDY["axes"] if "points" in axis}

# Stored figures have five digits; a run of another numpy or processor may differ by rounding, which grows.
SAME = 1e-3
TO_ROUND_OFF = 1e-12  # mm; positions of about 1 m have units in the last place of 2e-13 mm


@pytest.mark.parametrize("name", SCRIPTS)
def test_tables_are_up_to_date(name):
    text = (DOCS / name).read_text()
    assert SCRIPTS[name].updated(text) == text, f"run: python docs/{name.replace('.md', '.py')}"


@pytest.mark.parametrize("name", SCRIPTS)
def test_links_lead_somewhere(name):
    targets = re.findall(r"\]\(([^)#:]+)\)", (DOCS / name).read_text())
    assert targets
    assert [target for target in targets if not (DOCS / target).exists()] == []


@pytest.mark.parametrize("name", teaching.LABELS)
def test_pictures_are_small_and_sound(name):
    picture = DOCS / f"teaching_{name}.svg"
    assert picture.stat().st_size < 60_000
    assert ET.parse(picture).getroot().get("aria-label") == teaching.LABELS[name]


@pytest.mark.slow
def test_thesis_csv_holds_the_cases_of_the_study_and_of_the_plants():
    cases = [tuple(row[name] for name in thesis.AXES) for row in ROWS]
    assert len(set(cases)) == len(cases)
    study = [
        (case.block, *(str(case.labels.get(axis, "")) for axis in thesis.AXES[1:]))
        for part in thesis.PARTS
        for case in thesis.study_cases(part)
    ]
    assert [case for case in cases if case[0] not in thesis.PLANTS] == study
    robots, gains = 2 * 2, 4
    plants = sum(len(plant.starts) * len(plant.solvers) for plant in thesis.PLANTS.values())
    assert len(cases) - len(study) == plants * robots * gains


def table_of_a_study(cases, **changed):
    """Lines of a table.csv with these cases."""
    row = {"case": "", "block": "as_written", "status": "finished", "message": "", **dict.fromkeys(thesis.FIGURES, 1.0)}
    rows = [{**row, "case": case.id, **changed} for case in cases]
    return "\n".join(",".join(map(str, cells)) for cells in (row, *(row.values() for row in rows))) + "\n"


def wrong_tables():
    cases = thesis.study_cases()
    yield table_of_a_study(cases[:-1]), "of its 640 cases 639 are among the table's 639"
    yield table_of_a_study(cases, case="0f"), "of its 640 cases 0 are among the table's 640"
    yield table_of_a_study(cases, status="not run"), f"case {cases[0].id} is 'not run'"
    yield "robot,mass\ncaroca,100\n", "of its 640 cases 0 are among the table's 1"
    yield "", "of its 640 cases 0 are among the table's 0"
    yield None, "No such file"


@pytest.mark.slow
def test_the_thesis_page_refuses_another_study(tmp_path):
    """Its script ends with one line, before it computes or overwrites anything."""
    before = {path: path.read_bytes() for path in (thesis.PAGE, thesis.RESULTS)}
    for text, message in wrong_tables():
        (tmp_path / "table.csv").unlink(missing_ok=True)
        if text is not None:
            (tmp_path / "table.csv").write_text(text)
        with pytest.raises(SystemExit, match=re.escape(message)) as told:
            thesis.main(tmp_path)
        assert "\n" not in str(told.value)
        assert f"run: cdpr study scenarios/studies/thesis_ch6.yaml --out {tmp_path}" in str(told.value)
    assert {path: path.read_bytes() for path in before} == before
    for study in thesis.PARTS:
        (tmp_path / "table.csv").write_text(table_of_a_study(thesis.study_cases(study)))
        assert thesis.study_of(tmp_path) == study
        assert len(thesis.stored(tmp_path, study)) == len(thesis.study_cases(study))


def changes_of(block, start, geometry, dof, solver, gain):
    """Return the changes of the study for one of its cases."""
    (found,) = [item for item in STUDY["blocks"] if item["name"] == block]
    axes = {axis["name"]: axis.get("points", {}) for axis in found.get("axes", [])}
    parts = [found["changes"], POINTS["geometry"][geometry], POINTS["controlled"][dof], POINTS["solver"][solver]]
    parts += [axes["start"][start]] if start else []
    return {key: value for part in parts for key, value in part.items()} | {
        "controller.kp": gain,
        "controller.kd": gain,
    }


@pytest.mark.parametrize("geometry", ["caroca", "cube"])
@pytest.mark.parametrize("solver", list(thesis.PUBLISHED))
def test_stored_runs_come_out_the_same(geometry, solver):
    case = ("off_the_start", "0.3 m below", geometry, "six", solver, 800)
    run = teaching.simulate("thesis_ch6.yaml", changes_of(*case))
    (row,) = thesis.find(
        ROWS, **dict(zip(("block", "start", "geometry", "controlled", "solver"), case, strict=False)), gain="800"
    )
    assert run.status == row["status"] == "finished"
    assert run.tension.max() == pytest.approx(float(row["tension_max_N"]), rel=SAME)


def test_a_plant_of_the_thesis_comes_out_the_same():
    changes = {**POINTS["geometry"]["cube"], **POINTS["controlled"]["three"], **POINTS["solver"]["pseudo_inverse"]}
    same = {"simulation.duration": 1.0, "simulation.control_step": 0.01, "controller.kp": 800, "controller.kd": 800}
    run = thesis.plant_run(thesis.PLANTS["one_step"], {**changes, **same})
    (row,) = thesis.find(ROWS, block="one_step", start="", geometry="cube", controlled="three", gain="800")[2:3]
    assert row["solver"] == "pseudo_inverse"
    assert run.tension.max() == pytest.approx(float(row["tension_max_N"]), rel=SAME)


HELD = {**POINTS["solver"]["pseudo_inverse"], "initial.position": [0, -1.99, 2], "simulation.control_step": 0.01}


@pytest.mark.parametrize(
    ("gain", "step", "status"), [(195, 0.01, "finished"), (205, 0.01, "diverged"), (1500, 0.001, "finished")]
)
def test_a_command_held_10_ms_is_unstable_above_gain_200(gain, step, status):
    changes = {**HELD, "simulation.control_step": step, "simulation.duration": 4.0}
    run = teaching.simulate("thesis_ch6.yaml", {**changes, "controller.kp": gain, "controller.kd": gain})
    assert run.status == status


@pytest.mark.slow
@pytest.mark.parametrize(("gain", "stable"), [(3315, True), (3485, False)])
def test_nominal_mass_of_1_kg_of_17_allows_17_times_the_command(gain, stable):
    """An unstable run ends at the limits of the legs, 66501 N."""
    robot = thesis.points(thesis.BELIEF)[0]["cube"]
    run = teaching.simulate(
        "thesis_ch6.yaml",
        {**robot, **HELD, "simulation.duration": 4.0, "controller.kp": gain, "controller.kd": gain},
    )
    assert (run.tension.max() < 1e3) == stable
    assert (run.tension.max() > 1e4) != stable


def test_nominal_mass_of_1_kg_of_17_gives_the_same_motion():
    """A case of the study, its sag as theory has it, and a plant."""
    geometry, controlled, solver = (axis[name] for axis, name in zip(thesis.points(thesis.BELIEF), CASE, strict=True))
    (block,) = [item for item in BELIEF["blocks"] if item["name"] == "moves_17_kg_held"]
    changes = {**block["changes"], **geometry, **controlled, **solver, "controller.kp": 800, "controller.kd": 800}
    run = teaching.simulate("thesis_ch6.yaml", changes)
    same = dict(zip(("geometry", "controlled", "solver"), CASE, strict=True))
    (row,) = thesis.find(ROWS, block="moves_17_kg_held", gain="800", **same)
    assert run.tension.max() == pytest.approx(float(row["tension_max_N"]), rel=SAME)
    assert run.position_error[-1, 2] == pytest.approx(16 * 9.8 / 800, rel=SAME)
    assert float(row["position_error_max_m"]) == pytest.approx(16 * 9.8 / 800, rel=0.02)
    times = {"simulation.duration": 1.0, "simulation.control_step": 0.01, "controller.kp": 800, "controller.kd": 800}
    plant = thesis.PLANTS["moves_17_kg_held_friction"]
    run = thesis.plant_run(plant, {**geometry, **controlled, **solver, **times})
    (row,) = thesis.find(ROWS, block="moves_17_kg_held_friction", gain="800", **same)
    assert run.tension.max() == pytest.approx(float(row["tension_max_N"]), rel=SAME)


@pytest.mark.slow
def test_a_command_of_one_step_rings_above_1000_and_is_unstable_above_2000():
    def went(gain):
        changes = {**HELD, "simulation.duration": 4.0, "controller.kp": gain, "controller.kd": gain}
        run = thesis.plant_run(thesis.PLANTS["one_step"], changes)
        turns = np.diff(np.sign(np.diff(run.wrench[:50, 1])))
        return run.tension.max(), int(np.count_nonzero(turns))

    assert went(900)[1] == 0
    assert went(1500)[1] > 5
    assert went(1950)[0] < 200.0
    assert went(2050)[0] > 1e4


def largest(block, start="", **wanted):
    rows = [row for row in thesis.find(ROWS, block=block, start=start, **wanted) if row["status"] == "finished"]
    return np.array([float(row["tension_max_N"]) for row in rows])


def test_text_of_the_thesis_page_matches_its_table():
    """Each number of its prose that no table shows as such."""
    pinv = np.concatenate([largest("as_written", geometry=g, solver="pseudo_inverse") for g in ("caroca", "cube")])
    assert pinv.max() <= 8.2
    assert np.sqrt(8) * thesis.PUBLISHED["qp"][0] == pytest.approx(90.5, abs=0.1)
    assert thesis.PUBLISHED["pseudo_inverse"][0] > 91
    steps = [
        row for row in thesis.find(ROWS, block="one_step", start="", solver="pseudo_inverse") if row["gain"] != "1500"
    ]
    assert all(55 < float(row["tension_max_N"]) < 95 for row in steps)
    swayed = [float(row["position_error_max_m"]) for row in thesis.find(ROWS, block="as_written", solver="qp")]
    assert 0.3 < min(swayed) < max(swayed) < 0.9
    for geometry, high in (("caroca", 304), ("cube", 83)):
        rows = thesis.find(ROWS, block="as_written", geometry=geometry, controlled="six", solver="closed_form")
        assert all(abs(float(row["tension_max_N"]) - high) < 1 for row in rows)
    wild = np.concatenate(
        [largest("friction", s, controlled="three", solver="closed_form") for s in ("", "0.3 m below")]
    )
    assert len(wild) == 16
    assert 600 < wild.min() < wild.max() < 5000
    pairs = zip(thesis.find(ROWS, solver="lp"), thesis.find(ROWS, solver="qp"), strict=True)
    ratios = [
        float(lp["tension_max_N"]) / float(qp["tension_max_N"])
        for lp, qp in pairs
        if lp["status"] == qp["status"] == "finished"
    ]
    assert 1.7 < max(ratios) < 1.8
    shown = {
        "75 / 586 / 878": {"block": "off_the_start", "start": "far away", "geometry": "cube", "controlled": "six"},
        "115 / 857 / 1281": {
            "block": "or_lowest",
            "start": "0.3 m inwards",
            "geometry": "caroca",
            "controlled": "three",
        },
    }
    for text, case in shown.items():
        assert thesis.cell(thesis.find(ROWS, **case, solver="lp")[:3]) == text
    assert all(row["status"] == "finished" for row in thesis.find(ROWS, block="friction"))
    heavy = ("moves_17_kg", "moves_17_kg_held", "moves_17_kg_held_friction")
    pinv = [row for block in heavy for row in thesis.find(ROWS, block=block, solver="pseudo_inverse")]
    assert len(pinv) == 48
    tensions = np.array([[float(row[f"tension_{end}_N"]) for end in ("min", "max")] for row in pinv])
    assert 91.5 < tensions[:, 1].min() < tensions[:, 1].max() < 131.5
    assert -31.5 < tensions[:, 0].min() < tensions[:, 0].max() < -3.5
    for geometry, dof, block in itertools.product(("caroca", "cube"), ("six", "three"), heavy):
        low, *rest = largest(block, geometry=geometry, controlled=dof, solver="pseudo_inverse")
        assert max(rest) - min(rest) <= 3.0
        assert 0.79 < low / rest[0] < 0.9
    for solver, (low, high, most) in {"qp": (93, 150, 276), "lp": (93, 173.5, 323.5)}.items():
        rows = [row for block in heavy for row in thesis.find(ROWS, block=block, solver=solver)]
        first = [float(row["tension_max_N"]) for row in rows if row["gain"] == "100"]
        assert low - 0.5 < min(first) < max(first) < high
        assert max(float(row["tension_max_N"]) for row in rows if row["gain"] == "1200") < most
    falls = thesis.find(ROWS, block="moves_17_kg_one_step", solver="pseudo_inverse")
    assert all(abs(float(row["position_error_max_m"]) - 17.66) < 0.1 for row in falls if row["gain"] == "100")
    assert all(445 < float(row["tension_max_N"]) < 1085 for row in falls if row["gain"] in ("100", "1200"))
    assert "No assumption" in thesis.PAGE.read_text()
    assert all(float(line.split("|")[-2]) > 1.1 for line in thesis.nearest().splitlines()[2:])


def command_of(name, tmp_path, *more, code=0):
    """Output of a command of the teaching page with --json."""
    mark = rf"<!-- command of {name} -->\n(.*?)<!-- end"
    (command,) = commands(re.search(mark, PAGES["docs/teaching.md"], re.DOTALL)[1])
    done = CliRunner().invoke(cli, [*words(command), *more, "--json", "--out", str(tmp_path / "out")])
    assert done.exit_code == code, done.output
    return json.loads(done.stdout)


@pytest.fixture
def at_root(monkeypatch):
    monkeypatch.chdir(ROOT)


@pytest.mark.usefixtures("at_root")
class TestCommandsOfTheTeachingPageGiveItsTables:
    STORED = teaching.results()

    def test_there_are_no_others(self):
        assert len(commands(PAGES["docs/teaching.md"])) == len(teaching.COMMANDS)

    def test_solvers(self, tmp_path):
        said = command_of("solvers", tmp_path, "--no-report")
        row = self.STORED["solvers"]["maximin"]
        assert 1e3 * said["position_error_m"]["max"] == pytest.approx(row["error_mm"], rel=SAME)
        told = [said["tension_N"][name] for name in ("min", "max", "largest_step")]
        assert told == pytest.approx([row["lowest_N"], row["highest_N"], row["jump_N"]], rel=SAME)

    def test_gains(self, tmp_path):
        said = command_of("gains", tmp_path, "--no-report")
        assert said["tension_N"]["max"] == pytest.approx(self.STORED["gains"]["400"]["highest_N"], rel=SAME)

    def test_rates(self, tmp_path):
        said = command_of("rates", tmp_path, "--no-report")
        stored = self.STORED["rates"]
        assert 1e3 * said["position_error_m"]["final"] == pytest.approx(stored["1 kHz"]["205"], rel=SAME)
        assert stored["100 Hz"]["205"] is None
        slow = ["--no-report", "--set", "simulation.control_step=0.01"]
        assert command_of("rates", tmp_path / "slow", *slow, code=5)["status"] == "diverged"

    def test_controllers(self, tmp_path):
        said = command_of("controllers", tmp_path, "--no-report")
        stored = self.STORED["controllers"]["sliding_mode"]["mass"]
        told = [1e3 * said["position_error_m"][name] for name in ("max", "final")]
        assert told == pytest.approx([stored["largest_mm"], stored["end_mm"]], rel=SAME)

    def test_vision(self, tmp_path):
        errors = command_of("vision", tmp_path, "--no-report")["position_error_m"]
        stored = self.STORED["vision"]["visual_servo"]["mass"]
        told = 1e3 * errors["max"], 1e3 * errors["final"]
        assert told == pytest.approx((stored["largest_mm"], stored["end_mm"]), rel=SAME)

    @pytest.mark.slow  # engines in processes of their own
    def test_steps(self, tmp_path):
        (engine,) = command_of("steps", tmp_path)["groups"][0]["engines"]
        apart = 1e3 * engine["differences"]["position"]["max"]
        assert apart == pytest.approx(self.STORED["steps"][engine["label"]]["2"], rel=SAME)

    @pytest.mark.slow
    def test_engines(self, tmp_path):
        (group,) = command_of("engines", tmp_path)["groups"]
        stored = self.STORED["engines"]
        told = {engine["label"]: 1e3 * engine["differences"]["position"]["max"] for engine in group["engines"]}
        assert told == pytest.approx(stored["reference"], rel=SAME)
        assert 1e3 * group["same_scheme"]["semi_implicit_euler"]["position"] < TO_ROUND_OFF


def test_text_of_the_teaching_page_on_controllers_matches_its_tables():
    stored = teaching.results()["controllers"]
    plain, cells, sliding, adaptive = (stored[name] for name in teaching_controllers.CONTROLLERS)
    assert all(10.0 < row["delay"]["largest_mm"] < 10.5 for row in stored.values())
    assert cells["friction"]["largest_mm"] < 0.1 * plain["friction"]["largest_mm"]
    assert cells["mass"]["largest_mm"] == pytest.approx(plain["mass"]["largest_mm"], rel=0.01)
    assert sliding["delay_ms"] < min(row["delay_ms"] for name, row in stored.items() if name != "sliding_mode")
    assert sliding["change_N"]["noise"] == max(row["change_N"]["noise"] for row in stored.values())
    assert adaptive["mass"]["end_mm"] < 1e-3 < adaptive["mass"]["largest_mm"]
    assert adaptive["change_N"] == pytest.approx(plain["change_N"], rel=0.01)
    like = {"type": "computed_torque", "kp": 500, "kd": 60}
    run = teaching.simulate("caroca.yaml", {**teaching_controllers.CASES["mass"][1], "controller": like})
    assert teaching_controllers.errors(run).max() == pytest.approx(sliding["mass"]["largest_mm"], rel=0.01)


@pytest.mark.parametrize("case", list(teaching_controllers.CASES))
@pytest.mark.parametrize("name", teaching_controllers.CONTROLLERS)
@pytest.mark.usual("computed_torque-mass", "tension_feedback-friction", "sliding_mode-noise", "adaptive-mass")
def test_controllers_of_the_teaching_page_come_out_the_same(name, case):
    error = teaching_controllers.errors(teaching.simulate("caroca.yaml", teaching_controllers.changes_of(name, case)))
    stored = teaching.results()["controllers"][name][case]
    assert error.max() == pytest.approx(stored["largest_mm"], rel=SAME)


def test_text_of_the_teaching_page_on_the_camera_matches_its_table():
    plain, vision = (teaching.results()["vision"][name] for name in teaching_vision.SENSORS)
    assert vision["delay"]["largest_mm"] < 1.1 * vision["exact"]["largest_mm"] < 0.1 * plain["delay"]["largest_mm"]
    assert vision["delay_ms"] > plain["delay_ms"]
    assert vision["change_N"]["noise"] < 0.5 * plain["change_N"]["noise"]
    assert vision["noise"]["largest_mm"] > 10.0 * plain["noise"]["largest_mm"]
    assert vision["mass"]["end_mm"] == pytest.approx(100.0 / 25.0 * plain["mass"]["end_mm"], rel=0.01)
    assert vision["friction"]["end_mm"] > plain["friction"]["end_mm"]


@pytest.mark.parametrize("case", list(teaching_controllers.CASES))
@pytest.mark.parametrize("name", list(teaching_vision.SENSORS))
@pytest.mark.usual("visual_servo-noise", "computed_torque-delay")
def test_the_camera_of_the_teaching_page_comes_out_the_same(name, case):
    """All markers stay in the image."""
    run = teaching.simulate(teaching_vision.SCENARIO, teaching_vision.changes_of(name, case))
    stored = teaching.results()["vision"][name][case]
    assert teaching_controllers.errors(run).max() == pytest.approx(stored["largest_mm"], rel=SAME)
    if name == "visual_servo":
        assert run["camera_seen"].all()


@pytest.mark.skipif(len(installed(*teaching.BACKENDS)) < len(teaching.BACKENDS), reason="an engine is not installed")
def test_engines_of_the_teaching_page_come_out_the_same():
    """Results of its slow commands, from runs in this process."""
    stored = teaching.results()
    coarse, fine = teaching.motion("mujoco", 0.002), teaching.motion("reference", 0.0005)
    assert 1e3 * teaching.apart(coarse, fine).max() == pytest.approx(stored["steps"]["mujoco"]["2"], rel=SAME)
    runs = {name: teaching.motion(name, 0.001) for name in teaching.BACKENDS[1:]}
    for a, b in itertools.combinations(runs, 2):
        assert 1e3 * teaching.apart(runs[a], runs[b]).max() < TO_ROUND_OFF
        assert stored["engines"][a][b] == stored["engines"][b][a] < TO_ROUND_OFF


def test_orders_on_the_teaching_page():
    for name, each in teaching.results()["steps"].items():
        first, second, ratio, within = ("2", "4", 16.0, 0.1) if name == "reference" else ("1", "2", 2.0, 0.02)
        assert each[second] / each[first] == pytest.approx(ratio, rel=within)
