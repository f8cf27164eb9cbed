"""Many pushes and targets: each costs what it costs, however many came before."""

from __future__ import annotations

from collections import Counter

from live_cases import quiet, simulated

import cdpr
from cdpr import trajectory
from cdpr.scenario.events.loads import Wrench
from cdpr.scenario.events.target import Target

PUSHES = 30
ASKED = 4  # allowed evaluations of a push during its creation; earlier, each later push evaluated it again


def test_a_push_is_requested_only_once(monkeypatch):
    asked: Counter[str] = Counter()
    for name in ("wrench_profile", "check_steps"):
        plain = getattr(Wrench, name)

        def counted(self, step, plain=plain, name=name):
            asked[name] += 1
            return plain(self, step)

        monkeypatch.setattr(Wrench, name, counted)
    with quiet() as sim:
        for i in range(PUSHES):
            sim.push([0.1 * i, 0, 0], duration=0.003 if i % 2 else None)
            sim.step()
    assert set(asked) == {"wrench_profile", "check_steps"}
    assert max(asked.values()) <= ASKED * PUSHES, asked


def test_a_target_does_not_make_those_before_it_anew(monkeypatch, tmp_path):
    made, plain = Counter[str](), trajectory.redirected

    def counted(*words):
        made["moves"] += 1
        return plain(*words)

    monkeypatch.setattr(trajectory, "redirected", counted)
    with quiet() as sim:
        for i in range(PUSHES):
            sim.target([1.0, 0.3, 1.5 + 0.001 * (i % 2)], duration=0.02)
            sim.step()
        assert made["moves"] == PUSHES
        sim.save(tmp_path / "session.yaml")
        assert cdpr.simulate(tmp_path / "session.yaml").rows.tobytes() == sim.run().rows.tobytes()


def test_a_target_is_not_checked_again_for_each_that_follows(monkeypatch):
    checked, plain = Counter[str](), Target.stay

    def counted(self, *words):
        checked["targets"] += 1
        plain(self, *words)

    monkeypatch.setattr(Target, "stay", counted)
    with quiet() as sim:
        for i in range(PUSHES):
            sim.target([1.0, 0.3, 1.5 + 0.001 * (i % 2)], duration=0.02)
            sim.step()
    assert checked["targets"] <= 2 * PUSHES


def test_a_target_before_one_that_was_planned_leaves_that():
    later = {"type": "target", "time": 0.03, "position": [1.0, 0.3, 1.51], "duration": 0.01}
    soon = {"type": "target", "time": 0.01, "position": [1.0, 0.31, 1.5], "duration": 0.01}
    with quiet(events=[later]) as sim:
        sim.step(10)
        sim.target(soon["position"], duration=0.01)
        sim.step(100)
        rows = sim.run().rows
    assert rows.tobytes() == simulated(soon, later).rows.tobytes()
