"""Contents of frames to a peer, and use of its answers, with a peer that is not a process."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.base.errors import BackendDied, PluginError
from cdpr.cables.tables import line_table
from cdpr.link import peer as link
from cdpr.link.options import PeerOptions
from cdpr.link.peer import NUMBER, Peer
from cdpr.mechanics.cable_geometry import cable_geometry
from cdpr.simulation.build import build
from cdpr_backends import remote as plants
from cdpr_controllers import remote as controllers

ROBOT = cdpr.load_robot(ROOT / "scenarios" / "robots" / "caroca.yaml")
GRAVITY = np.array([0.0, 0.0, -9.81])
STATE = np.array([0.3, -0.2, 1.4, 0.65**0.5, 0.1, 0.3, 0.5, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
AT = {"address": "127.0.0.1:9", "program": None, "lockstep": True, "output": "wrench", "real_time": False}
AT["quantity"] = AT["output"]
m = ROBOT.m


class Recorder:
    """Records its requests and messages, and answers as configured."""

    def __init__(self, answer):
        self.answer, self.frames, self.told, self.called = answer, [], [], "peer 'x'"

    def request(self, values):
        self.frames.append(values.copy())
        return self.answer

    newest = request

    def send(self, values):
        self.told.append(values.copy())

    def close(self):
        self.closed = True


@pytest.fixture
def plant(monkeypatch):
    monkeypatch.setattr(plants, "Peer", lambda *_: Recorder(STATE))
    return plants.RemoteBackend(ROBOT, GRAVITY, 0.001, SimpleNamespace(**AT))


def test_frames_to_a_plant(plant):
    external = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    command = np.linspace(ROBOT.tension_min, ROBOT.tension_max, 5)[2] + np.arange(m)
    plant.command[:], plant.external[:] = command, external
    plant.reset(STATE)
    plant.step(3)
    peer = plant._peer
    begin, step = peer.frames
    assert (begin[0], begin[1]) == (plants.START, 0.0)
    assert begin[2 : 2 + m].tolist() == ROBOT.tension_min.tolist()  # whatever was commanded before
    assert begin[8 + m :].tolist() == STATE.tolist()
    assert (step[0], step[1]) == (plants.STEP, pytest.approx(0.003))
    assert step[2 : 2 + m].tolist() == command.tolist()
    assert step[2 + m : 8 + m].tolist() == external.tolist()
    assert plant.state.tolist() == STATE.tolist()
    plant.close()
    (stop,) = peer.told
    assert stop[0] == plants.STOP
    assert stop[2 : 2 + m].tolist() == ROBOT.tension_min.tolist()
    assert peer.closed


def test_commands_beyond_the_limits_never_leave(plant):
    """Also values that are not numbers: the lowest tension replaces them."""
    plant.reset(STATE)
    plant.command[:] = [1e9, -1e9, np.nan, np.inf, -np.inf, 100.0, 100.0, 100.0]
    plant.step(1)
    low, high = ROBOT.tension_min, ROBOT.tension_max
    wanted = [high[0], low[1], low[2], low[3], low[4], 100.0, 100.0, 100.0]
    assert plant._peer.frames[-1][2 : 2 + m].tolist() == wanted


@pytest.mark.parametrize("lockstep", [True, False])
@pytest.mark.parametrize("sensed", [True, False])
def test_frames_to_a_controller(monkeypatch, lockstep, sensed):
    wrench = np.arange(6.0)
    monkeypatch.setattr(controllers, "Peer", lambda *_: Recorder(wrench))
    options = SimpleNamespace(**{**AT, "lockstep": lockstep})
    controller = controllers.RemoteController(ROBOT, GRAVITY, 0.001, options)
    _, length, rate = cable_geometry(line_table(ROBOT), STATE)
    assert np.abs(rate).min() > 1e-3  # none is its length
    if sensed:
        length, rate = length + 1.0, rate + 2.0
        controller.sense(np.stack([length, rate]))
    desired, out = np.arange(19.0) + 100.0, np.zeros(6)
    controller.control(0.25, STATE, desired, out)
    (frame,) = controller._peer.frames
    assert frame.tolist() == [0.25, *STATE, *desired, *length, *rate]
    assert out.tolist() == wrench.tolist()


# Accepted answers of a peer, from a transport with given answers


class Pipe:
    """A transport that sends this number of bytes of each frame, and then delivers these answers."""

    def __init__(self, sizes=()):
        self.called, self.sizes, self.sent, self.waiting = "peer 'x'", list(sizes), b"", b'{"cdpr": 1}\n'
        self.later = b""

    def send(self, data, until):
        self.sent += bytes(data)
        self.arrive()

    def send_some(self, data):
        self.arrive()
        count = min(len(data), self.sizes.pop(0)) if self.sizes else len(data)
        self.sent += bytes(data[:count])
        return count

    def receive(self, most, until):
        data, self.waiting = self.waiting[:most], self.waiting[most:]
        return data

    def close(self):
        pass

    def answer(self, *sequences):
        self.later += b"".join(np.array([k, 7.0 + k], NUMBER).tobytes() for k in sequences)

    def arrive(self):
        self.waiting, self.later = self.waiting + self.later, b""


@pytest.fixture
def free(monkeypatch):
    """A free-running peer after one request, and its pipe; frames of two numbers in both directions."""

    def make(*sizes):
        pipe = Pipe(sizes)
        monkeypatch.setattr(link, "connected", lambda *_: pipe)
        found = Peer(PeerOptions(address="127.0.0.1:9"), None, {}, 1, 1)
        pipe.answer(0)
        assert found.newest(np.array([1.0])).tolist() == [7.0]
        pipe.sent = b""
        return found, pipe

    return make


def test_answers_of_a_peer_that_runs_freely_rise(free):
    found, pipe = free()
    pipe.answer(1)
    assert found.newest(np.array([2.0])).tolist() == [8.0]
    assert found.newest(np.array([3.0])).tolist() == [8.0]  # the newest there is
    pipe.answer(2, 3)
    assert found.newest(np.array([4.0])).tolist() == [10.0]
    found.newest(np.array([5.0]))
    pipe.answer(3)
    with pytest.raises(BackendDied, match="answered frame 3 after 3, of 6"):
        found.newest(np.array([6.0]))


def test_early_answers_are_errors(free):
    found, pipe = free()
    pipe.answer(2)
    with pytest.raises(BackendDied, match="answered frame 2 after 0, of 2"):
        found.newest(np.array([2.0]))


def test_frames_that_a_peer_does_not_take_are_left_out_whole(free):
    found, pipe = free(0, 5)  # nothing of the first, five bytes of the second, and then all that is left of it
    for k in range(4):
        found.newest(np.array([10.0 + k]))
    assert np.frombuffer(pipe.sent, NUMBER).tolist() == [1.0, 11.0, 2.0, 12.0, 3.0, 13.0]
    assert found.skipped == 1


@pytest.mark.parametrize("way", ["request", "newest"])
@pytest.mark.parametrize("size", [1, 8, 16, 40])
def test_an_answer_before_its_question_is_wrong(free, way, size):
    found, pipe = free()
    pipe.answer(1, 2, 3)  # the right numbers, too soon
    pipe.waiting, pipe.later = pipe.later[:size], b""
    with pytest.raises(BackendDied, match="answered before frame 1 was sent: each answer must follow its frame"):
        getattr(found, way)(np.array([2.0]))
    assert pipe.sent == b""


@pytest.mark.parametrize("output", ["tension", "command", "length", "rate"])
def test_answers_have_the_declared_quantity(output):
    """Tensions in N are converted for winches that take lengths; lengths and rates require such winches."""
    lines = [{"frame": [x, y, 3.0], "platform": [0.0, 0.0, 0.0]} for x in (-2.0, 2.0) for y in (-2.0, 2.0)]
    robot = {
        "name": "camera",
        "dof": ["x", "y", "z"],
        "platform": {"mass": 10.0},
        "tension": {"min": 0.0, "max": 400.0},
        "home": {"position": [0.0, 0.0, 1.0]},
        "cable": {"model": "elastic", "axial_stiffness": 2e4},
        "winch": {"type": "position"},
        "cables": lines,
    }
    data = {
        "robot": robot,
        "simulation": {"backend": "reference", "duration": 0.1},
        "trajectory": {"type": "hold"},
        "controller": {"type": "remote", "address": "127.0.0.1:9", "output": output},
    }
    scenario = cdpr.load_scenario(data)
    if output == "rate":
        with pytest.raises(
            PluginError, match="outputs a rate for each cable, but the winches of this robot take a len"
        ):
            build(scenario)
        return
    assert build(scenario).output == ("winch" if output == "length" else "command")
