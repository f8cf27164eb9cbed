"""Loops of exported controllers: docs/realtime.md states a bound for each that does not count sizes of the problem."""

from __future__ import annotations

import json
import re
from collections import Counter

from conftest import ROOT

import cdpr
from cdpr.formats.write.native.header import ONCE
from cdpr.native.entries import headers_of, listing
from cdpr.plugins.registry import registry
from cdpr.simulation.exported import control_of

COUNTED = re.compile(r"for \([\w:]+ (\w+) = [^;]+; (?:[\w.]+ && )?\1 (?:<|<=|>|>=) ([^;]+); \1(?:\+\+|--| \+= \w+)\)")
TEXT = (ROOT / "docs" / "realtime.md").read_text()
# Loops in each header that the page lists, so that a new one is noticed.
LOOPS = {
    "cdpr/cables/catenary/catenary.hpp": 3,
    "cdpr/tension/active_set.hpp": 2,
    "cdpr/tension/box_least_squares.hpp": 1,
    "cdpr/mechanics/forward_kinematics.hpp": 1,
    "cdpr/mechanics/geometry.hpp": 1,
    "cdpr/tension/polygon.hpp": 1,
    "cdpr/tension/row_space.hpp": 2,
    "cdpr/trajectory/segment.hpp": 1,
    "cdpr_solvers/barrier.hpp": 2,
    "cdpr_solvers/dykstra.hpp": 1,
    "cdpr_solvers/p_norm.hpp": 4,
    "cdpr_solvers/weighted_least_squares.hpp": 2,
}
CONTROLLERS = ("computed_torque", "pid", "static", "cable_length")
COMPILE_TIME = "cdpr/field.hpp"  # the text of fields is read by the compiler
STOP = "events=[{type: emergency_stop, time: 0.4, stopping_time: 0.3}]"


def pipeline(*changes, name="planar"):
    path = ROOT / "scenarios" / f"{name}.yaml"
    return set(control_of(cdpr.load_scenario(path, overrides=[*changes]), "native").pipeline.names)


def exported_headers():
    """Return the kernel headers of all exportable solvers, controllers and motions."""
    names = pipeline(STOP)
    for controller in CONTROLLERS:
        names |= pipeline(f"controller={{type: {controller}}}")
    for controller in ("inverse_kinematics", "computed_torque"):
        names |= pipeline(f"controller={{type: {controller}}}", name="camera_robot")
    for solver in registry().names("solver"):
        try:
            names |= pipeline(f"solver={{type: {solver}, infeasible: best_effort}}")
        except cdpr.CdprError:  # wraps a library
            continue
    includes, _ = listing(names)
    return headers_of(["#include <cdpr/realtime.hpp>", *includes])


def test_each_loop_has_a_bound():
    found: Counter[str] = Counter()
    for header, content in exported_headers().items():
        text = re.sub(r"//.*", "", ONCE.sub("", content.decode()))
        for match in re.finditer(r"\b(?:for|while) \(.*", text):
            counted = COUNTED.match(match[0])
            if counted is None or re.search("MOST|iterations", counted[2]):
                found[header] += 1
    del found[COMPILE_TIME]
    assert found == LOOPS
    stated = re.findall(r"^\| `([\w/]+\.hpp)` \|", TEXT, re.MULTILINE)
    assert set(found) == set(stated)


def test_constants_of_bounds_are_those_of_the_headers():
    headers = {name: content.decode() for name, content in exported_headers().items()}
    rows = re.findall(r"^\| `([\w/]+\.hpp)` \| (.*)", TEXT, re.MULTILINE)
    stated = [(header, *found) for header, row in rows for found in re.findall(r"`(\w*MOST_\w+)` = (\d+)", row)]
    assert len(stated) >= 5
    for header, name, value in stated:
        assert re.search(rf"\b{name} = {value};", headers[header]), name


def test_instructions_are_those_measured():
    for name, robots in json.loads((ROOT / "benchmarks" / "realtime.json").read_text()).items():
        row = next(line for line in TEXT.splitlines() if line.startswith(f"| `{name}` | ") and " / " in line)
        for counted in robots.values():
            assert f"{counted['usual']:,} / {counted['hard']:,}".replace(",", " ") in row
