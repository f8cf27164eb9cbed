"""Variables of winches in exported FMUs: their commands, in the units that they take, and their outputs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from cdpr.cables import LENGTH, RATE, TENSION, bends, chain_of, commands_of, has_steppers
from cdpr.cables.chain import Chain, Number
from cdpr.cables.drum import INERTIA, RADIUS
from cdpr.cables.motor import is_electrical
from cdpr.fmu.export.parts import given_numbers
from cdpr.fmu.export.variables import Variable, output
from cdpr.model import Robot
from cdpr.model.robot import Array

UNITS = {TENSION: "N", LENGTH: "m", RATE: "m/s"}  # of commands
COMMANDS = {
    "tension": "tension that the motor of each winch would hold at rest",
    "length": "unwound unstretched length that each winch is to reach",
    "rate": "rate of the unwound length that each winch is to have",
}
TO_WINCH = {
    TENSION: "tension of each cable",
    LENGTH: "unwound length of each cable",
    RATE: "rate of the unwound length of each cable",
}
START_LENGTH = "unwound unstretched length at the start, of cables whose winch takes a length or a rate; 0 for others"
PULL, DRUM_SPEED = "tension of each cable", "speed of each drum, positive where it winds in"
UNSTRETCHED = "unstretched length between drum and platform"
UNSTRETCHED_RATE = "rate of change of unstretched_length"
WORK = "work of the cables on the platform"
TORQUE = "torque of each motor about the axis of its drum"
# Outputs of DC motors, as the columns of a run: name, unit, text.
ELECTRICAL = (
    ("motor_current", "A", "current of each motor; NaN without a known torque constant"),
    ("motor_voltage", "V", "voltage of each motor in steady state; NaN without a known resistance"),
    ("electrical_power", "W", "electrical power of each motor, negative if it feeds back; NaN likewise"),
)
COUNTED = "unwound length that the drive of each stepper counts; 0 for other winches"
LOST = "full steps that each stepper has lost, positive if its cable was paid out; 0 for other winches"
BENDING = "of cables that sag, minus that of their tensions along the chords, world axes"


def prescribed(robot: Robot) -> bool:
    """Return True if the kernel of some winch takes a rate, on which the tension may depend at once."""
    return any(chain.winch.command == RATE for chain in chains_of(robot))


def command_variables(
    robot: Robot, make: Callable[[str, int, str, Array, float | None], Variable], starts: Array
) -> list[Variable]:
    """Return the variable `command` in the units of the winches: one array, or one scalar per cable if they differ.

    Args:
        robot: the robot.
        make: makes a variable of a name, a size, a quantity ("tension", "length", "rate"), start values, and a typical
            value.
        starts: (m,), start values, N, m or m/s.
    """
    kinds = commands_of(robot)
    if len(set(kinds)) == 1:
        return [make("command", robot.m, kinds[0], starts, usual_tension(robot) if kinds[0] == TENSION else None)]
    return [
        replace(make(name, 1, kind, starts[i : i + 1], usual_tension(robot) if kind == TENSION else None), shape=())
        for i, (name, kind) in enumerate(zip(command_names(robot), kinds, strict=True))
    ]


def command_names(robot: Robot) -> tuple[str, ...]:
    """Return the names of the variables of `command_variables`."""
    mixed = len(set(commands_of(robot))) > 1
    return tuple(f"command[{i + 1}]" for i in range(robot.m)) if mixed else ("command",)


def usual_tension(robot: Robot) -> float | None:
    """Return half of the largest tension limit, N, as a typical tension; None without limits."""
    most = float(robot.tension_max.max())
    return 0.5 * most if math.isfinite(most) and most else None


def chains_of(robot: Robot) -> list[Chain]:
    """Return the chains of all cables."""
    return [chain_of(robot, cable) for cable in robot.cables]


def all_stretch(robot: Robot) -> bool:
    """Return True if all cables stretch."""
    return all(chain.stretches for chain in chains_of(robot))


def winch_outputs(robot: Robot, lengths: Sequence[str], decided: bool = False) -> list[Variable]:
    """Return the outputs of cables on winches; `lengths` are the inputs that replace the platform, if there is none."""
    chains = chains_of(robot)
    # The inertia of backdriven drums responds to command and wrench at once, and so do ideal cables to commands.
    at_once = lengths if all_stretch(robot) else ("external_force", "external_moment") if decided else None
    passed: Sequence[str] | None = () if all(chain.stretches for chain in chains) else lengths
    turned = passed
    if prescribed(robot):
        at_once = turned = ("external_force", "external_moment") if decided else None
    on, m = "winches", robot.m
    outputs = [output("cable_tension", m, "N", PULL, direct=at_once, nominal=usual_tension(robot), terminal="cables")]
    if _all_have(robot, RADIUS):
        outputs.append(output("drum_speed", m, "rad/s", DRUM_SPEED, terminal=on, direct=turned))
    if any(chain.stretches for chain in chains):
        outputs.append(output("unstretched_length", m, "m", UNSTRETCHED, least=0.0, terminal=on, direct=passed))
    return outputs


def plant_outputs(robot: Robot, decided: bool) -> list[Variable]:
    """Return the further outputs of cables on winches with a platform; `decided` by a controller."""
    # Rates that are commands act at once, and torques of motors follow any command.
    at_once = () if decided or not prescribed(robot) else command_names(robot)
    asked = () if decided else command_names(robot)
    outputs = [replace(output("cable_work", 1, "J", WORK, terminal="cables"), shape=())]
    if any(chain.stretches for chain in chains_of(robot)):
        outputs.append(output("unstretched_rate", robot.m, "m/s", UNSTRETCHED_RATE, terminal="winches", direct=at_once))
    if _all_have(robot, INERTIA):
        outputs.append(output("motor_torque", robot.m, "N.m", TORQUE, terminal="winches", direct=asked))
    if has_motors(robot):
        outputs += [
            output(name, robot.m, unit, text, terminal="winches", direct=asked) for name, unit, text in ELECTRICAL
        ]
    if has_steppers(robot):
        outputs.append(output("counted_length", robot.m, "m", COUNTED, terminal="winches", direct=()))
        outputs.append(output("lost_steps", robot.m, "", LOST, terminal="winches", direct=()))
    if bends(robot):
        outputs += [
            output(f"bending_{name}", 3, unit, f"{name} {BENDING}", terminal="cables", direct=at_once)
            for name, unit in (("force", "N"), ("moment", "N.m"))
        ]
    return outputs


def has_motors(robot: Robot) -> bool:
    """Return True if some motor is known, and torques and speeds of all winches are outputs."""
    return is_electrical(robot) and _all_have(robot, INERTIA) and _all_have(robot, RADIUS)


def _all_have(robot: Robot, number: Number) -> bool:
    """Return True if all winches that are not immediate have this number."""
    return all(
        chain.winch.immediate or number in given_numbers(chain.winch, cable)
        for chain, cable in zip(chains_of(robot), robot.cables, strict=True)
    )
