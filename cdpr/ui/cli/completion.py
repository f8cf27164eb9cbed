"""Shell completion: names of installed plugins, and keys of `--set`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import click

Complete = Callable[[click.Context, click.Parameter, str], list[str]]


def plugins(role: Any) -> Complete:
    """Return a completion of plugins of a role; in a list, of the name after the last comma."""

    def complete(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
        from cdpr.plugins.registry import registry

        before, comma, last = incomplete.rpartition(",")
        return [f"{before}{comma}{name}" for name in registry().names(role) if name.startswith(last)]

    return complete


def keys(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    """Return the scenario keys that start with the text, including the options of all installed plugins."""
    return [key for key in scenario_keys() if key.startswith(incomplete)]


def scenario_keys() -> list[str]:
    """Return all keys of scenarios, with the options of all installed plugins; `[0]` for the items of lists."""
    from cdpr.scenario.json_schema import scenario_schema

    schema = scenario_schema()
    return sorted(set(_leaves(schema, schema, "", ())))


def _leaves(node: dict[str, Any], root: dict[str, Any], path: str, inside: tuple[str, ...]) -> Iterator[str]:
    """Yield the dotted keys below a node of a JSON Schema; for lists of mappings, those of the first item."""
    if "$ref" in node:
        name = node["$ref"].rpartition("/")[2]
        if name not in inside:
            yield from _leaves(root["$defs"][name], root, path, (*inside, name))
        return
    forms = [form for key in ("anyOf", "oneOf", "allOf") for form in node.get(key, ())]
    forms += [node[key] for key in ("then", "else") if isinstance(node.get(key), dict)]
    for form in forms:
        yield from _leaves(form, root, path, inside)
    for name, child in node.get("properties", {}).items():
        if isinstance(child, dict):
            yield from _leaves(child, root, f"{path}.{name}" if path else name, inside)
    items = node.get("items")
    if isinstance(items, dict) and ("$ref" in items or "oneOf" in items or "anyOf" in items):
        yield from _leaves(items, root, f"{path}[0]", inside)
    if path and not ("properties" in node or forms):
        yield path
