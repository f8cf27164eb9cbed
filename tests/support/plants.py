"""Backends by name, with their options, as the tests of engines make them."""

from __future__ import annotations

from conftest import GRAVITY

from cdpr.plugins.registry import registry


def installed(*names):
    """Those that can be made here."""
    return [name for name in names if not registry().get("backend", name).missing]


def plant(name, robot, *, gravity=GRAVITY, step=1e-3, **options):
    """The backend `name` for a robot."""
    found = registry().get("backend", name)
    return found.load()(robot, gravity, step, found.info.options(**options))
