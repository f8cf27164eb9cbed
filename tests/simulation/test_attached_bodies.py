"""Bodies that the platform takes and releases during a run."""

from __future__ import annotations

import re
from importlib import import_module

import numpy as np
import pytest
from compare_cases import ENGINES
from plants import installed

import cdpr
from cdpr.base.errors import CdprError, PluginError, ScenarioError
from cdpr.mechanics.attachments import Attachment, with_attachments
from cdpr.plugins.registry import registry
from cdpr.simulation.build import faults
from cdpr_backends import MUJOCO_RANGE
from cdpr_controllers.computed_torque import ComputedTorque

MASS, KP = 150.0, 100.0  # kg, 1/s^2: those of the example `caroca`
TURNED = [0.5, 0.6, 0.7, 0.1, 0.05, -0.02]  # kg m^2
TAKEN = {"type": "payload", "time": 0.1, "duration": 0.2, "mass": 30.0, "center": [0.1, -0.05, -0.3], "inertia": TURNED}
SECOND = {"type": "payload", "time": 0.2, "mass": 8.0, "center": [-0.2, 0.1, 0.0], "known": True}
STATE = ("position", "orientation", "velocity", "angular_velocity")


def simulate(name="caroca", events=(TAKEN, SECOND), duration=0.4, **overrides):
    given = {"simulation.duration": duration, "events": list(events), **overrides}
    return cdpr.simulate(name, overrides=given)


def states(run):
    return np.concatenate([run[name] for name in STATE], axis=1)


@pytest.mark.core
@pytest.mark.parametrize(("known", "droop"), [(False, 30.0 * 9.81 / (MASS * KP)), (True, 0.0)])
def test_an_unknown_mass_lowers_the_platform_by_the_closed_form(known, droop):
    """At rest, the wrench (m + m_p) g of the cables is m (g + kp e) by the controller: e = m_p g / (m kp)."""
    event = {"type": "payload", "time": 0.0, "mass": 30.0, "known": known}
    run = simulate(events=[event], duration=4.0, **{"trajectory": {"type": "hold"}})
    assert run.position_error[-1] == pytest.approx([0.0, 0.0, droop], abs=1e-9)


@pytest.mark.parametrize("name", ["caroca", "planar", "spherical", "carriage"])
@pytest.mark.usual("caroca", "planar")
def test_engines_equal_the_reference_with_their_scheme(name):
    small = {key: (0.01 * value if key == "mass" else value) for key, value in TAKEN.items()}
    small["inertia"] = [0.01 * value for value in TURNED]
    events = [TAKEN, SECOND] if name == "caroca" else [small]
    same = {"backend_options.reference.scheme": "semi_implicit_euler"}
    judge = simulate(name, events, **same)
    assert judge.status == "finished"
    for engine in ENGINES:
        run = simulate(name, events, **{"simulation.backend": engine})
        assert np.abs(run.position - judge.position).max() < 1e-12, engine
        assert np.abs(states(run) - states(judge)).max() < 1e-9, engine


@pytest.mark.parametrize("backend", ["reference", *ENGINES])
@pytest.mark.parametrize("name", ["caroca", "planar"])
@pytest.mark.usual("caroca-[!m]*", "planar-mujoco")
def test_snapshots_before_and_after_each_change(name, backend):
    events = [TAKEN, SECOND] if name == "caroca" else [{**TAKEN, "mass": 0.5}]
    given = {"simulation.duration": 0.4, "events": events, "simulation.backend": backend}
    with cdpr.Simulation(name, overrides=given) as simulation:
        moments = []
        for k in (50, 100, 101, 200, 250, 300, 330):
            simulation.step(k - simulation.samples)
            moments.append((k, simulation.snapshot()))
        simulation.step(70)
        rows = simulation.rows()
        for k, moment in [*moments, *reversed(moments)]:
            simulation.restore(moment)
            simulation.step(390 - k)
            assert np.array_equal(simulation.rows()[:390], rows[:390]), k


@pytest.mark.parametrize("backend", installed("reference", "mujoco"))
def test_a_reset_and_a_second_simulation_give_the_same_bits(backend):
    given = {"simulation.duration": 0.3, "events": [TAKEN, SECOND], "simulation.backend": backend}
    with cdpr.Simulation("caroca", overrides=given) as simulation:
        simulation.step(250)
        first = simulation.rows()
        simulation.reset()
        simulation.step(250)
        assert np.array_equal(simulation.rows(), first)


def test_a_nominal_robot_knows_only_known_bodies():
    """With a nominal mass of 120 kg, e = (m + m_p - 120) g / (120 kp), less m_p there if it is known."""
    hold = {"trajectory": {"type": "hold"}, "believed": {"platform": {"mass": 120.0}}}
    for known in (False, True):
        event = {"type": "payload", "time": 0.0, "mass": 30.0, "known": known}
        run = simulate(events=[event], duration=5.0, **hold)
        nominal = 120.0 + 30.0 * known
        assert run.position_error[-1][2] == pytest.approx((MASS + 30.0 - nominal) * 9.81 / (nominal * KP), abs=1e-9)


def test_the_energy_of_the_bodies_closes_the_balance():
    run = simulate(duration=0.6)
    energy = run.summary()["energy_J"]
    assert energy["balanced"]
    assert energy["load_energy"] == run.load_energy[-1] != 0.0
    assert np.abs(run.energy_residual).max() < 1e-9
    gained = run.kinetic + run.potential - run.kinetic[0] - run.potential[0] - run.cable_work
    assert np.abs(gained).max() > 10.0  # not balanced without them


def test_energies_are_those_of_the_bodies_at_their_time():
    run = simulate(events=[TAKEN])
    moved, k = run.load_energy, 100
    position, R = run.position[k], cdpr.model.rotations.matrix(run.orientation[k])
    arm, spin = R @ np.array(TAKEN["center"]), run.angular_velocity[k]
    velocity = run.velocity[k] + np.cross(spin, arm)
    xx, yy, zz, xy, xz, yz = TURNED
    J = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T
    expected = 0.5 * 30.0 * velocity @ velocity + 0.5 * spin @ J @ spin + 30.0 * 9.81 * (position + arm)[2]
    assert moved[k - 1] == 0.0
    assert moved[k] == pytest.approx(expected, rel=1e-12)


def test_cables_on_winches_keep_their_states():
    quiet = simulate("winch", [], duration=0.2)
    event = {key: value for key, value in TAKEN.items() if key != "duration"}
    run = simulate("winch", [{**event, "mass": 5.0}], duration=0.2)
    assert np.array_equal(run.position[:101], quiet.position[:101])
    # drums, lengths and tensions do not jump; only the acceleration does
    assert np.abs(run.cable_tension[100] - quiet.cable_tension[100]).max() < 1e-6
    assert np.abs(run.energy_residual).max() < 1e-3 * run.summary()["energy_J"]["turned_over"]


def test_the_log_names_the_body():
    event, second = simulate().events
    assert event.text == "payload of 30 kg at [0.1, -0.05, -0.3] m, unknown to the controller"
    assert (event.time, event.until) == (0.1, pytest.approx(0.3))
    assert (second.until, second.kind) == (None, "payload")


def test_the_class_is_the_section():
    keys = {key: value for key, value in TAKEN.items() if key != "type"}
    assert np.array_equal(states(simulate(events=[cdpr.events.Payload(**keys)])), states(simulate(events=[TAKEN])))


def test_a_case_of_a_rollout_has_the_bits_of_its_run():
    masses = [10.0, 20.0, 30.0, 40.0]
    given = {"simulation.duration": 0.9, "events[0].duration": 0.2}
    columns = ("position", "kinetic", "load_energy")
    vary = {"events[0].mass": masses}
    cases = cdpr.rollout("pick_and_place", 4, vary=vary, overrides=given, every=1, columns=columns, threads=1)
    for i, mass in enumerate(masses):
        run = cdpr.simulate("pick_and_place", overrides={**given, "events[0].mass": mass})
        for name in columns:
            assert np.array_equal(cases[name][i].squeeze(), run[name]), (mass, name)


def test_a_lane_of_a_batch_continues_a_loaded_simulation():
    given = {"simulation.duration": 0.9, "events[0].duration": 0.2}
    with cdpr.Simulation("pick_and_place", overrides=given) as simulation:
        simulation.step(600)
        moment = simulation.snapshot()
        simulation.step(250)
        position = simulation.state[:3]
    with cdpr.Batch("pick_and_place", 4, overrides=given) as batch:
        batch.step(100)
        batch.load(1, moment)
        batch.step(250)
        assert np.array_equal(batch.column("position")[:, 1], position)
        batch.step(150)
        batch.reset([1])
        batch.step(850)
        assert np.array_equal(batch.column("position")[:, 1], position)


class Deaf(cdpr.plugins.Controller):
    """Controller that cannot take another mass."""

    def control(self, time, state, desired, out):
        out[:] = 0.0


def test_unsupported_plugins_are_named():
    with pytest.raises(PluginError, match=r"events\[0\]: backend 'remote'.* changes of the platform's mass"):
        simulate(**{"simulation.backend": "remote", "backend_options.remote.program": "x"})
    with pytest.raises(PluginError, match=r"event 'payload' at 0\.2 s: controller .* cannot take a known mass"):
        cdpr.simulate("caroca", controller=Deaf, overrides={"events": [SECOND], "simulation.duration": 0.4})
    run = cdpr.simulate("caroca", controller=Deaf, overrides={"events": [TAKEN], "simulation.duration": 0.2})
    assert run.status == "finished"


def test_a_controller_that_refuses_a_known_mass_ends_the_run(monkeypatch):
    monkeypatch.setattr(ComputedTorque, "renew", lambda self, robot: False)
    with pytest.raises(PluginError, match=r"ComputedTorque cannot take the mass of a known body .* set known: false"):
        simulate()


def test_a_body_beyond_the_range_of_an_engine_is_named():
    heavy = {"type": "payload", "time": 0.1, "mass": 1e12}
    given = {"events": [SECOND | {"time": 0.0}, heavy], "simulation.backend": "mujoco"}
    (fault,) = faults(cdpr.load_scenario("caroca", overrides=given))
    assert fault.path == ("events", 1)
    text = r"event 'payload' at 0\.1 s: with the attached bodies, .* backend 'mujoco' rounds the motion .* too coarsely"
    assert re.match(text, str(fault.error))
    with pytest.raises(CdprError, match=text):
        simulate(events=given["events"], **{"simulation.backend": "mujoco"})


def test_bodies_that_do_not_meet_stay_in_the_range():
    """The mass is at half of the range: both bodies together leave it."""
    gyration = MUJOCO_RANGE["slimmest"]
    body = {"type": "payload", "time": 0.1, "duration": 0.1, "mass": 0.6 * 6.5 / gyration**2}
    given = {"events": [body, body | {"time": 0.2}], "simulation.backend": "mujoco"}
    assert list(faults(cdpr.load_scenario("caroca", overrides=given))) == []
    given["events"][1]["time"] = 0.15
    (fault,) = faults(cdpr.load_scenario("caroca", overrides=given))
    assert fault.path == ("events", 1)


def test_a_platform_beyond_the_range_of_an_engine_is_named():
    pytest.importorskip("pybullet")
    given = {"robot.platform.mass": 1e-16, "simulation.backend": "bullet"}
    (fault,) = faults(cdpr.load_scenario("caroca", overrides=given))
    assert fault.path == ("robot", "platform")
    assert "backend 'bullet' does not move a body correctly" in str(fault.error)


@pytest.mark.parametrize("engine", ENGINES)
def test_the_declared_range_is_that_of_the_engine(engine):
    module = import_module(f"cdpr_backends.{engine}.body")
    kinds = [each for each in vars(module).values() if hasattr(each, "slimmest")]
    (kind,) = (each for each in kinds if each.__module__ == module.__name__)
    declared = registry().get("backend", engine).info.properties
    assert (kind.smallest, kind.slimmest) == tuple(declared.get(name, 0.0) for name in ("smallest", "slimmest"))
    if engine == "mujoco":
        assert kind.smallest == module.mujoco.mjMINVAL


def test_an_engine_that_refuses_a_body_keeps_the_others(monkeypatch):
    """A refusal in the middle of a run has no effect on plant and controller."""
    given = {"simulation.duration": 0.4, "events": [SECOND | {"time": 0.0}]}
    with cdpr.Simulation("caroca", overrides=given) as simulation:
        simulation.step(10)
        backend, bodies = simulation._loop.parts.backend, simulation._loop.schedule._attached
        before = backend.robot.platform.mass
        monkeypatch.setattr(ComputedTorque, "renew", lambda self, robot: False)
        with pytest.raises(PluginError, match="cannot take the mass"):
            bodies.update(-1)
        assert backend.robot.platform.mass == before == MASS + SECOND["mass"]
        monkeypatch.undo()
        bodies.update(-1)
        assert backend.robot.platform.mass == MASS


@pytest.mark.parametrize(
    ("key", "value", "text"),
    [
        ("mass", 0.0, "greater than 0"),
        ("inertia", [1.0, 1.0, 3.0, 0, 0, 0], "the largest exceeds the sum"),
        ("inertia", [1.0, 1.0, -1.0, 0, 0, 0], "none may be negative"),
        ("duration", 1e-4, "at least control_step"),
    ],
)
def test_impossible_bodies(key, value, text):
    with pytest.raises(ScenarioError, match=text):
        simulate(events=[{**TAKEN, key: value}])


def test_a_compound_body_has_the_moments_of_its_parts():
    """Two compounds in another order, and one of point masses about the origin."""
    robot = cdpr.load_robot("caroca")
    rng = np.random.default_rng(1)
    bodies = [
        Attachment(float(m), c, np.zeros((3, 3))) for m, c in zip([3.0, 5.0], rng.normal(size=(2, 3)), strict=True)
    ]
    both = with_attachments(robot, bodies).platform
    twice = with_attachments(with_attachments(robot, bodies[1:]), bodies[:1]).platform
    assert np.allclose(both.inertia, twice.inertia, rtol=1e-13)
    assert np.allclose(both.center_of_mass, twice.center_of_mass, rtol=1e-13)

    def about_origin(mass, center, inertia):
        return inertia + mass * (center @ center * np.eye(3) - np.outer(center, center))

    own = robot.platform
    parts = [(own.mass, own.center_of_mass, own.inertia), *((b.mass, b.center, b.inertia) for b in bodies)]
    expected = sum(about_origin(*part) for part in parts)
    assert np.allclose(about_origin(both.mass, both.center_of_mass, both.inertia), expected, rtol=1e-13)
    assert with_attachments(robot, []) is robot


class Still(cdpr.plugins.Backend):
    """Plant without `load`."""

    def reset(self, state):
        self.state[:] = state

    def step(self, n):
        pass


def test_a_missing_method_raises():
    robot = cdpr.load_robot("caroca")
    with pytest.raises(CdprError, match="Still cannot change the mass"):
        Still(robot, np.zeros(3), 1e-3, None).load(robot)
    with pytest.raises(PluginError, match=r"events\[0\]: backend .* changes of the platform's mass"):
        cdpr.simulate("caroca", backend=Still, overrides={"events": [TAKEN]})
