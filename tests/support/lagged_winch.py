"""A winch with states of its own, as somebody would add it, and the runs of a copy of the program that has it."""

from __future__ import annotations

import numpy as np

PART = '''\
"""A drum whose motor follows the command with two lags in series: 4 states, its coordinate and the outputs of both."""

from cdpr.base.fields import Positive
from cdpr.base.needs import EVERYWHERE
from cdpr.cables.chain import Number, Winch
from cdpr.cables.drum import INERTIA, RADIUS

NUMBERS = (
    RADIUS,
    INERTIA,
    Number("winch.filter_lag", Positive, "s", "time constant of the filter of commands"),
    Number("winch.motor_lag", Positive, "s", "time constant of the motor"),
)
LAGGED = Winch(header="cdpr/cables/lagged/lagged.hpp", numbers=NUMBERS, states=4, needs=EVERYWHERE)
'''

CODE = """\
struct Lagged {
    template <class T> static CDPR_INLINE WinchTension<T> held(const T* numbers, const T* own, T swing) {
        const T mass = numbers[1] / (numbers[0] * numbers[0]);
        return {own[1] + mass * swing, mass};
    }
    template <class T> static CDPR_INLINE T turn(const T* numbers, const T* own, T tension) {
        return numbers[0] * (own[1] - tension) / numbers[1];
    }
    template <class T> static CDPR_INLINE void begin(WinchMotion<T> motion, T* own) {
        own[0] = motion.command;
        own[1] = motion.command;
    }
    template <class T> static CDPR_INLINE void slopes(WinchMotion<T> motion, T* slope) {
        slope[0] = (motion.command - motion.own[0]) / motion.numbers[2];
        slope[1] = (motion.own[0] - motion.own[1]) / motion.numbers[3];
    }
};
"""

# Text that follows certain words of cdpr/cables/parts.hpp and cdpr/cables/__init__.py.
IN_THE_HEADER = {
    "header": ("#include <cdpr/cables/lagged/lagged.hpp>\n", "#include <cdpr/cables/elastic/elastic.hpp>\n"),
    "kind": (", LAGGED", "DIRECT, DRUM"),
    "held": (
        "\n    if (is(kind, LAGGED)) return Lagged::held(numbers, own, length_acceleration);",
        "Drum::held(numbers, command, rate, length_acceleration);",
    ),
    "turn": (
        "\n    if (is(kind, LAGGED)) return Lagged::turn(numbers, motion.own, tension);",
        "Drum::drum_acceleration(numbers, command, tension, speed);",
    ),
    "begin": (
        "\n    if (is(kind, LAGGED)) return Lagged::begin(motion, own);",
        "WinchMotion<T> motion, T* own, int64_t count) {",
    ),
    "slopes": (
        "\n    if (is(kind, LAGGED)) return Lagged::slopes(motion, slope);",
        "WinchMotion<T> motion, T* slope, int64_t count) {",
    ),
}
IN_THE_TABLE = {
    "import": ("from cdpr.cables.lagged import LAGGED\n", "from cdpr.cables.inextensible import INEXTENSIBLE\n"),
    "models": (
        '    "lagged": Chain(LAGGED, ELASTIC),\n    "lagged_rigid": Chain(LAGGED, INEXTENSIBLE),\n',
        '    "elastic": Chain(DRUM, ELASTIC),\n',
    ),
}

LAGS = 5e-3, 8e-3  # s, of filter and motor
FIRST, SECOND = 300.0, 340.0  # N, commands of all cables
HOLD, TIME = 0.01, 0.03  # s, with the first command, then with the second
MODELS = ("ideal", "rigid", "elastic", "lagged", "lagged_rigid", "lagged", "lagged", "lagged_rigid")
WIDTHS = (0, 0, 2, 4, 2, 4, 4, 2)
SMOOTH = {"robot.winch.coulomb_friction": 0.0}  # so that the order of a scheme shows
CHANGES = {
    **SMOOTH,
    "robot.winch.filter_lag": LAGS[0],
    "robot.winch.motor_lag": LAGS[1],
    **{f"robot.cables[{i}].model": model for i, model in enumerate(MODELS)},
}

# Motion of one case: state, tensions, work and winches, also after a restored snapshot, and the places of the states.
RUN = """\
import json
import sys

from cdpr.plugins.registry import registry
from cdpr.scenario import load_scenario

told = []
for case in json.loads(sys.argv[1]):
    scenario = load_scenario(case["file"], overrides=case["changes"])
    entry, step = registry().get("backend", case["backend"]), case["step"]
    backend = entry.make(scenario.robot, scenario.gravity, step, scenario.backend_options(case["backend"]))
    backend.reset(scenario.initial.state())
    backend.command[:] = case["first"]
    backend.step(round(case["hold"] / step))
    backend.command[:] = case["second"]
    half = round(0.5 * case["time"] / step)
    backend.step(half)
    saved, rows = backend.snapshot(), []
    for _ in range(2):
        backend.step(half)
        tension = 0.0 * backend.command
        backend.read_tension(tension)
        rows.append([*backend.state, *tension, backend.cable_work(), *backend.winches.state])
        backend.restore(saved)
    told.append({"rows": rows, "places": backend.winches.places.tolist()})
    backend.close()
print(json.dumps(told))
"""

# Rollout of cases, and whether each equals its run alone in all bits.
ROLLOUT = """\
import json
import sys

import cdpr
from cdpr.analysis.rollouts.block import Block

far, forward = [], Block._forward


def spy(self, cases, steps):
    left = forward(self, cases, steps)
    far.append(cases[0].count)
    return left


Block._forward = spy
case = json.loads(sys.argv[1])
changes = case["changes"] | {"simulation.duration": 0.03}
found = cdpr.rollout(case["file"], 8, vary={"controller.kp": {"uniform": [40.0, 60.0]}}, overrides=changes, every=1)
alike = []
for i in range(8):
    own = {key: values[i] for key, values in found.values.items()}
    run = cdpr.simulate(case["file"], overrides=changes | own)
    alike.append(found.position[i].tobytes() == run.position.tobytes())
    alike.append(found.tension[i].tobytes() == run.tension.tobytes())
print(json.dumps([max(far, default=0), len(set(found.position[:, -1, 0])), alike]))
"""


def lagged(time):
    """Return the outputs of filter and motor, N, at a time, s, after the step from the first to the second command."""
    filtered, motor = (np.exp(-time / lag) for lag in LAGS)
    mixed = (LAGS[0] * filtered - LAGS[1] * motor) / (LAGS[0] - LAGS[1])
    return SECOND - (SECOND - FIRST) * filtered, SECOND - (SECOND - FIRST) * mixed


def steps_of_lags(step, count, order):
    """Return the same after steps of a Runge-Kutta scheme of this order, which truncates the exponential series."""
    A = step * np.array([[-1.0 / LAGS[0], 0.0], [1.0 / LAGS[1], -1.0 / LAGS[1]]])
    term = factor = np.eye(2)
    for power in range(1, order + 1):
        term = term @ A / power
        factor = factor + term
    return SECOND + np.linalg.matrix_power(factor, count) @ np.full(2, FIRST - SECOND)
