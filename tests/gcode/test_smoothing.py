"""Lines that become curves within their tolerance: how near they stay, how fast they are, what they are made of."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from conftest import EXAMPLES
from hypothesis import example, given, settings
from motion_cases import UPRIGHT, samples
from scipy.interpolate import make_lsq_spline
from test_follow import CORNERS, LIMITS, arc, assert_kept, course, jumps, polyline, seeds

from cdpr.gcode import Course, follow, together
from cdpr.gcode.smoothing import smoothed
from cdpr.trajectory import Limits

# Radius, chord and tolerance, m.
ARCS = [(0.01, 1e-4, 1e-4), (0.05, 1e-3, 1e-4), (0.2, 1e-4, 1e-4), (0.2, 5e-3, 1e-3), (1.0, 5e-3, 1e-4)]


@pytest.mark.parametrize("limits", [LIMITS, Limits(0.5, 1.0, 3.0), Limits(2.0, 20.0, 2000.0)])
@pytest.mark.parametrize(("radius", "chord", "tolerance"), ARCS)
@pytest.mark.usual("*-limits0")
def test_short_chords_of_an_arc_take_little_longer_than_it(radius, chord, tolerance, limits):
    """A whole turn, in coordinates to the micron; tolerances are those of files, more than the chords err."""
    angle = np.linspace(0, 2 * np.pi, round(2 * np.pi * radius / chord) + 1)
    points = np.round(np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1), 6)
    exact = follow(0.0, course(arc(radius, 2 * np.pi)), limits, UPRIGHT).end
    motion = follow(0.0, course(polyline(points), tolerance=tolerance), limits, UPRIGHT)
    assert motion.end <= 1.15 * exact
    assert_kept(motion, limits)
    assert jumps(motion).max() <= 1e-5 * limits.acceleration


def along(motion, places=9):
    """Return positions at this number of places of each of its polynomials."""
    shares = np.linspace(0, 1, places)[:, None] ** np.arange(6)
    return (motion.segments[:, 2:20].reshape(-1, 3, 6) @ shares.T).transpose(0, 2, 1).reshape(-1, 3)


def away(points, corners):
    """Largest distance of points (K, 3) from the polygon through others."""
    begin, step = corners[:-1], np.diff(corners, axis=0)
    square = np.maximum((step**2).sum(axis=1), 1e-300)
    farthest = 0.0
    for point in points:
        share = np.clip(((point - begin) * step).sum(axis=1) / square, 0, 1)
        farthest = max(farthest, np.linalg.norm(begin + share[:, None] * step - point, axis=1).min())
    return farthest


def polygon(rng):
    """Corners of a random walk, of a smooth curve, of stairs, or of lines along axes, there and back; to the micron."""
    count, scale = int(rng.integers(2, 60)), 10.0 ** rng.uniform(-4, 0)
    kind = rng.integers(4)
    if kind == 0:
        steps = rng.normal(size=(count, 3)) * 10.0 ** rng.uniform(-2, 0, (count, 1))
    elif kind == 1:
        turn = np.cumsum(0.2 * rng.normal(size=count))
        steps = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    elif kind == 2:
        side = rng.integers(0, 2, count)
        steps = np.stack([side, 1 - side, 0 * side], axis=1)
    else:
        steps = rng.choice([-1, 0, 1], (count, 3)) * 10.0 ** rng.uniform(-3, 0, (count, 1))
    points = np.round(np.concatenate([np.zeros((1, 3)), np.cumsum(scale * steps, axis=0)]), 6)
    if rng.random() < 0.2:  # and some points twice, but for rounding
        points = np.repeat(points, rng.integers(1, 3, len(points)), axis=0)
        points[1::3] += 10.0 ** rng.uniform(-11, -6) * rng.normal(size=points[1::3].shape)
    return points[np.concatenate([[True], np.diff(points, axis=0).any(axis=1)])]


@pytest.mark.slow
@settings(max_examples=min(25, EXAMPLES // 2), deadline=None)
@given(seeds)
@example(9)  # stops beside lines too short to be rounded, while another row is slower rounded
@example(82)  # lines shorter than knots are apart, between longer ones
@example(264)  # a feed that changes where a curve begins to bend
def test_polygons_are_followed_within_tolerance_and_never_slower_than_with_stops(seed):
    rng = np.random.default_rng(seed)
    points = polygon(rng)
    if len(points) < 3:
        return
    pieces, count = polyline(points), len(points) - 1
    limits = Limits(*(10.0 ** rng.uniform([-1, -1, 0], [0.5, 1.5, 3])))
    tolerance = 10.0 ** rng.uniform(-6, -2, count if rng.random() < 0.4 else 1) * np.ones(count)
    speed = 10.0 ** rng.uniform(-2, 0.5, count if rng.random() < 0.5 else 1) * np.ones(count)
    stop = rng.random(count) < rng.choice([0.0, 0.1])
    given = Course(pieces, speed, tolerance, stop, np.zeros(count))
    motion = follow(0.0, given, limits, UPRIGHT)
    exact = follow(0.0, dataclasses.replace(given, tolerance=np.zeros(count)), limits, UPRIGHT)
    assert motion.end <= exact.end * (1 + 1e-6)
    assert_kept(motion, Limits(min(limits.velocity, speed.max()), limits.acceleration, limits.jerk))
    assert jumps(motion).max(initial=0.0) <= 1e-4 * limits.acceleration
    np.testing.assert_allclose(motion.sample(motion.end)[:3], points[-1], atol=1e-9)
    way = along(motion)
    assert away(way, points) <= tolerance.max() * (1 + 1e-6) + 1e-9
    assert away(points, way) <= tolerance.max() * 1.05 + 1e-6  # for the way is a polygon here
    again = follow(0.0, given, limits, UPRIGHT)
    assert again.segments.tobytes() == motion.segments.tobytes()


def test_each_line_of_a_curve_keeps_its_feed():
    angle = np.linspace(0, np.pi, 101)
    points = 0.2 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    feeds = np.where(np.arange(100) // 20 % 2 == 0, 0.3, 0.1)
    motion = follow(0.0, course(polyline(points), feeds, tolerance=1e-4), LIMITS, UPRIGHT)
    _, rows = samples(motion, 4001)
    turned = np.arctan2(rows[:, 1], rows[:, 0]) / np.pi * 5
    speed = np.linalg.norm(rows[:, 7:10], axis=1)
    for part in range(5):
        within = (turned > part + 1e-3) & (turned < part + 1 - 1e-3)
        feed = 0.3 if part % 2 == 0 else 0.1
        assert 0.99 * feed < speed[within].max() <= feed * (1 + 1e-9)


def controls(points, speed, tolerance):
    """Return control points of the curve that follows lines, and the places of these on the lines.

    By scipy's B-splines with the same knots: only what is a cubic spline is found again.
    """
    made, joined, _ = smoothed(course(polyline(points), speed, tolerance=tolerance), LIMITS)
    assert joined.all()
    knots = np.concatenate([[0.0], np.cumsum(made.pieces.length)])
    padded = np.concatenate([[0.0] * 3, knots, [knots[-1]] * 3])
    which = np.repeat(np.arange(len(made.pieces)), 8)
    s = np.tile((np.arange(8) + 0.5) / 8, len(made.pieces)) * made.pieces.length[which]
    found = made.pieces.at(which, s)
    spline = make_lsq_spline(knots[which] + s, found[0], padded, 3)
    for order, atol in ((0, 1e-11), (1, 1e-8), (2, 1e-4)):
        np.testing.assert_allclose(found[order], spline(knots[which] + s, order), atol=atol)
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    places = np.array([padded[k + 1 : k + 4].mean() for k in range(len(spline.c))])
    return spline.c, np.stack([np.interp(places, way, axis) for axis in np.transpose(points)], axis=1)


def test_corners_become_splines_with_control_points_on_their_lines():
    found, on_lines = controls(CORNERS, 0.06, 1e-3)
    np.testing.assert_allclose(found, on_lines, atol=1e-9)


def test_short_lines_become_splines_that_keep_the_radius():
    """Control points on the chords alone would make it smaller by h^2 / 6 r, half a millimetre."""
    angle = np.cumsum(np.random.default_rng(4).uniform(0.02, 0.04, 200))
    points = np.stack([0.1 * np.cos(angle), 0.1 * np.sin(angle), 0.02 * angle], axis=1)
    found, on_lines = controls(points, np.inf, 1e-3)
    assert len(found) < 0.5 * len(points)
    assert (np.hypot(*found.T[:2]) > np.hypot(*on_lines.T[:2]))[1:-1].all()
    way = along(follow(0.0, course(polyline(points), tolerance=1e-3), LIMITS, UPRIGHT))
    np.testing.assert_allclose(np.hypot(*way.T[:2]), 0.1, atol=4e-5)


@pytest.mark.parametrize("length", [1e-9, 1e-7, 3e-6, 6e-6, 1e-4])
@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.usual("*-1e-09", "*-6e-06")
def test_a_line_too_short_for_a_curve_to_begin_on_it_is_met_without_a_kink(length, reverse):
    """Between an arc and lines that are rounded: its half, at which the curve begins, may be shorter than any span."""
    points = np.cumsum([[0.01, 0, 0], [0, length, 0], [-0.01, 0.01, 0], [0, 0.02, 0]], axis=0)
    pieces = [arc(0.01, np.pi, center=(0.02, 0, 0), clockwise=True), polyline(points)]
    if reverse:
        pieces = [polyline(points[::-1]), arc(0.01, np.pi, clockwise=True)]
    limits = Limits(0.02, 5.0, 20000.0)
    motion = follow(0.0, course(together(pieces), tolerance=1e-3), limits, UPRIGHT)
    assert_kept(motion, limits)
    assert jumps(motion).max() <= 1e-6 * limits.acceleration


def test_a_corner_of_microseconds_ends_with_the_acceleration_with_which_the_line_begins():
    """It is as small as its speed lets it, and its curvature changes all the way."""
    limits, begin = Limits(0.139, 3.5, 16000.0), np.array([0.007, 0.0, 0.0])
    turned = np.array([0.007 * np.cos(0.036), 0.007 * np.sin(0.036), 0.0])
    line = polyline([turned, turned + 0.02 * np.array([-np.sin(0.036), np.cos(0.036), 0.0])])
    before = polyline([begin - [0, 0.02, 0], begin])
    motion = follow(0.0, course(together([before, arc(0.007, 0.036), line]), 0.0158, tolerance=2e-3), limits, UPRIGHT)
    assert motion.segments[:, 1].min() < 1e-5
    assert_kept(motion, limits)
    assert jumps(motion).max() <= 1e-6 * limits.acceleration
