"""Manual control of winches by requests: moves, holds, and sessions that repeat them to the bit."""

from __future__ import annotations

import re
from contextlib import closing

import numpy as np
import pytest
from conftest import ROOT
from fake_clock import FakeClock

import cdpr
from cdpr.simulation.driver import Driver
from cdpr.simulation.requests import Request, Requests

CAMERA = ROOT / "scenarios" / "camera_robot.yaml"
STEP = 0.002  # s, control step of the scenario
SHORT = {"simulation.duration": 0.2, "controller.flex_compensation": True}
VELOCITY = {"robot.winch.type": "velocity"}
TORQUE = {"robot.cables[1].winch": {"type": "torque", "drum_radius": 0.05, "inertia": 0.002}}
ROUND_OFF = 1e-12  # m and m/s, of sums of up to a hundred steps


class Asked(Driver):
    """Driver that executes requests of `script` at given samples, and keeps its reports."""

    def __init__(self, script, **changes):
        self.said = []
        super().__init__(
            cdpr.Simulation(CAMERA, overrides={**SHORT, **changes}), Requests(FakeClock()), speed=None, most=1
        )
        self.script = list(script)
        self.after_turn(True)

    def after_turn(self, moved):
        while self.script and self.simulation.samples >= self.script[0][0]:
            _, what, values = self.script.pop(0)
            self.requests.put(Request(what, values), replaceable=False)

    def report(self, request, level, text):
        self.said.append((level, text))


def driven(*script, said=(), **changes):
    driver = Asked(script, **changes)
    run = driver.run()
    assert [text for _, text in driver.said] == list(said)
    return driver, run


def winches(names=(), length=(), rate=(), tension=()):
    return {"names": list(names), "length": list(length), "rate": list(rate), "tension": list(tension)}


def expected(run, k):
    """Commands of the samples from k on, in rows that a test then changes: all winches hold that of sample k - 1."""
    command = run["winch_command"].copy()
    command[k:] = command[k - 1]
    return command


def names(run):
    return list(run.header.cables)


def test_a_jogged_winch_winds_at_its_rate_and_all_others_hold():
    _, run = driven((20, "jog", {"cable": 2, "rate": -0.05}), (60, "hold", {}))
    command = expected(run, 20)
    command[20:60, 1] += -0.05 * STEP * np.arange(1, 41)
    command[60:, 1] = command[59, 1]
    np.testing.assert_allclose(run["winch_command"], command, rtol=0, atol=ROUND_OFF)
    assert run["unstretched_length"][70, 1] < run["unstretched_length"][20, 1] - 0.001
    assert np.ptp(run["winch_command"][:20], axis=0).max() >= 0.0


def test_winches_wind_at_the_same_time():
    first, second, third = ({"cable": cable, "rate": rate} for cable, rate in ((1, 0.05), (3, -0.02), (4, 0.01)))
    _, run = driven((20, "jog", first), (20, "jog", second), (30, "jog", third))
    command = expected(run, 20)[:-1]  # the last step also decides the last sample
    k = np.arange(len(command))
    for cable, rate, start in ((0, 0.05, 19), (2, -0.02, 19), (3, 0.01, 29)):
        command[:, cable] += np.where(k > start, rate * STEP * (k - start), 0.0)
    np.testing.assert_allclose(run["winch_command"][:-1], command, rtol=0, atol=ROUND_OFF)


@pytest.mark.parametrize("rate", [0.3, -0.3])
@pytest.mark.parametrize("distance", [0.0101, -0.0101])
def test_a_move_ends_at_its_length(rate, distance):
    _, before = driven()
    end = float(before["winch_command"][29, 0]) + distance
    _, run = driven((30, "jog", {"cable": names(before)[0], "rate": rate, "length": end}))
    command = run["winch_command"][:, 0]
    steps = np.arange(1, 17) * 0.3 * STEP  # 16 steps of 0.6 mm, and the rest of 10.1 mm
    np.testing.assert_allclose(command[30:46], command[29] + np.sign(distance) * steps, rtol=0, atol=ROUND_OFF)
    assert command[46:].tolist() == [end] * len(command[46:])


def test_a_winch_of_rates_moves_as_far():
    _, before = driven(**VELOCITY)
    start = float(before["unstretched_length"][29, 2])
    _, run = driven((30, "jog", {"cable": 3, "rate": 0.3, "length": start + 0.0101}), **VELOCITY)
    command = run["winch_command"]
    assert command[30:46, 2].tolist() == [0.3] * 16
    np.testing.assert_allclose(command[46, 2], (0.0101 - 16 * 0.3 * STEP) / STEP, rtol=1e-9)
    assert not command[47:, 2].any()
    assert not command[30:, [0, 1, 3]].any()


def test_a_winch_of_rates_winds_until_it_holds():
    _, run = driven((30, "jog", {"cable": 3, "rate": 0.3}), (50, "hold", {}), **VELOCITY)
    assert run["winch_command"][30:50, 2].tolist() == [0.3] * 20
    assert not run["winch_command"][50:].any()


def test_the_controller_gets_control_back():
    _, plain = driven()
    _, run = driven(
        (20, "jog", {"cable": 1, "rate": 0.2}),
        (40, "control", {}),
        (60, "jog", {"cable": 1, "rate": 0.2}),
        (61, "winch_command", winches()),
    )
    same = plain["winch_command"]
    assert np.array_equal(run["winch_command"][40:60], same[40:60])
    assert np.array_equal(run["winch_command"][61:], same[61:])
    assert not np.array_equal(run["winch_command"][20:40], same[20:40])


def test_a_target_without_control_causes_a_warning():
    target = {"position": [0.0, 0.0, 1.0], "orientation": [1, 0, 0, 0]}
    said = ["target: has no effect until the controller has control of the cables again"]
    driven((10, "target", target), (20, "hold", {}), (30, "target", target), (31, "target", target), said=said)


def test_a_request_before_the_first_sample_begins_after_it():
    _, plain = driven()
    _, run = driven((0, "jog", {"cable": 1, "rate": 0.1}))
    command = run["winch_command"][:-1]  # the last step also decides the last sample
    assert np.array_equal(command[0], plain["winch_command"][0])
    np.testing.assert_allclose(
        command[1:, 0], command[0, 0] + 0.1 * STEP * np.arange(1, len(command)), rtol=0, atol=ROUND_OFF
    )
    assert np.array_equal(command[1:, 1:], np.tile(command[0, 1:], (len(command) - 1, 1)))


def test_messages_command_single_cables_of_each_kind():
    """A winch of tensions, a length at once, a move, and a rate; the fourth holds."""
    cables = names(driven(**TORQUE)[1])
    order = [cables[3], cables[1], cables[0]]
    message = winches(order, [3.3, None, None], [None, None, -0.1], [None, 90.0, None])
    _, run = driven((20, "winch_command", message), **TORQUE)
    command = expected(run, 20)
    command[20:, 3], command[20:, 1] = 3.3, 90.0
    command[20:, 0] -= 0.1 * STEP * np.minimum(np.arange(1, 82), 80)  # the last step also decides the last sample
    np.testing.assert_allclose(run["winch_command"], command, rtol=0, atol=ROUND_OFF)


def test_tensions_and_moves_replace_each_other():
    _, run = driven((20, "jog", {"cable": 1, "rate": 0.1}), (30, "tension", {"tension": [150.0] * 4}), (40, "hold", {}))
    assert run.tension[30:40].tolist() == [[150.0] * 4] * 10
    assert np.array_equal(run["winch_command"][40:], np.tile(run["winch_command"][39], (len(run.rows) - 40, 1)))


@pytest.mark.parametrize("changes", [{}, VELOCITY], ids=["length", "rate"])
def test_a_winch_stops_at_the_end_of_its_range(changes):
    driver = Asked([(20, "jog", {"cable": 1, "rate": -1e4})], **changes)  # 20 m in a step
    run = driver.run()
    ((level, text),) = driver.said
    assert level == "warning"
    assert re.search(r"cable '\w+': the winch stops at an unwound length of 3\.\d+ m: the length must be greater", text)
    assert np.array_equal(run["winch_command"][20:], expected(run, 20)[20:] if not changes else np.zeros((81, 4)))


@pytest.mark.parametrize("changes", [{}, VELOCITY, TORQUE], ids=["length", "rate", "mixed"])
def test_a_saved_session_repeats_the_moves_to_the_bit(changes, tmp_path):
    script = [
        (10, "jog", {"cable": 1, "rate": 0.05}),
        (15, "jog", {"cable": 3, "rate": -0.04}),
        (30, "hold", {}),
        (40, "push", {"force": [5.0, 0.0, 0.0], "duration": 0.05}),
        (50, "control", {}),
        (60, "jog", {"cable": 4, "rate": 0.05}),
    ]
    driver, run = driven(*script, **changes)
    driver.simulation.save(tmp_path / "session.yaml")
    again = cdpr.simulate(tmp_path / "session.yaml")
    assert again.rows.tobytes() == run.rows.tobytes()
    kinds = [(event.kind, event.text) for event in again.events if event.kind == "outside"]
    assert kinds == [
        ("outside", "the command was given from outside (40 samples)"),
        ("outside", "the command was given from outside (41 samples)"),
    ]


def test_batches_repeat_a_saved_session_to_the_bit(tmp_path):
    driver, run = driven((10, "jog", {"cable": 1, "rate": 0.05}), (40, "hold", {}), (50, "control", {}))
    driver.simulation.save(tmp_path / "session.yaml")
    with closing(cdpr.Batch(tmp_path / "session.yaml", 2)) as batch:
        batch.step(100)
        for column in ("position", "winch_command", "unstretched_length"):
            assert np.array_equal(batch.column(column), np.tile(run[column][-1][:, None], 2))


def test_moves_do_not_depend_on_the_steps_of_a_driver():
    script = [(0, "jog", {"cable": 1, "rate": 0.05, "length": 3.4}), (64, "hold", {})]
    rows = []
    for most in (1, 64):
        driver = Asked(script)
        driver.most = most
        rows.append(driver.run().rows.tobytes())
    assert rows[0] == rows[1]


def test_a_stopped_robot_takes_no_commands():
    text = "the robot is stopped"
    script = [
        (20, "jog", {"cable": 1, "rate": 0.1}),
        (30, "stop", {}),
        (31, "jog", {"cable": 1, "rate": 0.1}),
        (31, "hold", {}),
    ]
    _, run = driven(*script, said=[f"jog: {text}", f"winches: {text}"])
    first = run["winch_command"][:, 0]
    assert first[29] - first[19] == pytest.approx(0.002)
    assert run.status == "finished"


@pytest.mark.parametrize(
    ("changes", "what", "values", "text"),
    [
        ({}, "jog", {"cable": "line_9", "rate": 1.0}, "jog: unknown cable 'line_9'.*allowed: "),
        ({}, "jog", {"cable": 9, "rate": 1.0}, "jog: unknown cable 9: allowed: "),
        ({}, "jog", {"cable": [], "rate": 1.0}, "jog: unknown cable an empty list: allowed: "),
        ({}, "jog", {"cable": 1}, "its winch takes a rate (m/s), a length (m), or both, got nothing"),
        ({}, "jog", {"cable": 1, "rate": "fast"}, "rate: expected a number of at most 1e+12 in size, got 'fast'"),
        ({}, "jog", {"cable": 1, "rate": 10**400}, "rate: expected a number of at most 1e+12 in size"),
        ({}, "jog", {"cable": 1, "rate": float("nan")}, "rate: expected a number of at most 1e+12 in size, got nan"),
        ({}, "jog", {"cable": 1, "rate": 0.0, "length": 3.0}, "rate: a move to a length needs a rate other than 0 m/s"),
        (
            {},
            "jog",
            {"cable": 1, "rate": 1.0, "length": -3.0},
            "length: expected more than 0 and at most 1e+09 m, got -3",
        ),
        (
            {},
            "winch_command",
            winches(tension=[1.0] * 4),
            "its winch takes a rate (m/s), a length (m), or both, got tension",
        ),
        (
            VELOCITY,
            "winch_command",
            winches(length=[3.0] * 4),
            "its winch takes a rate (m/s), or with it a length (m), got length",
        ),
        (TORQUE, "winch_command", winches(rate=[0.0] * 4), "its winch takes a tension (N), got rate"),
        ({}, "winch_command", winches(length=[3.0] * 3), "position: expected no value or 4, one for each cable, got 3"),
        ({}, "winch_command", winches(["a", "a"], [3.0] * 2), "name: 'a' occurs twice"),
        (
            {"robot.winch.type": "torque", "controller": {"type": "computed_torque"}},
            "hold",
            {},
            "hold: all winches of this robot take tensions",
        ),
    ],
)
def test_unsupported_commands_are_refused(changes, what, values, text):
    plain = cdpr.simulate(CAMERA, overrides={**SHORT, **changes})
    driver = Asked([(20, what, values)], **changes)
    run = driver.run()
    ((level, said),) = driver.said
    assert level == "error"
    assert re.search(text if ".*" in text else re.escape(text), said), said
    assert run.rows.tobytes() == plain.rows.tobytes()
