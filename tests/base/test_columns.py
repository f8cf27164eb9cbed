"""The one table of columns: what follows from it agrees with it; columns that plugins declare."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import ROOT
from log_cases import make_header, make_rows, same_bits, write_log

import cdpr
from cdpr.base.column import CABLES, Column
from cdpr.base.columns import FIRST, GROUPS, TOPICS, UNCERTAINTY, WINCHED, known_columns
from cdpr.base.errors import LogError, PluginError
from cdpr.base.lazy import LATE, late
from cdpr.log.export import column_names, export
from cdpr.log.header import Header
from cdpr.log.ros2 import encode
from cdpr.log.run import Run
from cdpr.log.topics import run_topics
from cdpr.plugins import Backend, Controller, PluginInfo, TensionSolver
from cdpr.simulation.columns import CONDITIONS, columns_of
from cdpr.tension import Status
from cdpr.testing import check_factory
from cdpr.ui.cli import cli
from cdpr.ui.report.pages.run import render

pytestmark = pytest.mark.core

CAROCA = ROOT / "scenarios" / "caroca.yaml"
SHORT = {"simulation.duration": 0.02}
MORE = (
    Column("wind", 3, "m/s", "Wind", "world"),
    Column("tilt", 4, "", "Tilt", "world", owner="backend"),
    Column("slack", CABLES, "m", "Slack", owner="solver"),
    Column("count", 1, "", "Calls", owner="controller"),
    Column("gains", 5, "1/s^2", "Gains {of} <it>", owner="controller"),
)
# The status of a run is another thing.
RENAMED = {"status": "solver_status"}


class Told(Controller):
    """carries the weight, and logs it"""

    columns = (Column("effort", 6, "N, N m", "Wrench that it requires", "world"), Column("calls", 1, "", "Calls"))

    def log(self, columns):
        self.effort, self.calls = columns["effort"], columns["calls"]

    def reset(self):
        self.calls[:] = 0.0

    def control(self, time, state, desired, out):
        out[:] = 0.0
        out[:3] = -self.robot.platform.mass * self.gravity
        self.effort[:] = out
        self.calls += 1.0


class Weighing(TensionSolver):
    columns = (Column("least", CABLES, "N", "Least tensions"),)

    def log(self, columns):
        self.least = columns["least"]

    def solve(self, W, wrench, t_min, t_max, tension):
        tension[:] = self.least[:] = np.linalg.pinv(W) @ wrench
        return Status.OK


class Ageing(Backend):
    """A plant that does not move, but counts."""

    columns = (Column("age", 1, "s", "Time since the reset"),)

    def log(self, columns):
        self.age = columns["age"]

    def reset(self, state):
        self.state[:] = state
        self.age[:] = 0.0

    def step(self, n):
        self.age += n * self.physics_step


def test_every_column_is_an_attribute_of_a_run_with_the_words_of_the_table():
    run = Run(make_header(3), make_rows(make_header(3), 4))
    for column in FIRST:
        name = RENAMED.get(column.name, column.name)
        assert getattr(Run, name).__doc__ == column.sentence
        value = getattr(run, name)
        assert same_bits(value, run[column.name])
        assert value.shape == ((4,) if column.width == 1 else (4, column.width or 3))
    assert {column.name for column in WINCHED} == {"cable_tension"}
    for column, condition in known_columns().values():
        if column in FIRST:
            continue
        assert isinstance(getattr(Run, column.name), property)
        if column not in WINCHED:
            with pytest.raises(AttributeError, match=re.escape(f"{column.name}: recorded only if {condition}")):
                getattr(run, column.name)


def test_every_group_has_its_condition_and_its_rows_in_the_documentation():
    of_parts = {"driven", "estimated", "uncertainty", "innovation"}  # columns of parts of the loop
    assert set(CONDITIONS) == set(GROUPS) - of_parts
    rows = [line for line in (ROOT / "docs" / "columns.md").read_text().splitlines() if line.startswith("| `")]
    for group in GROUPS.values():
        for column in group.columns:
            (row,) = (row for row in rows if row.startswith(f"| `{column.name}` "))
            assert f"| {group.condition} |" in row
    assert len(rows) == len(FIRST) + sum(len(group.columns) for group in GROUPS.values())


def test_a_header_may_list_tensions_that_its_cable_model_does_not_imply(tmp_path):
    """Rows, topics and reading of commands follow from the columns, not from the cable model."""
    listed, implied = make_header(3, columns=WINCHED), make_header(3, cable_model="elastic")
    assert (listed.ideal_cables, implied.ideal_cables, make_header(3).ideal_cables) == (False, False, True)
    assert listed.layout == implied.layout
    assert Header.from_dict(json.loads(json.dumps(listed.to_dict()))) == listed
    assert implied.to_dict().get("columns", ()) == ()
    assert [topic.name for topic in run_topics(listed).topics] == [topic.name for topic in run_topics(implied).topics]
    rows = make_rows(listed, 20)
    run = cdpr.load_run(write_log(tmp_path / "log.mcap", listed, rows))
    assert same_bits(np.asarray(run.rows), rows)
    assert same_bits(run.cable_tension, rows[:, listed.layout.columns["cable_tension"]])
    assert (listed.true_tension, make_header(3).true_tension) == ("cable_tension", "tension")


@pytest.mark.parametrize("model", ["ideal", "elastic"])
def test_every_column_has_one_place_in_a_message_that_has_it(model):
    header = make_header(3, cable_model=model, columns=MORE)
    layout, held = header.layout, np.zeros(header.layout.width, int)
    for topic in run_topics(header).topics:
        _, places = encode(topic.kind, topic.value)
        for path, runs in topic.columns.items():
            assert path in places
            for run in runs:
                held[run] += 1
    held[layout.columns["time"]] += 1  # by the number of the message
    assert [name for name, place in layout.columns.items() if (held[place] != 1).any()] == []
    assert {topic for column in (*FIRST, *WINCHED) for topic, _ in column.topics} == set(TOPICS)


@pytest.mark.parametrize("model", ["ideal", "elastic"])
def test_rows_of_any_table_come_back(tmp_path, model):
    header = make_header(3, cable_model=model, columns=MORE)
    rows = make_rows(header, 300)
    run = cdpr.load_run(write_log(tmp_path / "log.mcap", header, rows))
    assert run.header == header
    assert same_bits(np.asarray(run.rows), rows)
    assert [run[column.name].shape for column in MORE] == [(300, 3), (300, 4), (300, 3), (300,), (300, 5)]


def test_a_column_that_no_message_holds_reads_as_nan(tmp_path, monkeypatch):
    """Not as zeros: what is forgotten shows."""
    header = make_header(3, columns=MORE)
    group = run_topics(header)
    lost = replace(group, topics=tuple(topic for topic in group.topics if topic.name != "/cdpr/wind"))
    monkeypatch.setattr("cdpr.log.mcap_file.run_topics", lambda header, **_: lost)
    run = cdpr.load_run(write_log(tmp_path / "log.mcap", header, make_rows(header, 5)))
    assert np.isnan(run["wind"]).all()
    assert np.isfinite(run["count"]).all()


def test_the_header_lists_further_columns_of_its_log():
    """Older logs declare no columns; a later version reads each with its own table."""
    old = make_header(2)
    assert "columns" not in old.to_dict()
    assert Header.from_dict(json.loads(json.dumps(old.to_dict()))) == old
    new = make_header(2, columns=MORE)
    assert Header.from_dict(json.loads(json.dumps(new.to_dict()))) == new
    with pytest.raises(KeyError, match="unknown field 'wind'; allowed: time, "):
        Run(old, make_rows(old, 2))["wind"]


def test_a_log_with_columns_that_make_no_sense_is_refused(tmp_path, monkeypatch):
    header = make_header(2, columns=(Column("wind", 1, "", "", places=("/cdpr/wind/nowhere",)),))
    log = write_log(tmp_path / "log.mcap", make_header(2), make_rows(make_header(2), 1))
    monkeypatch.setattr("cdpr.log.reader.Header.from_dict", lambda data: header)
    with pytest.raises(LogError, match="was written by another version of cdpr"):
        cdpr.load_run(log)


def test_headings():
    names = column_names(make_header(2, columns=MORE))
    assert names[-15:] == [
        *("wind_x_m_per_s", "wind_y_m_per_s", "wind_z_m_per_s", "tilt_w", "tilt_x", "tilt_y", "tilt_z"),
        *("slack_Seil α_m", "slack_cable_2_m", "count", *(f"gains_{i}_1_per_s2" for i in range(1, 6))),
    ]


def test_plugins_record_columns(tmp_path):
    run = cdpr.simulate(CAROCA, controller=Told, solver=Weighing, backend=Ageing, overrides=SHORT, out=tmp_path / "run")
    found = cdpr.load_run(tmp_path / "run")
    assert [(column.name, column.owner) for column in found.header.columns] == [
        *(("least", "solver"), ("effort", "controller"), ("calls", "controller"), ("age", "backend")),
    ]
    for one in (run, found):
        assert same_bits(one["effort"], one.wrench)
        assert same_bits(one["least"], one.tension)
        assert one["calls"].tolist() == list(range(1, 22))
        np.testing.assert_allclose(one["age"], one.time, atol=1e-15)
    export(found, "csv", tmp_path / "run.csv")
    with (tmp_path / "run.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert [float(line["calls"]) for line in lines] == run["calls"].tolist()
    assert float(lines[-1]["effort_force_z_N"]) == run.wrench[-1, 2]
    export(found, "npz", tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as data:
        assert same_bits(data["effort"], run.wrench)


def test_columns_change_nothing_else():
    """Rows without them are those of the same controller that records nothing."""

    class Silent(Told):
        columns = ()

        def __init__(self, *arguments):
            super().__init__(*arguments)
            self.log({"effort": np.zeros(6), "calls": np.zeros(1)})

    told, silent = (cdpr.simulate(CAROCA, controller=each, overrides=SHORT) for each in (Told, Silent))
    assert same_bits(np.ascontiguousarray(told.rows[:, : silent.rows.shape[1]]), np.asarray(silent.rows))


def test_the_report_draws_them():
    header = make_header(2, columns=MORE)
    rows = make_rows(header, 50)
    rows[:, header.layout.columns["slack"]] = np.nan
    page = render(Run(header, rows))
    assert "Recorded by plugins" in page
    assert "gains: Gains {of} &lt;it&gt;" in page
    assert "Recorded by plugins" not in render(Run(make_header(2), make_rows(make_header(2), 5)))


def test_missing_values_are_nan():
    class Idle(Told):
        def log(self, columns):
            self.effort, self.calls = np.zeros(6), np.zeros(1)

    run = cdpr.simulate(CAROCA, controller=Idle, overrides=SHORT)
    assert np.isnan(run["effort"]).all()
    found = {result.id: result for result in check_factory("controller", Idle, only=["columns_are_written"])}
    assert "column 'effort' is [nan, " in found["columns_are_written"].detail


def test_a_plugin_without_log_is_reported():
    class Mute(Told):
        log = Controller.log

    with pytest.raises(PluginError, match="Mute declares columns but has no method `log` that receives them"):
        cdpr.simulate(CAROCA, controller=Mute, overrides=SHORT)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ((Column("length", 1, "m", ""),), "column 'length': a column of this name already exists"),
        ((Column("cables", 1, "m", ""),), "column 'cables': a column of this name already exists"),
        ((Column("a", 1, "m", ""), Column("a", 2, "m", "")), "column 'a' is declared twice"),
        ((Column("a", 1, "m", "", owner="solver"),), "column 'a': a plugin cannot set its topic or owner"),
        ([Column("a", 1, "m", "")], r"columns must be a tuple of cdpr\.plugins\.Column, got \["),
        (("a",), r"columns must be a tuple of cdpr\.plugins\.Column"),
    ],
)
def test_declarations_that_are_refused(columns, message):
    with pytest.raises((TypeError, ValueError), match=message):
        PluginInfo("mine", "module:Class", "", columns=columns)
    with pytest.raises(PluginError, match=f"controller Wrong: {message}"):
        cdpr.simulate(CAROCA, controller=type("Wrong", (Told,), {"columns": columns}))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("a b", 1, "", ""), "name of a column must be a letter and up to 30"),
        (("a" * 32, 1, "", ""), "name of a column must be a letter and up to 30"),
        (("a", -1, "", ""), "width must be a number from 1 on, or CABLES, got -1"),
        (("a", True, "", ""), "width must be a number from 1 on, or CABLES, got True"),
        (("a", 1.5, "", ""), "width must be a number from 1 on, or CABLES, got 1.5"),
        (("a", 2, "", "", "world"), "a vector .3., a quaternion .4., a wrench .6. and the error of a state .12. have"),
        (("a", 6, "N, N m", ""), "only a wrench and the error of a state have several units"),
        (("a", 6, None, ""), "unit of a column must be a text, got None"),
    ],
)
def test_columns_that_make_no_sense(arguments, message):
    with pytest.raises((TypeError, ValueError), match=message):
        Column(*arguments)


def test_two_plugins_with_one_name_in_a_run():
    other = type("Other", (Weighing,), {"columns": (Column("calls", 1, "", ""),)})
    with pytest.raises(PluginError, match=r"column 'calls' of controller 'Told' and column 'calls' of solver 'Other'"):
        cdpr.simulate(CAROCA, controller=Told, solver=other)
    # Apart by name, and yet one heading.
    near = type("Near", (Told,), {"columns": (Column("position_x_m", 1, "", ""),)})
    with pytest.raises(PluginError, match=r"'position_x_m' of controller 'Near' and column 'position' of every run"):
        cdpr.simulate(CAROCA, controller=near)
    clock = type("Clock", (Told,), {"columns": (Column("t", 1, "", ""),)})
    with pytest.raises(PluginError, match=r"column 't' of controller 'Clock' and column 'time' of every run"):
        cdpr.simulate(CAROCA, controller=clock)


def test_a_branch_continues_with_its_columns():
    class Remembering(Told):
        """Its memory is its column."""

        def snapshot(self):
            return None

        def restore(self, snapshot):
            pass

    with cdpr.Simulation(CAROCA, controller=Remembering, overrides=SHORT) as sim:
        sim.step(5)
        taken = sim.snapshot()
        sim.step(10)
        sim.restore(taken)
        sim.step(1)
        assert sim.row[-1] == 6.0
        sim.reset()
        sim.step(1)
        assert sim.row[-1] == 1.0


def test_cdpr_plugins_lists_columns(tmp_path):
    (tmp_path / "told.py").write_text(
        "from cdpr.plugins import Column, Controller\nclass Mine(Controller):\n"
        "    columns = (Column('calls', 1, '', 'Calls'),)\n    def control(self, *_): pass\n"
    )
    done = CliRunner().invoke(cli, ["plugins", "--plugin", str(tmp_path / "told.py")])
    assert re.search(r"Mine .*\n +.*columns: calls", done.output)


def test_our_own_plugins_declare_none():
    """So that their logs stay as they were."""
    assert columns_of(cdpr.load_scenario(CAROCA)) == ()


def test_the_example_of_the_documentation():
    text = (ROOT / "docs" / "plugins.md").read_text()
    (code,) = re.findall(r"^```python\n(import cdpr\nfrom cdpr.plugins import CABLES.*?)^```", text, re.DOTALL | re.M)
    names: dict[str, object] = {}
    exec(code.replace('"scenarios/', f'"{ROOT}/scenarios/'), names)
    run = names["run"]
    assert isinstance(run, Run)
    assert run["calls"][-1] == 101.0


@pytest.mark.parametrize("name", LATE)
def test_late_bindings_work(name):
    holder, _, method = name.partition(".")
    assert callable(late(name))
    assert not method or callable(getattr(getattr(cdpr, holder), method))
    module, _, _ = LATE[name].partition(":")
    assert import_module(module).__file__ is not None


def test_standard_deviations_of_an_estimate_have_names_and_units():
    (sigma,) = (column for column in UNCERTAINTY if column.name == "estimate_sigma")
    found = sigma.headings([])
    assert len(found) == 12
    assert found[::3] == [
        "estimate_sigma_position_x_m",
        "estimate_sigma_rotation_x_rad",
        "estimate_sigma_velocity_x_m_per_s",
        "estimate_sigma_angular_velocity_x_rad_per_s",
    ]
