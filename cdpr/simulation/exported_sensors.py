"""Sensors of an exported plant with controller: the measured state that its controller sees."""

from __future__ import annotations

import numpy as np

from cdpr.model.robot import Array
from cdpr.native.bind import bind
from cdpr.native.exported_pipeline import Call
from cdpr.native.random_numbers import Stream
from cdpr.scenario import Scenario
from cdpr.sensing.measurement import kernel_arguments
from cdpr.sensing.sensor import Sources
from cdpr.simulation.sensors import SEEN, seen_sensors, stream_name


def exported_sensors(scenario: Scenario, state: Array) -> tuple[Array, list[Call]]:
    """Return the state that the controller sees, and the calls that measure it at each control step.

    Noise, delays and losses have the bits of a run: they depend on the seed and the names of the sensors. Sensors that
    the controller does not use are left out.

    Args:
        scenario: scenario.
        state: (13,), true state, live.

    Returns:
        (13,) the seen state, which is `state` itself without sensors of it, and the calls in order.
    """
    robot, step = scenario.robot, scenario.simulation.control_step
    found = seen_sensors(scenario)
    if not found:
        return state, []
    seen = np.zeros(13)
    time = np.zeros(1)
    calls = [Call(bind("stamp", row=time)), Call(bind("copy", source=state, target=seen))]
    sources = Sources(robot, state, scenario.gravity, step, (), _no_view, lambda _: False, lambda *_: ())
    for used, sensor in found.items():
        truth = sensor.truth(sources)
        calls += [Call(each.do) for each in truth.write]
        settings, memory = kernel_arguments(sensor, robot.m, step)
        stream = Stream(scenario.simulation.seed, stream_name(sensor))
        given = {"truth": truth.values, "stream": stream.state, "time": time, "measured": np.zeros(len(truth.values))}
        calls.append(Call(bind("measure", **given, age=np.zeros(1), **settings, **memory)))
        calls.append(Call(bind("copy", source=given["measured"], target=seen[SEEN[used]])))
    return seen, calls


def _no_view(*_: str) -> Array:
    raise NotImplementedError  # sensors of the state read no columns
