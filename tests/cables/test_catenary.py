"""Heavy cables against their differential equation, published figures, and the limits without weight or stretch."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from cdpr.cables.catenary import CATENARY
from cdpr.cables.catenary.curve import least_tension
from cdpr.cables.drum import DRUM
from cdpr.cables.tables import CHAIN_WIDTH, SPAN, SPANS, WINCHES
from cdpr.mechanics.curves import cable_curves
from cdpr.native.bind import bind

GRAVITY = np.array([0.0, 0.0, -9.81])
G = 9.81


class Cables:
    """Cables with given chords (n, 3), E A, mass per length and damping, and lengths on their exits."""

    def __init__(self, chord, stiffness, density, damping=0.0, wrapped=0.0, over=(0.0, 0.0, 0.0), lowest=0.0):
        self.chord = np.atleast_2d(np.asarray(chord, dtype=float))
        n = len(self.chord)
        self.stiffness, self.density, self.damping, self.wrapped = (
            np.full(n, 1.0) * number for number in (stiffness, density, damping, wrapped)
        )
        self.over = np.ones((n, 3)) * over
        rows = np.zeros((n, CHAIN_WIDTH))
        rows[:, :3] = WINCHES.index(DRUM), SPANS.index(CATENARY), lowest
        rows[:, SPAN : SPAN + 3] = np.column_stack([self.stiffness, self.density, self.damping])
        self.given = {
            "chains": rows,
            "gravity": GRAVITY,
            "chord": self.chord,
            "exit_to_anchor": self.over,
            "wrapped_length": self.wrapped,
        }

    @property
    def length(self):
        return np.linalg.norm(self.chord, axis=1)

    @property
    def weight(self):
        return G * self.density

    def pull(self, unwound, stretching=0.0):
        """Return forces (n, 3) and tensions (n,)."""
        n = len(self.chord)
        force, tension = np.full((n, 3), np.nan), np.full(n, np.nan)
        one = np.ones(n)
        bind(
            "bent_cables",
            **self.given,
            unwound=one * unwound,
            stretching=one * stretching,
            force=force,
            tension=tension,
        )()
        return force, tension

    def rest(self, tension):
        """Return unwound lengths (n,)."""
        unwound = np.full(len(self.chord), np.nan)
        bind("bent_lengths", **self.given, tension=np.ones(len(unwound)) * tension, unwound=unwound)()
        return unwound

    def errors(self, unwound):
        """Return how far the ends of the exact catenaries with these forces are from the chords, per length."""
        force, tension = self.pull(unwound)
        with np.errstate(invalid="ignore", divide="ignore"):
            H, low, w, EA, L, chord = (
                np.asarray(part, dtype=np.longdouble)
                for part in (np.hypot(*force.T[:2]), force[:, 2], self.weight, self.stiffness, unwound, self.chord)
            )
            high = low + w * L
            level = H * L / EA + H / w * (np.arcsinh(high / H) - np.arcsinh(low / H))
            rise = (low + high) * L * (0.5 / EA + 1.0 / (np.hypot(H, low) + np.hypot(H, high)))
            missed = np.hypot(level - np.hypot(chord[:, 0], chord[:, 1]), rise - chord[:, 2]) / L
            ends = np.abs(np.hypot(H, high) / np.maximum(tension, 1e-12 * w * L) - 1.0)
        return np.asarray(missed, dtype=float), np.asarray(ends, dtype=float)


def random_cables(rng, n):
    """Return cables as `next_wave` of all kinds: from steep to level, light to heavy, soft to stiff."""
    level, turn = rng.uniform(0.0, 15.0, n), rng.uniform(0.0, 2.0 * np.pi, n)
    steep = rng.random(n) < 0.2
    level[steep] = 10.0 ** rng.uniform(-6.0, 0.0, steep.sum())
    chord = np.column_stack([level * np.cos(turn), level * np.sin(turn), rng.uniform(-8.0, 8.0, n)])
    return Cables(chord, 10.0 ** rng.uniform(4.0, 7.0, n), 10.0 ** rng.uniform(-3.0, 0.2, n))


SLACKS = ((-0.01, 0.0), (-1e-4, 1e-4), (0.0, 0.05), (0.05, 1.0))


def failures(n):
    """Return the number of random cables, n of each slack, that have no solution or a wrong one."""
    rng, failed = np.random.default_rng(1), 0
    for low, high in SLACKS:
        cables = random_cables(rng, n)
        missed, ends = cables.errors(cables.length * (1.0 + rng.uniform(low, high, n)))
        failed += int((~((missed < 1e-9) & (ends < 1e-6))).sum())
    return failed


def test_random_cables_have_no_failures():
    assert failures(1500) == 0


@pytest.mark.slow
def test_many_random_cables_have_no_failures():
    assert failures(25_000) == 0


def end_of(H, base, w, EA, L):
    """Return where a cable ends, (horizontal, vertical), by quadrature."""

    def slope(s, vertical):
        V = base + w * s
        T = np.hypot(H, V)
        return (V if vertical else H) / T * (1.0 + T / EA)

    bottom = np.clip(-base / w, 0.0, L)
    points = [s for s in bottom + H / w * np.array([-30, -3, 0, 3, 30]) if 0.0 < s < L]
    asked = {"points": points or None, "epsabs": 1e-12 * L, "epsrel": 1e-12, "limit": 400}
    return [quad(slope, 0.0, L, args=(vertical,), **asked)[0] for vertical in (False, True)]


def test_quadrature_of_the_differential_equation():
    """The slopes dx/ds = (H / T)(1 + T / EA) and dz/ds = (V / T)(1 + T / EA) lead from one end to the other."""
    rng = np.random.default_rng(2)
    for low, high in SLACKS:
        cables = random_cables(rng, 12)
        unwound = cables.length * (1.0 + rng.uniform(low, high, 12))
        for (x, y, base), tension, w, EA, L, chord in zip(
            *cables.pull(unwound), cables.weight, cables.stiffness, unwound, cables.chord, strict=True
        ):
            H = np.hypot(x, y)
            level, rise = end_of(H, base, w, EA, L)
            assert abs(level - np.hypot(*chord[:2])) < 1e-9 * L
            assert abs(rise - chord[2]) < 1e-9 * L
            assert np.isclose(np.hypot(H, base + w * L), tension, rtol=1e-9)
            assert np.isclose(x * chord[1], y * chord[0], atol=1e-9 * H * np.linalg.norm(chord))


def test_published_case_of_map():
    """MAP++ and MoorPy: l 89.9 m, h 59.2 m, L 130 m, E A 7.51e8 N, w 881.05 N/m."""
    cables = Cables([[89.9, 0.0, 59.2]], 7.51e8, 881.05 / G)
    force, tension = cables.pull(130.0)
    vertical = force[0, 2] + 881.05 * 130.0
    assert np.isclose(force[0, 0], 31373.2349, rtol=1e-9)
    assert np.isclose(vertical, 87886.1613, rtol=1e-9)
    assert np.isclose(tension[0], np.hypot(31373.2349, 87886.1613), rtol=1e-9)


CHORDS = [[4.0, 1.0, 3.0], [4.0, 1.0, -3.0], [0.0, 0.0, 5.0], [6.0, 0.0, 0.0]]


def elastic(chord, stiffness, unwound, damping=0.0, stretching=0.0):
    """Return forces and tensions of `elastic` cables."""
    length = np.linalg.norm(chord, axis=1)
    tension = np.where(length > unwound, stiffness * (length - unwound) / unwound + damping * stretching, 0.0)
    tension = np.maximum(tension, 0.0)
    return tension[:, None] * chord / length[:, None], tension


def test_without_weight_it_is_the_elastic_cable():
    """Exactly for a density of 0, and by the first power of the density; slack ones by that, too."""
    for share in (0.999, 1.1):
        differences = []
        for density in (0.0, 1e-6, 1e-5, 1e-4):
            cables = Cables(CHORDS, 1e5, density, 50.0)
            wanted, pulls = elastic(cables.chord, 1e5, share * cables.length, 50.0, 0.3)
            force, tension = cables.pull(share * cables.length, 0.3)
            differences.append(max(np.abs(force - wanted).max(), np.abs(tension - pulls).max()))
        assert differences[0] < 1e-9
        orders = np.log10(np.array(differences[2:]) / differences[1:-1])
        np.testing.assert_allclose(orders, 1.0, atol=0.15)


def test_stiff_cables_tend_to_the_inextensible_one():
    """By the first power of 1 / EA; the inextensible one has sinh(theta) / theta = sqrt(L^2 - z^2) / l."""
    chord, L, w = np.array([4.0, 1.0, 3.0]), 5.5, 0.3 * G
    level = np.hypot(*chord[:2])
    theta = 1.0
    for _ in range(60):
        theta = theta - (np.sinh(theta) / theta - np.sqrt(L**2 - 9.0) / level) / (
            np.cosh(theta) / theta - np.sinh(theta) / theta**2
        )
    exact = 0.5 * w * level / theta  # H
    errors = []
    for stiffness in (1e4, 1e5, 1e6, 1e7):
        force, _ = Cables(chord, stiffness, 0.3).pull(L)
        errors.append(abs(np.hypot(*force[0, :2]) - exact))
    np.testing.assert_allclose(np.log10(np.array(errors[:-1]) / errors[1:]), 1.0, atol=0.02)


def test_a_vertical_slack_cable():
    """Its lower part hangs down from either end, each bearing its own side; cables nearly vertical tend to it."""
    L, w = 7.0, 0.2 * G
    force, tension = Cables([[0.0, 0.0, 5.0]], 1e9, 0.2).pull(L)
    np.testing.assert_allclose(force[0], [0.0, 0.0, -w * 1.0], rtol=1e-6)
    np.testing.assert_allclose(tension, w * 6.0, rtol=1e-6)
    for aside in (1e-15, 1e-13, 1e-11, 1e-9, 1e-6):
        near, pull = Cables([[aside, 0.0, 5.0]], 1e9, 0.2).pull(L)
        assert np.isfinite(near).all()
        np.testing.assert_allclose(near[0], force[0], atol=w * max(aside, 1e-12))
        np.testing.assert_allclose(pull, tension, atol=w * max(aside, 1e-12))


def test_a_tension_gives_the_taut_length():
    rng = np.random.default_rng(3)
    cables = random_cables(rng, 500)
    least = least_tension(cables.chord, cables.weight, cables.stiffness, GRAVITY)
    tension = 1.001 * least + 10.0 ** rng.uniform(-2.0, 3.0, 500)
    unwound = cables.rest(tension)
    np.testing.assert_allclose(cables.pull(unwound)[1], tension, rtol=1e-6, atol=1e-6)
    shorter = cables.pull(unwound * (1.0 - 1e-6))[1]
    assert (shorter > cables.pull(unwound)[1]).all()  # the taut branch: less cable, more tension


def test_below_the_least_tension_there_is_no_length():
    """A cable of 2 kg/m over 5 m by 5 m needs 142.5 N; above it the slack length has the same tension."""
    cables = Cables([[5.0, 0.0, 5.0]], 1e6, 2.0)
    least = least_tension(cables.chord, cables.weight, cables.stiffness, GRAVITY)
    np.testing.assert_allclose(least, 142.5, atol=0.05)
    assert np.isnan(cables.rest(60.0))
    assert np.isnan(cables.rest(least * (1.0 - 1e-7)))
    taut = cables.rest(least * (1.0 + 1e-7))
    np.testing.assert_allclose(cables.pull(taut)[1], least, rtol=1e-6)
    tensions = [cables.pull(length)[1][0] for length in np.linspace(7.1, 30.0, 400)]
    np.testing.assert_allclose(min(tensions), least[0], rtol=1e-5)
    assert tensions[-1] > 2.0 * least[0]  # slack: more cable, more tension
    rng = np.random.default_rng(4)
    many = random_cables(rng, 300)
    least = least_tension(many.chord, many.weight, many.stiffness, GRAVITY)
    assert np.isnan(many.rest(least * (1.0 - 1e-6) - 1e-6)).all()
    assert np.isfinite(many.rest(least * (1.0 + 1e-6) + 1e-6)).all()


def energy(chord, L, w, EA):
    """Return the potential energy of a cable from its exit at the origin, J, by quadrature of its catenary."""
    cables = Cables(chord, EA, w / G)
    force, _ = cables.pull(L)
    H, low = np.hypot(*force[0, :2]), force[0, 2]
    nodes, weights = np.polynomial.legendre.leggauss(60)
    s = 0.5 * L * (nodes + 1.0)
    V = low + w * s
    T = np.hypot(H, V)
    height = -chord[2] + (low + V) * s * (0.5 / EA + 1.0 / (np.hypot(H, low) + T))
    return 0.5 * L * np.sum(weights * (w * height * 1.0 + 0.5 * T**2 / EA))


def test_the_force_is_the_gradient_of_the_energy():
    """Weight and stretch store what the end's motion takes: so forces do not create energy."""
    chord, w, EA = np.array([3.0, 2.0, 2.5]), 5.0, 2e4
    for share in (0.99, 1.001, 1.2):
        L = share * np.linalg.norm(chord)
        force, _ = Cables(chord, EA, w / G).pull(L)
        step = 1e-5
        slope = [(energy(chord + d, L, w, EA) - energy(chord - d, L, w, EA)) / (2.0 * step) for d in step * np.eye(3)]
        np.testing.assert_allclose(slope, force[0], rtol=1e-6, atol=1e-5)


def test_damping_acts_on_the_stretch():
    """It adds d s (l' - U') along the chord, with s = (L / EA) d(S / 2) / d(chord), and never pushes."""
    EA, density, step = 1e5, 0.4, 1e-6
    for share in (0.995, 1.0005, 1.01, 1.5):
        still = Cables(CHORDS, EA, density)
        L, u = share * still.length, still.chord / still.length[:, None]
        force, tension = still.pull(L)

        def sums(chord, L=L):
            pull, top = Cables(chord, EA, density).pull(L)
            return np.linalg.norm(pull, axis=1) + top

        part = L / EA * (sums(still.chord + step * u) - sums(still.chord - step * u)) / (4.0 * step)
        damped, top = Cables(CHORDS, EA, density, 40.0).pull(L, 0.05)
        added = damped - force
        np.testing.assert_allclose(added, (40.0 * part * 0.05)[:, None] * u, rtol=1e-4, atol=1e-6)
        up = force + added + np.outer(density * G * L, [0.0, 0.0, 1.0])
        np.testing.assert_allclose(top, np.linalg.norm(up, axis=1), rtol=1e-9)
        pushed, _ = Cables(CHORDS, EA, density, 1e9).pull(L, -10.0)
        middle = pushed + 0.5 * np.outer(density * G * L, [0.0, 0.0, 1.0])
        along = np.sum(middle * u, axis=1)
        assert (along > -1e-6 * tension).all()


def test_the_part_on_a_pulley():
    """It stretches with the cable, and the tension grows by its weight per height: T + T^2 / 2 EA."""
    EA, w, wrapped, over = 1e5, 0.5 * G, 0.3, [0.02, 0.0, 0.15]
    cables = Cables(CHORDS, EA, 0.5, wrapped=wrapped, over=over)
    unwound = 0.998 * (cables.length + wrapped)
    force, tension = cables.pull(unwound)
    free = Cables(CHORDS, EA, 0.5)
    low, high = unwound - 0.4, unwound
    for _ in range(100):  # the span for which the part on the pulley has the mean strain of the rest
        span = 0.5 * (low + high)
        pull, top = free.pull(span)
        strain = (np.linalg.norm(pull, axis=1) + top) / (2.0 * EA)
        more = span + wrapped / (1.0 + strain) > unwound
        low, high = np.where(more, low, span), np.where(more, span, high)
    np.testing.assert_allclose(force, pull, rtol=1e-9, atol=1e-7)
    np.testing.assert_allclose(tension + tension**2 / (2 * EA), top + top**2 / (2 * EA) + 0.15 * w, rtol=1e-9)
    np.testing.assert_allclose(cables.rest(tension), unwound, rtol=1e-11)

    light = Cables(CHORDS, EA, 0.0, wrapped=wrapped, over=over)
    _, tension = light.pull(unwound)
    np.testing.assert_allclose(tension, EA * (light.length + wrapped - unwound) / unwound, rtol=1e-9)


def test_cables_that_have_no_catenary():
    """Lengths of 0 or less, infinite chords, and legs that push give NaN."""
    cables = Cables(CHORDS, 1e5, 0.2)
    assert np.isnan(cables.pull(0.0)[1]).all()
    assert np.isnan(cables.pull(-1.0)[1]).all()
    assert np.isnan(cables.pull(np.nan)[1]).all()
    assert np.isnan(Cables([[np.inf, 0.0, 1.0]], 1e5, 0.2).pull(3.0)[1]).all()
    assert np.isnan(Cables(CHORDS, 1e5, 0.2, lowest=-np.inf).pull(4.0)[1]).all()


def test_the_curve_passes_through_both_ends():
    """Its length is that of the stretched cable, and it lies below the chord."""
    for share in (0.999, 1.3):
        cables = Cables(CHORDS, 1e5, 0.5)
        unwound = share * cables.length
        force, tension = cables.pull(unwound)
        lines = np.column_stack([cables.chord, np.zeros((len(CHORDS), 3))])
        pose = [[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]
        (curves,) = cable_curves(lines, cables.given["chains"], GRAVITY, pose, unwound[None], 2001)
        for i, chord in enumerate(cables.chord):
            points = curves[i, ::-1]
            np.testing.assert_allclose(points[[0, -1]], [[0.0, 0.0, 0.0], chord], atol=1e-12)
            length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
            mean = 0.5 * (tension[i] + np.linalg.norm(force[i]))
            stretched = unwound[i] * (1.0 + mean / 1e5)
            np.testing.assert_allclose(length, stretched, rtol=2e-4)
