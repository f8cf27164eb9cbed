"""Description of a model's keys from its JSON Schema: unit, allowed keys and size."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from pydantic import BaseModel

from cdpr.base.problems import Path

Levels = Sequence[Mapping[str, Mapping[Path, None]]]  # places of keys by name, for each depth

DEEP = 4  # levels of sections in which a misplaced key is searched


@dataclass(frozen=True)
class Place:
    """Description of one key of a model."""

    unit: str = ""
    description: str = ""
    keys: tuple[str, ...] = ()  # allowed keys of a mapping
    size: int | None = None  # required length of a list
    item: str = ""  # kind of the list's items
    types: tuple[str, ...] = ()  # allowed values of `type`, if it selects one of several forms


@lru_cache(maxsize=64)
def json_schema(model: type[BaseModel]) -> dict[str, Any]:
    """Return the model's JSON Schema, or an empty one if a plugin's model has none."""
    try:
        return model.model_json_schema(by_alias=True)
    except Exception:  # third-party models may have types that JSON Schema does not support
        return {}


def describe(model: type[BaseModel], path: Path, data: Any) -> Place:
    """Return the description of `path` in `model`; the validated `data` select forms of unions."""
    _, nodes = _at(model, path, data)
    return Place(
        unit=next((node["unit"] for node in nodes if "unit" in node), ""),
        description=next((node["description"] for node in nodes if "description" in node), ""),
        keys=next((tuple(node["properties"]) for node in nodes if "properties" in node), ()),
        size=next((node["maxItems"] for node in nodes if _fixed(node)), None),
        item=next((_item(node) for node in nodes if node.get("type") == "array"), ""),
        types=tuple(constant for node in nodes if isinstance(constant := _type_of(node), str)),
    )


def below(model: type[BaseModel], path: Path, data: Any, key: str) -> list[Path]:
    """Return the places of keys of this name in the sections below `path`, relative to it, at the least depth."""
    return search_below(model, path, data)(key)


def search_below(model: type[BaseModel], path: Path, data: Any) -> Callable[[str], list[Path]]:
    """Return the function of a key that returns its places as `below` does; it serves all keys of one section."""
    whole = not path and "properties" in json_schema(model)  # the same for all data
    levels = _levels_of(model) if whole else _levels(*_at(model, path, data))
    return lambda key: next((list(places[key]) for places in levels if key in places), [])


@lru_cache(maxsize=64)
def _levels_of(model: type[BaseModel]) -> Levels:
    return _levels(*_at(model, (), None))


def _levels(root: dict[str, Any], nodes: Sequence[dict[str, Any]]) -> Levels:
    """Return the places of the keys below sections, by name, for each depth; a dict of places keeps their order."""
    level: list[tuple[Path, dict[str, Any]]] = [((), node) for node in nodes]
    levels: list[dict[str, dict[Path, None]]] = []
    for _ in range(DEEP):
        level = [
            ((*stem, name), form)
            for stem, node in level
            for name, child in node.get("properties", {}).items()
            for form in _forms(child, root, None)
        ]
        levels.append({})
        for place, _ in level:
            if len(place) > 1:
                levels[-1].setdefault(str(place[-1]), {})[place] = None
    return levels


def _at(model: type[BaseModel], path: Path, data: Any) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return the model's schema, and the forms of the value at `path` in it."""
    root = json_schema(model)
    nodes = _forms(root, root, data)
    for part in path:
        data = data[part] if _holds(data, part) else None
        nodes = [form for node in nodes for child in _children(node, part) for form in _forms(child, root, data)]
    return root, nodes


def _holds(data: Any, part: str | int) -> bool:
    if isinstance(data, dict):
        return part in data
    return isinstance(data, list) and isinstance(part, int) and part < len(data)


def _forms(node: dict[str, Any], root: dict[str, Any], data: Any) -> list[dict[str, Any]]:
    """Return the schemas after resolving references and unions; adjacent keys apply to all forms."""
    beside = {key: value for key, value in node.items() if key in ("unit", "description")}
    if "$ref" in node:
        target = root.get("$defs", {}).get(node["$ref"].rpartition("/")[2], {})
        return _forms({**target, **beside}, root, data)
    union = node.get("anyOf") or node.get("oneOf")
    if not union:
        return [node]
    forms = [form for branch in union for form in _forms({**branch, **beside}, root, data)]
    chosen = [form for form in forms if _is_type(form, data)]
    return chosen or forms


def _is_type(form: dict[str, Any], data: Any) -> bool:
    return _type_of(form) is not None and isinstance(data, dict) and data.get("type") == _type_of(form)


def _type_of(form: dict[str, Any]) -> Any:
    return form.get("properties", {}).get("type", {}).get("const")


def _children(node: dict[str, Any], part: str | int) -> list[dict[str, Any]]:
    if isinstance(part, str):
        named = [node.get("additionalProperties"), *node.get("patternProperties", {}).values()]  # user-defined keys
        child = node.get("properties", {}).get(part) or next((each for each in named if isinstance(each, dict)), None)
    else:
        items = node.get("prefixItems", [])
        child = items[part] if part < len(items) else node.get("items")
    if not isinstance(child, dict):
        return []
    return [{"unit": node["unit"], **child}] if "unit" in node else [child]


def _fixed(node: dict[str, Any]) -> bool:
    return "maxItems" in node and node.get("minItems") == node["maxItems"]


def _item(node: dict[str, Any]) -> str:
    items = node.get("prefixItems") or [node.get("items", {})]
    return "numbers" if all(item.get("type") in ("number", "integer") for item in items) else ""
