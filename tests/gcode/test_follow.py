"""Along lines and arcs within limits: the path, its derivatives, the limits, and how fast it is."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from conftest import EXAMPLES
from hypothesis import given, settings
from hypothesis import strategies as st
from motion_cases import UPRIGHT, assert_smooth, samples

from cdpr.base.errors import CdprError
from cdpr.gcode import Course, arcs, follow, lines, together
from cdpr.gcode.pace import pace
from cdpr.trajectory import Limits, Stop, stop_to_stop

LIMITS = Limits(1.0, 2.0, 20.0)
ROUNDING = 1e-7  # of a limit: quintics of parts as short as 1e-8 s


def course(pieces, speed=np.inf, tolerance=0.0, pause=0.0):
    count = len(pieces)
    pauses = np.full(count, pause)
    return Course(pieces, np.broadcast_to(speed, count) * 1.0, np.full(count, tolerance), pauses > 0, pauses)


def polyline(points):
    return lines(np.array(points[:-1], dtype=float), np.array(points[1:], dtype=float))


def arc(radius, angle, climb=0.0, end_radius=None, center=(0, 0, 0), clockwise=False):
    """A round piece about z, from where x is largest."""
    across = [[0.0, -1.0 if clockwise else 1.0, 0.0]]
    radii = [[radius, radius if end_radius is None else end_radius]]
    rows = [center], [[1.0, 0, 0]], across, radii, [angle], [[0, 0, climb]]
    return arcs(*(np.array(row, dtype=float) for row in rows))


def largest(motion):
    """Largest norms of velocity, acceleration and jerk: of the last at five places of each quintic."""
    _, rows = samples(motion, 4001)
    h = motion.segments[:, 1, None]
    c = motion.segments[:, 2:20].reshape(-1, 3, 6)
    jerks = [(6 * c[:, :, 3] + 24 * s * c[:, :, 4] + 60 * s**2 * c[:, :, 5]) / h**3 for s in np.linspace(0, 1, 5)]
    norms = [np.linalg.norm(each, axis=-1).max() for each in (rows[:, 7:10], rows[:, 13:16], np.array(jerks))]
    return Limits(*norms)


def assert_kept(motion, limits=LIMITS, slack=ROUNDING):
    found = largest(motion)
    assert found.velocity <= limits.velocity * (1 + slack)
    assert found.acceleration <= limits.acceleration * (1 + slack)
    assert found.jerk <= limits.jerk * (1 + slack)


def assert_derivatives(motion):
    """Velocity and acceleration are those of the position and the velocity, by central differences within quintics."""
    h = 1e-5
    for row in motion.segments[:: max(len(motion.segments) // 60, 1)]:
        if row[1] > 4 * h:
            time = row[0] + 0.37 * row[1]
            before, here, after = (motion.sample(time + k * h) for k in (-1, 0, 1))
            np.testing.assert_allclose((after[:3] - before[:3]) / (2 * h), here[7:10], atol=1e-7)
            np.testing.assert_allclose((after[7:10] - before[7:10]) / (2 * h), here[13:16], atol=1e-6)


CORNERS = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 0.5], [0.2, 1, 0.5], [0.6, 1, 0.5]]


def test_exact_stops_are_as_fast_as_can_be():
    """The same as from stop to stop, which is verified by ruckig."""
    moved = follow(0.5, course(polyline(CORNERS)), LIMITS, UPRIGHT)
    stops = stop_to_stop(0.5, [Stop(np.array(point), UPRIGHT) for point in CORNERS], LIMITS, None)
    assert moved.end == pytest.approx(stops.end, abs=1e-9)
    for time in np.linspace(0, 7, 211):
        np.testing.assert_allclose(moved.sample(time), stops.sample(time), atol=1e-8)
    assert_kept(moved)


def test_pauses_are_rests():
    moved = follow(0.0, course(polyline(CORNERS[:3]), pause=0.25), LIMITS, UPRIGHT)
    at_once = follow(0.0, course(polyline(CORNERS[:3])), LIMITS, UPRIGHT)
    assert moved.end == pytest.approx(at_once.end + 0.25)  # the last one is held anyway
    middle = 0.5 * at_once.end + 0.2
    np.testing.assert_allclose(moved.sample(middle)[:3], [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(moved.sample(middle)[7:], 0.0, atol=1e-9)


def test_a_line_in_parts_is_passed_without_stops_as_fast_as_ruckig():
    """Three feeds on one line: each change of speed is the fastest that ends or begins where the slow part does."""
    ruckig = pytest.importorskip("ruckig")
    way, feeds, direction = [0.8, 0.3, 1.1], [0.5, 0.2, 0.8], np.array([0.6, 0.0, 0.8])
    places = [0.0, *itertools.accumulate(way)]
    moved = follow(0.0, course(polyline([place * direction for place in places]), np.array(feeds)), LIMITS, UPRIGHT)

    def fastest(length, begin, end, speed):
        given = ruckig.InputParameter(1)
        given.current_position, given.target_position = [0.0], [length]
        given.current_velocity, given.target_velocity = [begin], [end]
        given.max_velocity, given.max_acceleration, given.max_jerk = [speed], [2.0], [20.0]
        found = ruckig.Trajectory(1)
        assert ruckig.Ruckig(1).calculate(given, found) == ruckig.Result.Working
        return found.duration

    wanted = fastest(0.8, 0, 0.2, 0.5) + 0.3 / 0.2 + fastest(1.1, 0.2, 0, 0.8)
    assert moved.end == pytest.approx(wanted, abs=1e-9)
    _, rows = samples(moved)
    along, speed = rows[:, :3] @ direction, rows[:, 7:10] @ direction
    for first, last, feed in zip(places[:-1], places[1:], feeds, strict=True):
        within = (along >= first) & (along <= last)
        assert speed[within].max() <= feed * (1 + 1e-9)
        assert speed[within].max() == pytest.approx(feed, rel=1e-6)
    assert_kept(moved)
    assert_smooth(moved)


@pytest.mark.parametrize(
    "given",
    [
        {"radius": 0.3, "angle": 2 * np.pi},
        {"radius": 0.001, "angle": 2 * np.pi},
        {"radius": 3.0, "angle": 0.1, "clockwise": True},
        {"radius": 0.3, "angle": 20.0, "climb": 0.5},
        {"radius": 0.003, "angle": 20.0, "climb": -0.1},
        {"radius": 0.3, "angle": 3.0, "end_radius": 0.31},
    ],
)
@pytest.mark.parametrize("feed", [0.1, np.inf])
def test_arcs_lie_on_their_circle_and_keep_the_limits(given, feed):
    motion = follow(0.0, course(arc(**given), feed), LIMITS, UPRIGHT)
    assert_kept(motion, Limits(min(feed, 1.0), 2.0, 20.0))
    assert_derivatives(motion)
    assert_smooth(motion)
    _, rows = samples(motion, 501)
    turned = np.unwrap(np.arctan2(rows[:, 1], rows[:, 0])) * (-1 if given.get("clockwise") else 1)
    share = turned / given["angle"]
    assert share[-1] == pytest.approx(1.0)
    radius = given["radius"] + share * (given.get("end_radius", given["radius"]) - given["radius"])
    np.testing.assert_allclose(np.hypot(rows[:, 0], rows[:, 1]), radius, atol=2e-10)
    np.testing.assert_allclose(rows[:, 2], share * given.get("climb", 0.0), atol=2e-10)


def test_a_circle_takes_much_of_what_the_limits_allow():
    """A circle of constant speed would have v^2 / r = 2 m/s^2; changes of speed leave it four fifths of that."""
    found = largest(follow(0.0, course(arc(0.5, 50.0)), LIMITS, UPRIGHT))
    assert found.acceleration > 0.79 * LIMITS.acceleration
    assert found.velocity > np.sqrt(0.79 * LIMITS.acceleration * 0.5)


def slot():
    """Two lines with half a turn between them, tangential."""
    half = arc(0.2, np.pi, center=(1.0, 0.2, 0.0))
    half = dataclasses.replace(half, side=np.array([[[0, -1.0, 0], [1.0, 0, 0]]]))
    return together([polyline([[0, 0, 0], [1, 0, 0]]), half, polyline([[1, 0.4, 0], [0, 0.4, 0]])])


def distance(points, path):
    """Largest distance of points (K, 3) from a path given densely."""
    return max(np.linalg.norm(path - point, axis=1).min() for point in points)


@pytest.mark.slow
@pytest.mark.parametrize(("tolerance", "feed"), [(1e-4, 0.02), (1e-3, 0.06), (2e-2, 0.3)])
@pytest.mark.parametrize("pieces", [polyline(CORNERS), slot()], ids=["corners", "slot"])
def test_rounded_corners_stay_within_their_tolerance(pieces, tolerance, feed):
    """At feeds at which it pays to round them."""
    motion = follow(0.0, course(pieces, feed, tolerance=tolerance), LIMITS, UPRIGHT)
    assert_kept(motion, dataclasses.replace(LIMITS, velocity=feed))
    assert_derivatives(motion)
    assert_smooth(motion)
    times, rows = samples(motion, 3001)
    inner = rows[1:-1, 7:10]
    assert np.linalg.norm(inner, axis=1).min() > 0.0, "never at rest on the way"
    every = [pieces.at(np.full(801, k), np.linspace(0, 1, 801) * pieces.length[k])[0] for k in range(len(pieces))]
    path, spacing = np.concatenate(every), pieces.length.max() / 800
    assert distance(rows[:, :3], path) <= np.hypot(tolerance, 0.5 * spacing)
    corners = pieces.at(np.arange(len(pieces) - 1), pieces.length[:-1])[0]
    missed = np.array([np.linalg.norm(rows[:, :3] - corner, axis=1).min() for corner in corners])
    assert missed.max() <= tolerance * (1 + 1e-6) + 0.5 * np.diff(times)[0]
    if pieces.angle.max() == 0.0:
        assert missed.max() > 0.7 * tolerance, "and they take it where directions jump"


def test_rounding_saves_time_where_it_may():
    exact, rounded = (follow(0.0, course(slot(), tolerance=t), LIMITS, UPRIGHT).end for t in (0.0, 1e-3))
    assert rounded < 0.9 * exact


def test_a_slow_feed_keeps_to_the_corner():
    """No more of the tolerance is taken than the speed needs."""
    motion = follow(0.0, course(polyline(CORNERS[:3]), 0.02, tolerance=0.05), LIMITS, UPRIGHT)
    _, rows = samples(motion, 8001)
    assert np.linalg.norm(rows[:, :3] - [1, 0, 0], axis=1).min() < 2e-3
    inner = rows[200:-200, 7:10]
    assert np.linalg.norm(inner, axis=1).min() > 0.014, "at 90 degrees the middle has half the square of the speed"


def test_a_polygon_is_passed_without_stops():
    angle = np.linspace(0, 2 * np.pi, 201)
    pieces = polyline(np.stack([0.3 * np.cos(angle), 0.3 * np.sin(angle), 0 * angle], axis=1))
    exact, rounded = (follow(0.0, course(pieces, 0.5, tolerance=t), LIMITS, UPRIGHT) for t in (0.0, 1e-3))
    assert rounded.end < 0.25 * exact.end
    assert_kept(rounded)


seeds = st.integers(0, 2**32 - 1)


@settings(max_examples=min(40, EXAMPLES // 2), deadline=None)
@given(seeds)
def test_any_path_keeps_the_limits(seed):
    """Lines and arcs of all sizes, feeds and tolerances in any order, also there and back and on the spot."""
    rng = np.random.default_rng(seed)
    here, parts, speeds, tolerances = np.zeros(3), [], [], []
    for _ in range(rng.integers(1, 12)):
        size = 10.0 ** rng.uniform(-4, 0)
        if rng.random() < 0.6:
            step = size * rng.choice([-1.0, 0.0, 1.0, 0.3], 3)
            if not step.any():
                continue
            parts.append(polyline([here, here + step]))
        else:
            parts.append(arc(size, rng.uniform(0.01, 8), rng.choice([0.0, size]), center=here - [size, 0, 0]))
        here = parts[-1].at(np.zeros(1, dtype=int), parts[-1].length)[0][0]
        speeds.append(10.0 ** rng.uniform(-2.5, 0.5))
        tolerances.append(rng.choice([0.0, 1e-4, 1e-2]))
    if not parts:
        return
    limits = Limits(*(10.0 ** rng.uniform([-1, -1, 0], [0.5, 1.5, 3])))
    pieces, many = together(parts), len(parts)
    pause = rng.choice([0.0, 0.0, 0.5], many)
    motion = follow(0.0, Course(pieces, np.array(speeds), np.array(tolerances), pause > 0, pause), limits, UPRIGHT)
    assert_kept(motion, Limits(min(limits.velocity, max(speeds)), limits.acceleration, limits.jerk))
    np.testing.assert_allclose(motion.sample(motion.end)[:3], here, atol=1e-9)
    starts, ends = motion.segments[1:, 0], motion.segments[:-1, 0] + motion.segments[:-1, 1]
    assert (starts >= ends - 1e-9).all()
    for k in range(1, len(motion.segments), max(len(motion.segments) // 50, 1)):
        x, v = motion.segments[k - 1, 2:20].reshape(3, 6), motion.segments[k, 2:20].reshape(3, 6)
        np.testing.assert_allclose(x.sum(axis=1), v[:, 0], atol=1e-10)
        rate = (x @ np.arange(6)) / motion.segments[k - 1, 1]
        np.testing.assert_allclose(rate, v[:, 1] / motion.segments[k, 1], atol=1e-6 * limits.velocity)
    assert jumps(motion).max(initial=0.0) <= 1e-4 * limits.acceleration


def jumps(motion):
    """How far the acceleration jumps between quintics that follow each other, m/s^2."""
    h = motion.segments[:, 1, None]
    c = motion.segments[:, 2:20].reshape(-1, 3, 6)
    begin, end = 2 * c[:, :, 2] / h**2, (c @ np.array([0, 0, 2, 6, 12, 20])) / h**2
    return np.linalg.norm(end[:-1] - begin[1:], axis=1)


def test_the_last_moment_before_a_stop_belongs_to_what_comes_before_it():
    """At a jerk so high it takes microseconds, in which the way is less than its rounding."""
    first = arc(0.55, 5.16, climb=-0.5, center=(-0.55, 0, 0))
    begin = first.at(np.zeros(1, dtype=int), first.length)[0][0]
    pieces = together([first, polyline([begin, np.add(begin, [0.3, -0.4, 0.1])])])
    motion = follow(0.0, course(pieces, 0.1), Limits(2.5, 0.01, 6000.0), UPRIGHT)
    assert motion.segments[:, 1].min() < 1e-5
    assert jumps(motion).max() < 1e-6


@settings(max_examples=min(3 * EXAMPLES, 60), deadline=None)
@given(seeds)
def test_speeds_keep_their_caps_and_are_not_wasted(seed):
    """Of the plan of speeds alone: within caps, continuous, from rest to rest; each cap that lasts is reached."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 30))
    length = 10.0 ** rng.uniform(-4, 0, count)
    starts = np.concatenate([[0.0], np.cumsum(length)])
    caps = rng.choice([0.1, 0.5, 10.0 ** rng.uniform(-3, 0.3)], count)
    shares = rng.choice([1.0, 0.6, 0.1], count) if rng.random() < 0.5 else np.ones(count)
    limits = 2.0 * shares, 20.0 * shares
    phases, rows = pace(starts, caps, *limits, [0, count])
    assert rows.tolist() == [0, len(phases)]
    time, s, v, a, jerk = phases.T
    np.testing.assert_allclose(s[0], 0.0)
    assert v[0] == 0.0
    ahead = s + time * (v + time * (a / 2 + time * jerk / 6)), v + time * (a + time * jerk / 2)
    np.testing.assert_allclose(ahead[0][:-1], s[1:], atol=1e-9)
    np.testing.assert_allclose(ahead[1][:-1], v[1:], atol=1e-6)
    np.testing.assert_allclose([ahead[0][-1], ahead[1][-1]], [starts[-1], 0.0], atol=1e-6)
    assert np.abs(jerk).max() <= 20.0
    assert np.abs(a + time * jerk).max() <= 2.0 * (1 + 1e-12)
    for share in np.linspace(0, 1, 21):
        t = share * time
        place, speed = s + t * (v + t * (a / 2 + t * jerk / 6)), v + t * (a + t * jerk / 2)
        section = np.clip(np.searchsorted(starts, place - 1e-9, side="right") - 1, 0, count - 1)
        next_one = np.clip(np.searchsorted(starts, place + 1e-9, side="right") - 1, 0, count - 1)
        assert (speed <= np.maximum(caps[section], caps[next_one]) * (1 + 1e-9)).all()
        most = np.maximum(shares[section], shares[next_one])
        assert (np.abs(a + t * jerk) <= 2.0 * most * (1 + 1e-9) + 1e-9).all(), "each section keeps its own limits"
        assert (np.abs(jerk) <= 20.0 * most * (1 + 1e-9)).all()
    slowest = int(np.argmin(caps))
    if length[slowest] > 2 * caps[slowest] * (caps[slowest] / 2.0 + 0.1) / shares.min():
        assert np.isclose(v, caps[slowest]).any(), "the least cap is reached where there is room"


def test_excessive_memory_is_rejected():
    with pytest.raises(CdprError, match="polynomials of time, 2000000 at most are allowed"):
        follow(0.0, course(arc(0.1, 1e9)), LIMITS, UPRIGHT)
    with pytest.raises(ValueError, match="one piece or more"):
        follow(0.0, course(polyline(CORNERS).take(np.zeros(0, dtype=int))), LIMITS, UPRIGHT)


@pytest.mark.parametrize("limits", list(itertools.product([1e-12, 1e12], repeat=3)))
@pytest.mark.parametrize("tolerance", [0.0, 1e6])
@pytest.mark.usual("0.0-*", "1000000.0-limits[05]")
def test_limits_of_any_size(limits, tolerance):
    """As far apart as scenarios may have them."""
    pieces = together([polyline(CORNERS[:3]), arc(0.1, 7.0, center=(0.9, 1.0, 0.0))])
    motion = follow(0.0, course(pieces, tolerance=tolerance), Limits(*limits), UPRIGHT)
    assert np.isfinite(motion.segments).all()
    end = pieces.at(np.array([2]), pieces.length[2:])[0][0]
    np.testing.assert_allclose(motion.sample(motion.end)[:3], end, atol=1e-9)
    # At 1e-12 m/s speeds change on ways below the rounding of positions, and may so lie in the next section.
    assert_kept(motion, Limits(*limits), 1e-6)


@pytest.mark.parametrize("length", [1e-11, 1e-9])
def test_a_line_that_is_nothing_beside_the_others_is_a_move_of_its_own(length):
    """Between two stops, where it is the only piece."""
    points = np.cumsum([[0, 0, 0], [2000.0, 0, 0], [0, length, 0], [-2000.0, 0, 0]], axis=0)
    for tolerance in (0.0, 0.01):
        motion = follow(0.0, course(polyline(points), tolerance=tolerance, pause=0.1), LIMITS, UPRIGHT)
        np.testing.assert_allclose(motion.sample(motion.end)[:3], points[-1], atol=1e-9)
        pauses = motion.segments[1:, 0] - motion.segments[:-1].T[:2].sum(axis=0)
        assert (pauses > 0.05).sum() == 2
