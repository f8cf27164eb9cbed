"""Saved sessions: they overwrite no file, and repeat the intended commands."""

from __future__ import annotations

import pytest
from click.testing import CliRunner
from live_cases import CAROCA, QUIET, quiet

import cdpr
from cdpr.simulation import session as sessions
from cdpr.ui.cli.validate import command

GIVEN = [0.0, 0.0, 1500.0, 0.0, 0.0, 0.0]


def test_the_table_of_a_session_takes_the_place_of_no_other_file(tmp_path):
    session, table = tmp_path / "session.yaml", tmp_path / "session_outside.csv"
    table.write_text("weeks,of,work\n")
    with quiet() as sim:
        sim.step(3)
        sim.save(session)  # without a table
        sim.step(3, wrench=GIVEN)
        for path in (session, tmp_path / "session.yml"):
            with pytest.raises(cdpr.OutputError, match=r"session_outside\.csv: exists already, .* not overwritten"):
                sim.save(path)
        assert table.read_text() == "weeks,of,work\n"
        assert "outside" not in session.read_text()
        table.unlink()
        table.symlink_to(tmp_path / "nowhere")
        with pytest.raises(cdpr.OutputError, match="exists already"):
            sim.save(session)
        table.unlink()
        sim.save(session)
        sim.step(3, wrench=GIVEN)
        sim.save(session)  # both are its own
        rows = sim.run().rows.tobytes()
    assert cdpr.simulate(session).rows.tobytes() == rows
    with quiet() as again:  # as where a script runs once more
        again.step(2, wrench=GIVEN)
        again.save(session)
        rows = again.run().rows.tobytes()
    assert cdpr.simulate(session).rows.tobytes() == rows


def test_a_save_that_was_cut_short_can_be_done_again(tmp_path, monkeypatch):
    session = tmp_path / "session.yaml"

    def cut(path, text, **_):
        raise KeyboardInterrupt

    with quiet() as sim:
        sim.step(3, wrench=GIVEN)
        with monkeypatch.context() as patch:
            patch.setattr(sessions, "load_scenario", cut)
            with pytest.raises(KeyboardInterrupt):
                sim.save(session)
        assert [path.name for path in tmp_path.iterdir()] == ["session_outside.csv"]
        sim.save(session)
    assert cdpr.load_scenario(session).simulation.steps == 2


def test_truncated_sessions_repeat_the_intended_commands(tmp_path):
    session, hand = tmp_path / "session.yaml", tmp_path / "hand.yaml"
    late = {"type": "wrench", "time": 1.5, "force": [1, 0, 0]}
    with cdpr.Simulation(CAROCA, overrides={"events": [late]}) as sim:
        sim.step(20)
        sim.push([1, 0, 0])
        sim.step(20)
        sim.save(session)
        rows = sim.run().rows.tobytes()
    assert cdpr.load_scenario(session).warnings == ()
    assert cdpr.simulate(session).rows.tobytes() == rows
    assert CliRunner().invoke(command, ["--strict", str(session)]).exit_code == 0
    assert "  ends_early: true\n" in session.read_text()
    hand.write_text(session.read_text().replace("  ends_early: true\n", ""))
    found = [problem.text for problem in cdpr.load_scenario(hand).warnings]
    assert len(found) == 2
    assert any("the rest of it is cut off" in text for text in found)
    assert any("after the end of the run" in text for text in found)


def test_a_session_up_to_the_end_ends_when_its_scenario_does(tmp_path):
    with cdpr.Simulation(CAROCA, overrides={**QUIET, "simulation.duration": 0.02}) as sim:
        sim.push([1, 0, 0])
        sim.until(0.02)
        sim.save(tmp_path / "session.yaml")
    assert "ends_early" not in (tmp_path / "session.yaml").read_text()
