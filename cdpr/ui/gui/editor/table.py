"""Table of cables: a row per cable, a column per key."""

from __future__ import annotations

from typing import Any

from cdpr.base.problems import Path, dotted
from cdpr.scenario.nominal import cable_names
from cdpr.ui.gui.editor.fields import (
    MISSING,
    Field,
    FieldFactory,
    Schema,
    at,
    branches,
    choice,
    entry,
    kind_of,
    label_of,
    resolve,
    shown,
)

# Columns that are shown even if no cable sets them.
COMMON = ("name", "frame", "platform", "tension.min", "tension.max", "diameter", "linear_density")


def cable_table(maker: FieldFactory, path: Path, given: Any, robot: Any, known: Any) -> Field:
    """Return the table of the cables at `path`.

    Args:
        maker: factory of fields, with the schema of a scenario.
        path: path of the list of cables.
        given: data of the cables in the file; MISSING if there is no list.
        robot: data of the robot, for values common to all cables.
        known: effective values of each cable; MISSING if unknown.
    """
    columns = _columns(maker.root["$defs"]["CableSection"], maker, "", optional=False)
    cables = given if isinstance(given, list) else []
    names = cable_names(known if isinstance(known, list) and len(known) >= len(cables) else cables)
    rows = []
    for i, cable in enumerate(cables):
        if not isinstance(cable, dict):
            rows.append({"path": dotted((*path, i)), "name": names[i], "cells": {}, "odd": shown(cable, "yaml")})
            continue
        cells = {}
        for column in columns:
            key: Path = tuple(column["key"].split("."))
            value = at(cable, key)
            default = names[i] if column["key"] == "name" else _default(at(known, (i, *key)), robot, key, i)
            cells[column["key"]] = {
                "value": shown(default if value is MISSING else value, column["kind"]),
                "given": value is not MISSING,
            }
        rows.append({"path": dotted((*path, i)), "name": names[i], "cells": cells})
    for column in columns:
        is_set = any(row["cells"].get(column["key"], {}).get("given") for row in rows)
        column["shown"] = is_set or column["key"] in COMMON
    text = "cables: A_i on the frame, B_i on the platform; omitted values are those of all cables"
    field = entry(path, "table", len(rows), given=given is not MISSING, optional=False, text=text)
    return field | {"columns": columns, "rows": rows}


def _columns(node: Schema, maker: FieldFactory, before: str, *, optional: bool) -> list[dict[str, Any]]:
    columns: list[dict[str, Any]] = []
    for key, child in node.get("properties", {}).items():
        inner = resolve(child, maker.root)
        needless = optional or key not in node.get("required", ())
        forms = branches(inner, maker.root)
        if forms:
            columns.append(_column(f"{before}{key}.type", inner, "choice", {"optional": True}))
            columns[-1]["choices"] = [choice(name) for name in forms]
            held = {name: each for form in forms.values() for name, each in form["properties"].items()}
            del held["type"]
            columns += _columns({"properties": held}, maker, f"{before}{key}.", optional=True)
        elif kind_of(inner, maker.root) == "section":
            columns += _columns(inner, maker, f"{before}{key}.", optional=needless)
        else:
            kind = kind_of(inner, maker.root)
            more = maker.limits(inner, kind, (f"{before}{key}",))
            columns.append(_column(f"{before}{key}", inner, kind, {"optional": needless, **more}))
    return columns


def _column(key: str, node: Schema, kind: str, more: dict[str, Any]) -> dict[str, Any]:
    return {
        "key": key,
        "label": label_of(key.removesuffix(".type").replace(".", " ")),
        "unit": node.get("unit", ""),
        "help": node.get("description", ""),
        "kind": kind,
        **more,
    }


def _default(known: Any, robot: Any, key: Path, i: int) -> Any:
    """Return the effective value of a key that a cable does not set."""
    if known is not MISSING and known is not None:
        return known
    if key[0] == "tension":
        common = at(robot, key)
        return at(common, (i,)) if isinstance(common, list) else common
    return at(robot, key) if key[0] == "winch" else at(robot, ("cable", *key))
