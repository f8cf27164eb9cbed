"""Differences between two resolved scenarios."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import yaml

from cdpr.config.yaml_nodes import PARSER

# keys that may differ between engines; solvers are compared separately
ENGINE_KEYS = ("simulation.backend", "backend_options")


def changes(before: str, after: str) -> list[tuple[str, str, str]]:
    """Return dotted key, old and new value of each difference between resolved scenarios; "-" for missing values."""
    old, new = (dict(_leaves(yaml.load(text, PARSER))) for text in (before, after))
    keys = list(dict.fromkeys([*old, *new]))
    return [(key, old.get(key, "-"), new.get(key, "-")) for key in keys if old.get(key) != new.get(key)]


def _leaves(node: Any, path: str = "") -> Iterator[tuple[str, str]]:
    if isinstance(node, dict) and node:
        for key, value in node.items():
            yield from _leaves(value, f"{path}.{key}" if path else str(key))
    elif isinstance(node, list) and any(isinstance(item, (dict, list)) for item in node):
        for i, value in enumerate(node):
            yield from _leaves(value, f"{path}[{i}]")
    else:
        yield path, str(node)
