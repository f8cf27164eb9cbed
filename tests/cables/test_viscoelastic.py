"""Cables that creep and have hysteresis: equations, closed forms, statics and wrong values."""

from __future__ import annotations

import numpy as np
import pytest
from plants import installed
from scipy.integrate import quad, solve_ivp
from test_part_equations import CLOSE, HARDLY, POSES, STEP, M, Sample

import cdpr
from cdpr.base.errors import CdprError
from cdpr.cables.drum import DRUM
from cdpr.cables.ideal_drive import IDEAL_DRIVE
from cdpr.cables.tables import SPAN, chain_table
from cdpr.cables.viscoelastic import CREEP, VISCOELASTIC
from cdpr.mechanics.kinematics import lengths, make_state
from cdpr.mechanics.potential import Potential, rest_lengths
from cdpr.mechanics.stiffness import stiffness
from cdpr.native.bind import bind
from cdpr.scenario.from_python import _cables
from cdpr.simulation.poles import closed_loop

ELEMENTS = [[0.3, 0.05], [0.2, 2.0]]  # creep coefficients, and retardation times, s
HYSTERESIS = {"hysteresis_stiffness": 1e4, "hysteresis_tension": 15.0}  # N
# Numbers of the span: E A, damping, coefficients, times, K, S, progress; some elements and hystereses are missing.
LOW = [1e4, 0.0, 0.01, 0.01, 0.01, 0.01, 0.1, 1.0, 1e3, 5.0, 0.0]
HIGH = [1e6, 100.0, 0.5, 0.5, 0.5, 0.1, 1.0, 10.0, 1e5, 200.0, 1.0]
STATES = 4  # of the span
# m, of `reference` at 0.2 ms from DOP853: measured 8e-14, and 9e-10 with the kinks of the slip at each reversal
EXACT = {"creep": 1e-12, "both": 1e-8}
FIRST_ORDER = 0.2  # m, of semi-implicit Euler per second of its step: measured 0.1
LAG = 4e-3  # relative, of creep behind its closed form: the damping delays it by about d l / (E A) = 0.02 s


class Ropes(Sample):
    """Ropes on drums at random states."""

    def __init__(self, seed, winch=DRUM, lowest=0.0):
        super().__init__(seed, winch, VISCOELASTIC, lowest, geared=winch is DRUM)
        rng = np.random.default_rng(seed + 2000)
        self.span = rng.uniform(LOW, HIGH, (M, len(LOW)))
        self.span[::3, [2 + 2, 5 + 2]] = 0.0  # a missing third element
        self.span[::4, [8, 9]] = 0.0  # no hysteresis
        chains = self.given["chains"].copy()
        if winch is not DRUM:
            chains[:, 3 : 3 + 5] = self.drum
        chains[:, SPAN : SPAN + len(LOW)] = self.span
        self.given["chains"] = chains
        self.unwound, self.speed = self.length * rng.uniform(0.98, 1.004, M), rng.normal(size=M)
        self.strain = self.length / self.unwound - 1.0
        share = rng.uniform(0.0, 0.15, (M, 3)) * (self.span[:, 5:8] > 0.0)
        self.crept = share * self.strain[:, None]
        self.slip = self.strain + rng.uniform(-1.0, 1.0, M) * self.span[:, 9] / np.maximum(self.span[:, 8], 1.0)
        self.winch[:] = np.column_stack([self.unwound, self.speed, self.crept, self.slip]).ravel()


@pytest.mark.parametrize("lowest", [0.0, -np.inf])
def test_equations_of_one_step(lowest):
    """T = Q + H + d (l' - l0'), and c' and p' in one step of the semi-implicit scheme."""
    acted = np.zeros(3, dtype=int)
    for seed in range(POSES):
        rope = Ropes(seed, lowest=lowest)
        bind("step_winches", **rope.given, step=STEP)()
        ea, damping = rope.span[:, :2].T
        phi, tau = rope.span[:, 2:5], rope.span[:, 5:8]
        k, most = rope.span[:, 8:10].T
        radius = rope.per_turn(rope.unwound)
        stretching = rope.rate + radius * rope.speed
        q = ea * (rope.strain - rope.crept.sum(axis=1))
        h = np.where(most > 0.0, k * (rope.strain - rope.slip), 0.0)
        tension = q + h + damping * stretching
        slack = (q + h <= 0.0) & (lowest == 0.0)
        tension = np.where(slack, 0.0, np.maximum(tension, lowest))
        np.testing.assert_allclose(rope.light, tension, rtol=CLOSE, atol=HARDLY)
        # d/dt of (l - l0) / l0 by the quotient rule
        rate = (rope.rate * rope.unwound + rope.length * radius * rope.speed) / rope.unwound**2
        loaded = np.where(slack, 0.0, q)
        used = tau > 0.0
        creeping = np.where(used, (phi * (loaded / ea)[:, None] - rope.crept) / np.where(used, tau, 1.0), 0.0)
        slips = (h * rate > 0.0) & ~slack
        slipping = np.where(slips, rate * np.abs(h) / np.where(most > 0.0, most, 1.0), 0.0)
        found = rope.winch.reshape(M, 2 + STATES).T[2:]
        expected = [*(rope.crept + STEP * creeping).T, rope.slip + STEP * slipping]
        np.testing.assert_allclose(found, expected, rtol=CLOSE, atol=CLOSE)
        acted += [slack.sum(), slips.sum(), (~slips & ~slack).sum()]
    assert (acted > 10).all() or lowest != 0.0


def test_a_rope_starts_at_its_command_with_its_progress():
    for seed in range(POSES):
        rope = Ropes(seed)
        rope.winch[:] = np.nan
        bind("settle_winches", **rope.given)()
        unwound, _, *crept, slip = rope.winch.reshape(M, 2 + STATES).T
        elastic = rope.command / rope.span[:, 0]
        expected = rope.span[:, 10] * rope.span[:, 2:5].T * elastic
        expected = np.where(rope.span[:, 5:8].T > 0.0, expected, 0.0)
        np.testing.assert_allclose(crept, expected, rtol=CLOSE)
        strain = elastic + expected.sum(axis=0)
        np.testing.assert_allclose(unwound, rope.length / (1.0 + strain), rtol=CLOSE)
        np.testing.assert_allclose(slip, strain, rtol=1e3 * CLOSE)  # a difference of lengths
        np.testing.assert_allclose(rope.light, rope.command, rtol=1e3 * CLOSE)


def test_the_tension_relaxes_at_a_constant_length():
    """T = E A e (1 + phi exp(-(1 + phi) t / tau)) / (1 + phi) of one element; a step decays it by h (1 + phi) / tau."""
    rope = Ropes(1, IDEAL_DRIVE)
    chains = rope.given["chains"]
    chains[:, SPAN + 3 : SPAN + 11] = 0.0
    phi, tau, steps = 0.4, 0.5, 400
    chains[:, SPAN + 1], chains[:, SPAN + 2], chains[:, SPAN + 5] = 0.0, phi, tau
    strain = np.full(M, 0.004)
    rope.winch[:] = np.column_stack([rope.length / 1.004, *np.zeros((4, M)), strain]).ravel()
    rope.command[:], rope.given["body"][7:] = 0.0, 0.0
    for _ in range(steps):
        bind("step_winches", **rope.given, step=STEP)()
    bind("settle_winches", **rope.given)()
    first = rope.span[:, 0] * 0.004
    decayed = (1.0 - STEP * (1.0 + phi) / tau) ** steps
    np.testing.assert_allclose(rope.light, first * (1.0 + phi * decayed) / (1.0 + phi), rtol=1e-9)
    exact = np.exp(-(1.0 + phi) * steps * STEP / tau)
    assert decayed == pytest.approx(exact, rel=2e-3)


TOP, WEIGHT, PUSH = 3.0, 20.0 * 9.81, 100.0  # m, N
UNWOUND = 2.0 / (1.0 + WEIGHT / 2e4)  # m, with which the new rope holds the weight at a length of 2 m


def hanging(creep=ELEMENTS, backend="reference", step=2e-4, duration=1.0, push=PUSH, **cable):
    """Return the run of a mass of 20 kg on one rope, with a drive that holds its length, under a force from 0 s on."""
    keys = {"model": "viscoelastic", "axial_stiffness": 2e4, "damping": 100.0, "creep": creep} | cable
    data = {
        "robot": {
            "dof": ["z"],
            "platform": {"mass": 20.0},
            "tension": {"min": 0, "max": 2000},
            "home": {"position": [0.0, 0.0, 1.0]},
            "cable": {key: value for key, value in keys.items() if value is not None},
            "winch": {"type": "position", "drum_radius": 0.05},
            "cables": [{"frame": [0.0, 0.0, TOP], "platform": [0, 0, 0]}],
        },
        "simulation": {"backend": backend, "duration": duration, "control_step": 0.002, "physics_step": step},
        "initial": {"position": [0.0, 0.0, 1.0]},
        "trajectory": {"type": "hold"},
        "controller": {"type": "inverse_kinematics", "flex_compensation": True},
        "events": [{"type": "wrench", "time": 0.0, "force": [0.0, 0.0, -push], "duration": 2.0 * duration}],
    }
    return cdpr.simulate(data)


def way_of_mass(ends, creep=ELEMENTS, stiffness=2e4, damping=100.0, hysteresis=None):
    """Return heights [m] at times by adaptive integration, from the start of `hanging`, in Bouc and Wen's own form."""
    phi, tau = np.array(creep).T
    k, most = (0.0, 1.0) if hysteresis is None else hysteresis.values()
    unwound, n = UNWOUND, len(phi)

    def slope(_, y):
        height, velocity, friction, crept = y[0], y[1], y[2], y[3:]
        strain, rate = (TOP - height) / unwound - 1.0, -velocity / unwound
        q = stiffness * (strain - crept.sum())
        slack = q + friction <= 0.0
        tension = 0.0 if slack else max(q + friction - damping * velocity, 0.0)
        held = 0.0 if slack else q / stiffness
        sliding = 0.0 if slack else 0.5 * (abs(rate) * friction + rate * abs(friction)) / most
        return [velocity, (tension - PUSH) / 20.0 - 9.81, k * (rate - sliding), *((phi * held - crept) / tau)]

    options = {"rtol": 1e-11, "atol": 1e-13, "method": "DOP853", "max_step": 5e-3}
    return solve_ivp(slope, (0.0, ends[-1]), [1.0, 0.0, 0.0, *np.zeros(n)], t_eval=ends, **options).y[0]


@pytest.mark.parametrize("kind", list(EXACT))
def test_a_loaded_mass_against_an_adaptive_integration(kind):
    hysteresis = HYSTERESIS if kind == "both" else None
    run = hanging(**(hysteresis or {}))
    truth = way_of_mass(run.time[1::25], hysteresis=hysteresis)
    np.testing.assert_allclose(run.position[1::25, 2], truth, rtol=0.0, atol=EXACT[kind])


@pytest.mark.parametrize("backend", installed("mujoco", "bullet", "dart"))
@pytest.mark.slow
def test_engines_are_of_first_order(backend):
    for step in (1e-3, 5e-4):
        run = hanging(backend=backend, step=step, **HYSTERESIS)
        truth = way_of_mass(run.time[1::25], hysteresis=HYSTERESIS)
        assert np.abs(run.position[1::25, 2] - truth).max() < FIRST_ORDER * step


def test_creep_under_a_constant_load():
    """e(t) = m g / (E A) (1 + sum of phi_k (1 - exp(-t / tau_k)))."""
    creep = [[0.2, 4.0], [0.1, 20.0]]
    run = hanging(creep=creep, step=1e-3, duration=12.0, damping=200.0, push=0.0)
    strain = (TOP - run.position[:, 2]) / UNWOUND - 1.0
    phi, tau = np.array(creep).T
    expected = WEIGHT / 2e4 * (1.0 + (phi * (1.0 - np.exp(-run.time[:, None] / tau))).sum(axis=1))
    np.testing.assert_allclose(strain, expected, rtol=LAG)
    assert strain[-1] / strain[0] > 1.2


def loop_of(amplitude, count=3):
    """Strains [1] and tensions [N] of cycles about 0 of a leg that also pushes, in steps of a cycle's 1/4000."""
    angle = np.linspace(0.0, 2.0 * np.pi * count, 4000 * count + 1)
    return amplitude * np.sin(angle)


def test_the_loss_of_a_hysteresis_loop():
    """The area of Bouc and Wen's steady loop, by quadrature of its closed form."""
    k, most, amplitude, ea = 5e4, 20.0, 2e-3, 1e5
    rope = Ropes(3, IDEAL_DRIVE, lowest=-np.inf)
    chains = rope.given["chains"]
    chains[:, SPAN : SPAN + 12] = 0.0
    chains[:, [SPAN, SPAN + 8, SPAN + 9]] = ea, k, most
    chains[:, 3 + 0] = 0.05
    rope.given["body"][7:] = 0.0
    strains = loop_of(amplitude)
    unwound = rope.length[:, None] / (1.0 + strains)
    rope.winch[:] = np.column_stack([unwound[:, 0], *np.zeros((5, M))]).ravel()
    found, step = np.empty((len(strains), M)), 1e-3
    call = bind("step_winches", **rope.given, step=step)
    for j in range(len(strains) - 1):
        rope.command[:] = (unwound[:, j + 1] - unwound[:, j]) / step
        call()
        found[j] = rope.light
    cycle = slice(4000, 8000)
    lost = -np.sum(0.5 * (found[cycle][1:] + found[cycle][:-1]) * np.diff(strains[cycle])[:, None], axis=0)
    # Way up, -h to h: elastic up to H = 0, then S (1 - exp(-K e / S)); h closes the loop.
    h = most
    for _ in range(100):
        h = most * (1.0 - np.exp(-k * (2.0 * amplitude - h / k) / most))
    up = quad(lambda e: -h + k * e, 0.0, h / k)[0]
    up += quad(lambda e: most * (1.0 - np.exp(-k * e / most)), 0.0, 2.0 * amplitude - h / k, epsabs=1e-12)[0]
    np.testing.assert_allclose(np.abs(lost), 2.0 * up, rtol=5e-3)
    assert 2.0 * up == pytest.approx(4.0 * most * amplitude, rel=0.3)


def test_hysteresis_of_stiff_ropes_never_exceeds_its_tension():
    """Steps in which the strain changes by more than the slip takes."""
    ea, k, most = 1e5, 1e9, 5.0
    rope = Ropes(3, IDEAL_DRIVE, lowest=-np.inf)
    chains = rope.given["chains"]
    chains[:, SPAN : SPAN + 12] = 0.0
    chains[:, [SPAN, SPAN + 8, SPAN + 9]] = ea, k, most
    rope.given["body"][7:] = 0.0
    strains = 2e-3 * np.sin(np.linspace(0.0, 20.0, 400))
    unwound = rope.length[:, None] / (1.0 + strains)
    rope.winch[:] = np.column_stack([unwound[:, 0], *np.zeros((5, M))]).ravel()
    call = bind("step_winches", **rope.given, step=1e-3)
    for j in range(len(strains) - 1):
        rope.command[:] = (unwound[:, j + 1] - unwound[:, j]) / 1e-3
        call()
        assert np.abs(rope.light - ea * strains[j]).max() < 1.001 * most + 1e-6 * ea * 2e-3  # and round-off


def test_without_creep_and_hysteresis_it_is_the_elastic_cable():
    plain, elastic = hanging(creep=None), hanging(creep=None, model="elastic")
    np.testing.assert_allclose(plain.position, elastic.position, rtol=0.0, atol=1e-12)
    tiny = hanging(creep=[[1e-9, 0.5]], hysteresis_stiffness=1e-6, hysteresis_tension=1.0)
    np.testing.assert_allclose(tiny.position, elastic.position, rtol=0.0, atol=1e-10)


KEYS = {"cable.model": "viscoelastic", "cable.creep": ELEMENTS}


def test_statics_have_the_compliance_of_the_progress():
    pose = cdpr.load_robot("caroca_winches").home
    path = lengths(cdpr.load_robot("caroca_winches"), make_state(pose[:3], pose[3:]))
    tension = np.linspace(100.0, 800.0, 8)
    for progress in (0.0, 0.4, 1.0):
        robot = cdpr.load_robot("caroca_winches", overrides={**KEYS, "cable.creep_progress": progress})
        ea = robot.cables[0].axial_stiffness
        expected = path / (1.0 + tension / ea * (1.0 + 0.5 * progress))
        unwound = rest_lengths(robot, pose[None], tension[None])[0]
        np.testing.assert_allclose(unwound, expected, rtol=1e-14)
        at = Potential(robot, (0.0, 0.0, 0.0), unwound, np.full(8, np.nan))
        energy, _, _ = at.evaluate(pose)
        np.testing.assert_allclose(at.tension, tension, rtol=1e-9)
        assert energy == pytest.approx(float(np.sum(0.5 * tension * (path - unwound))), rel=1e-9)
        wanted = cdpr.compensated_lengths(robot, pose)
        found = cdpr.equilibrium(robot, lengths=wanted.lengths)
        assert found.converged
        np.testing.assert_allclose(found.pose, pose, atol=1e-9)


def test_the_stiffness_is_that_of_quick_motions():
    more = {"cable.creep_progress": 1.0, **{f"cable.{key}": value for key, value in HYSTERESIS.items()}}
    robot = cdpr.load_robot("caroca_winches", overrides=KEYS | more)
    cable, tension = robot.cables[0], 500.0
    ea, strain = cable.axial_stiffness, 500.0 / cable.axial_stiffness * 1.5
    tangent = VISCOELASTIC.tangent(cable, np.array([tension]))[0]
    # dT / dl = (E A + K) / l0 at constant creep and slip
    assert (tangent + tension) / (1.0 + strain) == pytest.approx(ea + HYSTERESIS["hysteresis_stiffness"])
    assert VISCOELASTIC.stiffest(cable) == ea + HYSTERESIS["hysteresis_stiffness"]
    elastic = cdpr.load_robot("caroca_winches")
    poses, pulled = robot.home[None], np.full((1, 8), tension)
    assert (np.diag(stiffness(robot, poses, pulled)[0][0]) > np.diag(stiffness(elastic, poses, pulled)[0][0])).all()


def test_a_run_repeats_after_a_restored_moment():
    data = {**KEYS, **{f"cable.{key}": value for key, value in HYSTERESIS.items()}}
    overrides = {f"robot.{key}": value for key, value in data.items()} | {"simulation.duration": 0.2}
    with cdpr.Simulation("winch", overrides=overrides) as simulation:
        simulation.step(50)
        saved = simulation.snapshot()
        simulation.step(50)
        first = simulation.state.copy()
        simulation.restore(saved)
        simulation.step(50)
        assert simulation.state.tobytes() == first.tobytes()


@pytest.mark.slow
def test_a_rollout_has_the_bits_of_its_runs():
    numbers = {**KEYS, **{f"cable.{key}": value for key, value in HYSTERESIS.items()}}
    changes = {f"robot.{key}": value for key, value in numbers.items()} | {"simulation.duration": 0.1}
    vary = {"robot.cable.creep_progress": {"uniform": [0.0, 1.0]}}
    found = cdpr.rollout("winch", 8, vary=vary, overrides=changes, every=1)
    for i in range(8):
        run = cdpr.simulate("winch", overrides=changes | {key: values[i] for key, values in found.values.items()})
        assert found.position[i].tobytes() == run.position.tobytes()
    assert len(set(found.position[:, -1, 2])) == 8


def test_poles_hold_the_creep_and_reject_hysteresis():
    still = cdpr.load_scenario("creep").initial.state()[:7]
    elastic = {"robot.cable.model": "elastic"}
    # the first period of the creep changes the stretch by some thousandths
    changes = [{}, elastic, {f"robot.cable.{key}": value for key, value in HYSTERESIS.items()}]
    creeping, plain, sticky = (closed_loop(cdpr.load_scenario("creep", overrides=each), still) for each in changes)
    assert creeping["notes"] == ["the creep of the cables is held at its value at the start of a run"]
    poles = [
        [(each["real_per_s"], abs(each["imaginary_rad_per_s"])) for each in loop["poles"]] for loop in (creeping, plain)
    ]
    np.testing.assert_allclose(poles[0], poles[1], rtol=5e-3, atol=1e-6)
    assert "hysteresis of cables is not linear" in sticky["problem"]


def test_the_creep_is_a_table_in_files():
    robot = cdpr.load_robot("caroca_winches", overrides=KEYS)
    assert [list(row) for row in CREEP.rows(robot.cables[0].own)] == ELEMENTS
    row = chain_table(robot)[0, SPAN:]
    assert row[2:].tolist() == [0.3, 0.2, 0.0, 0.05, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    assert _cables(robot)["cables"][0]["creep"] == ELEMENTS


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"cable.creep": [[0.2, 0.0]]}, "must be greater than 0"),
        ({"cable.creep": [[0.1, 1.0]] * 4}, "expected at most 3 items"),
        ({"cable.creep_progress": 1.5}, "must be at most 1"),
        ({"cable.hysteresis_stiffness": 10.0}, "hysteresis_stiffness needs hysteresis_tension"),
        ({"cable.hysteresis_tension": 10.0}, "hysteresis_tension needs hysteresis_stiffness"),
    ],
)
def test_wrong_numbers_are_errors(changes, text):
    with pytest.raises(CdprError, match=text):
        chain_table(cdpr.load_robot("caroca_winches", overrides=KEYS | changes))


def test_a_step_longer_than_the_creep_is_an_error():
    with pytest.raises(CdprError, match=r"too long for cables whose tension relaxes in 0\.0001 s"):
        hanging(creep=[[0.5, 1.5e-4]], step=1e-3)
