"""Faults that comparisons must reject, by either standard, and sound engines that they must not."""

from __future__ import annotations

import pytest
from compare_cases import ENGINES, comparison
from spread import sampled

pytestmark = pytest.mark.usefixtures("traps_plugin")

# Declarations of the wrapped engine: Euler's scheme, which the judge offers; the same unnamed; one of fourth order.
DECLARED = {
    "scheme": {"engine": ENGINES[0], "scheme": "semi_implicit_euler"},
    "first order": {"engine": ENGINES[0], "scheme": ""},
    "fourth order": {"engine": "reference", "scheme": "", "order": 4},
}
LOOP = {"simulation.duration": 0.5}

# A command that is late by a step is an error of first order, which a scheme of that order may have.
HIDDEN = {("late", "first order")}
FAULTS = ("gravity", "light_damping", "late", "damping", "frame", "lag")


def outcome(trap, declared, name="rotated_start", changes=LOOP):
    options = {"trap": trap, **DECLARED[declared]}
    (row,) = comparison(name, ["traps"], {"backend_options.traps": options, **changes}).figures["groups"][0]["engines"]
    return row


@pytest.mark.parametrize("declared", DECLARED)
def test_a_sound_engine_agrees(declared):
    row = outcome("none", declared)
    assert row["outcome"] == "agrees", row
    assert row["standard"] == ("scheme" if declared == "scheme" else "order")


@sampled(1, "declared", DECLARED)
@pytest.mark.parametrize("trap", FAULTS)
def test_a_fault_disagrees(trap, declared):
    row = outcome(trap, declared)
    assert row["outcome"] == ("agrees" if (trap, declared) in HIDDEN else "disagrees"), row
