"""Unknown options that have the name of a key of scenarios."""

from __future__ import annotations

import pytest
from command_line import cdpr_here


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["run", "caroca", "--seed", "3"], "use --set simulation.seed=3."),
        (["run", "caroca", "--seed=3"], "use --set simulation.seed=3."),
        (["validate", "caroca", "--control-step", "-1"], "use --set simulation.control_step=-1."),
        (["run", "caroca", "--kp", "--json"], "use --set controller.kp=VALUE."),
        (["run", "--duration", "2"], "use --set simulation.duration=2 or --set trajectory.duration=2."),
    ],
)
def test_the_key_is_named(words, hint):
    done = cdpr_here(*words, code=2)
    assert f"No such option {words[2 if words[1] == 'caroca' else 1].partition('=')[0]!r}" in done.stderr
    assert done.stderr.rstrip().endswith(hint)


@pytest.mark.parametrize("words", [["run", "caroca", "--outt", "x"], ["doctor", "--seed", "3"]])
def test_other_errors_are_those_of_the_command_line(words):
    done = cdpr_here(*words, code=2)
    assert "No such option" in done.stderr
    assert "of the scenario" not in done.stderr
