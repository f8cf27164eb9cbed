"""Many pushes: each costs what it costs, however many came before."""

from __future__ import annotations

from collections import Counter

from live_cases import quiet

from cdpr.scenario.events.loads import Wrench

PUSHES = 30
ASKED = 4  # times that a push may be asked for what it does while it is made; it was asked once for each later one


def test_a_push_is_not_asked_again_for_each_that_follows(monkeypatch):
    asked: Counter[str] = Counter()
    for name in ("swing", "check_steps"):
        plain = getattr(Wrench, name)

        def counted(self, step, plain=plain, name=name):
            asked[name] += 1
            return plain(self, step)

        monkeypatch.setattr(Wrench, name, counted)
    with quiet() as sim:
        for i in range(PUSHES):
            sim.push([0.1 * i, 0, 0], duration=0.003 if i % 2 else None)
            sim.step()
    assert set(asked) == {"swing", "check_steps"}
    assert max(asked.values()) <= ASKED * PUSHES, asked
