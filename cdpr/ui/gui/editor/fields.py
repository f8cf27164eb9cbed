"""Form fields generated from a schema: type, unit, help and current value of each key.

Fields are plain data for the page. Values in the file are shown as written, even if they are invalid.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from cdpr.base.colours import COLOURS
from cdpr.base.problems import Path, dotted
from cdpr.config.yaml_text import flow

Field = dict[str, Any]
Schema = dict[str, Any]

# Sections with exactly one of several keys, which determines their form.
ONE_OF: dict[str, tuple[str, ...]] = {
    "ShapeSection": ("box", "sphere", "cylinder", "mesh"),
    "Orientation": ("rpy", "rpy_deg", "quaternion", "euler"),
}
BOUNDS = {
    "minimum": ("least", False),
    "exclusiveMinimum": ("least", True),
    "maximum": ("most", False),
    "exclusiveMaximum": ("most", True),
}
COORDINATES = {3: ["x", "y", "z"], 4: ["w", "x", "y", "z"]}
TURNS = ["roll", "pitch", "yaw"]
TENSOR = ["xx", "yy", "zz", "xy", "xz", "yz"]
WRENCH = ["x", "y", "z", "rx", "ry", "rz"]


class _Missing:
    def __bool__(self) -> bool:
        return False


ANY: Schema = {}  # schema without constraints
MISSING: Any = _Missing()  # marks an absent value


_resolved: dict[int, tuple[Schema, Schema, Schema]] = {}  # by id of the node; the cache keeps the node alive


def resolve(node: Schema, root: Schema) -> Schema:
    """Return a node without references; nullable nodes are marked `optional`, and sections get their `name`."""
    if id(node) not in _resolved:
        resolved = _resolve(node, root)
        _resolved[id(node)] = (node, root, resolved)
        _resolved[id(resolved)] = (resolved, root, resolved)
    return _resolved[id(node)][2]


def _resolve(node: Schema, root: Schema) -> Schema:
    beside: Schema = {key: node[key] for key in ("description", "unit", "default", "optional") if key in node}
    if "$ref" in node:
        name = node["$ref"].rpartition("/")[2]
        return _resolve({**root.get("$defs", {}).get(name, {}), "name": name, **beside}, root)
    union = node.get("anyOf")
    if union is None:
        return node
    real = [each for each in union if each != {"type": "null"}]
    if len(real) < len(union):
        beside["optional"] = True
    if len(real) == 1:
        return _resolve({**real[0], **beside}, root)
    return {**beside, "anyOf": [_resolve(each, root) for each in real]}


def branches(node: Schema, root: Schema) -> dict[str, Schema]:
    """Return the variants of a section by their `type`."""
    mapping = node.get("discriminator", {}).get("mapping", {})
    return {name: resolve(root["$defs"][target.rpartition("/")[2]], root) for name, target in mapping.items()}


def kind_of(node: Schema, root: Schema) -> str:
    """Return the kind of field for values of a resolved node."""
    if "enum" in node or "const" in node:
        return "choice"
    if "discriminator" in node or (node.get("type") == "object" and "properties" in node):
        return "section"
    simple = {"number": "number", "integer": "integer", "boolean": "flag", "string": "text"}
    if (kind := node.get("type")) in simple:
        return "colour" if set(COLOURS) <= set(node.get("examples", ())) else simple[str(kind)]
    if kind == "array":
        return _kind_of_list(node, root)
    forms = node.get("anyOf", [])
    kinds = {str(form.get("type")) for form in forms}
    if kinds <= {"number", "integer"} and kinds:
        return "number"
    if kinds <= {"string", "integer", "number"} and kinds:
        return "text"
    lists = [form for form in forms if form.get("type") == "array"]
    if kinds <= {"number", "array"} and lists and all(_numbers(form) for form in lists):
        return "vector"
    return "yaml"


def _kind_of_list(node: Schema, root: Schema) -> str:
    if _numbers(node) and "prefixItems" in node:
        return "vector"
    item = resolve(node.get("items", ANY), root)
    if "enum" in item:
        return "set"
    return "list" if "discriminator" in item or "properties" in item else "yaml"


def _numbers(node: Schema) -> bool:
    items = node.get("prefixItems") or [node.get("items", ANY)]
    return all(item.get("type") in ("number", "integer") for item in items)


def label_of(key: str | int) -> str:
    """Return a key as a label."""
    return f"{key + 1}" if isinstance(key, int) else key.replace("_", " ")


def choice(value: str, text: str = "", missing: str | None = None) -> dict[str, Any]:
    """Return an item of a choice; `missing` is the command that installs what it requires."""
    return {"value": value, "label": label_of(value), "help": text, "missing": missing}


def entry(
    path: Path,
    kind: str,
    value: Any,
    *,
    given: bool,
    optional: bool,
    label: str | None = None,
    unit: str = "",
    text: str = "",
) -> Field:
    """Return the common part of all fields; the label defaults to the last key of `path`."""
    return {
        "path": dotted(path),
        "label": label or (label_of(path[-1]) if path else ""),
        "unit": unit,
        "help": text,
        "kind": kind,
        "value": value,
        "given": given,
        "optional": optional,
    }


class FieldFactory:
    """Factory of fields from a schema and the data of a file.

    Attributes:
        root: the schema.
        known: effective values, in the structure of the file, for keys that are not set.
        choices: allowed values at some paths, in addition to the schema.
    """

    def __init__(self, root: Schema, known: Any = MISSING, choices: Mapping[str, list[dict[str, Any]]] = {}) -> None:
        self.root, self.known, self.choices = root, known, choices

    def field(self, node: Schema, path: Path, data: Any, known: Any = MISSING, *, needed: bool = False) -> Field:
        """Return the field for the value at `path`; `data` is MISSING if there is none."""
        node = resolve(node, self.root)
        kind = kind_of(node, self.root)
        given = data is not MISSING
        own = self.choices.get(dotted(path))
        if own is not None and kind in ("text", "yaml"):
            kind = "choice"
        if given and ((kind == "section" and not isinstance(data, dict)) or (kind == "list" and not _rows(data))):
            kind = "yaml"
        if known is MISSING or known is None:
            known = node.get("default", MISSING)
        unit, text = node.get("unit", ""), node.get("description", "")
        field = entry(path, kind, None, given=given, optional=not needed, unit=unit, text=text)
        if kind == "section":
            return field | self._section(node, path, data, known)
        if kind == "list":
            return field | self._list(node, path, data)
        field["value"] = shown(data if given else known, kind)
        return field | self.limits(node, kind, path)

    def limits(self, node: Schema, kind: str, path: Path) -> Field:
        """Return the allowed values of a resolved node."""
        more: Field = {}
        if kind in ("choice", "set"):
            holder = node if kind == "choice" else resolve(node.get("items", ANY), self.root)
            values = [holder["const"]] if "const" in holder else holder.get("enum", [])
            more["choices"] = self.choices.get(dotted(path)) or [choice(str(value)) for value in values]
        forms = node.get("anyOf", [node])
        if kind == "vector":
            lists = next(form for form in forms if form.get("type") == "array")
            size = len(lists.get("prefixItems", ())) or None
            more |= {"size": size, "single": len(forms) > 1, "labels": _labels(path, size)}
            forms = [*lists.get("prefixItems", ()), lists.get("items", {}), *forms]
        for form in forms:
            for key, (name, opened) in BOUNDS.items():
                if key in form and name not in more:
                    more |= {name: form[key], f"{name}_open": opened}
        return more

    def fields(self, node: Schema, path: Path, data: Any, known: Any = MISSING) -> list[Field]:
        """Return the fields of a section's keys, including unknown keys in the data."""
        given = data if isinstance(data, dict) else {}
        needed = node.get("required", ())
        properties = {key: child for key, child in node.get("properties", {}).items() if "const" not in child}
        known_fields = [
            self.field(child, (*path, key), given.get(key, MISSING), part(known, key), needed=key in needed)
            for key, child in properties.items()
        ]
        spare = [key for key in given if key not in node.get("properties", {})]
        return [*known_fields, *(self.odd((*path, key), given[key]) for key in spare)]

    def odd(self, path: Path, value: Any) -> Field:
        """Return the field of an unknown key."""
        return entry(path, "yaml", flow(value), given=True, optional=True)

    def _section(self, node: Schema, path: Path, data: Any, known: Any) -> Field:
        forms = branches(node, self.root)
        if forms:
            given = data if isinstance(data, dict) else known if isinstance(known, dict) else {}
            chosen = given.get("type", forms[next(iter(forms))].get("properties", {}).get("type", {}).get("default"))
            choices = [choice(name, _about(form)) for name, form in forms.items()]
            form = forms.get(str(chosen), {"properties": {"type": {"const": ""}}})
            return {"value": chosen, "choices": choices, "fields": self.fields(form, path, data, known)}
        alternatives = ONE_OF.get(node.get("name", ""), ())
        if not alternatives:
            return {"fields": self.fields(node, path, data, known)}
        given = data if isinstance(data, dict) else known if isinstance(known, dict) else {}
        held = [key for key in alternatives if given.get(key) is not None]
        texts = {key: resolve(node["properties"][key], self.root).get("description", "") for key in alternatives}
        rows = self.fields(node, path, data, known)
        spare = [key for key in (data or {}) if key not in alternatives]
        visible = {dotted((*path, key)) for key in (*held, *spare)}
        return {
            "value": held[0] if held else None,
            "choices": [choice(key, texts[key]) for key in alternatives],
            "fields": [row for row in rows if row["path"] in visible],
        }

    def _list(self, node: Schema, path: Path, data: Any) -> Field:
        item = resolve(node.get("items", ANY), self.root)
        rows = data if isinstance(data, list) else []
        forms = branches(item, self.root)
        return {
            "value": len(rows),
            "choices": [choice(name, _about(form)) for name, form in forms.items()],
            "fields": [self.field(item, (*path, i), row) for i, row in enumerate(rows)],
        }


def part(data: Any, key: str | int) -> Any:
    """Return the value of a key in plain data, or MISSING."""
    if isinstance(data, dict):
        return data.get(str(key), MISSING)
    return data[key] if isinstance(data, list) and isinstance(key, int) and key < len(data) else MISSING


def at(data: Any, path: Path) -> Any:
    """Return the value at a path in plain data, or MISSING."""
    for key in path:
        data = part(data, key)
    return data


def shown(value: Any, kind: str) -> Any:
    """Return a value as the field shows it; values that do not fit the field are shown as YAML."""
    if value is None or value is MISSING:
        return None
    if kind == "yaml":
        return flow(value)
    if isinstance(value, dict) or (isinstance(value, list) and kind not in ("vector", "set")):
        return flow(value)
    if isinstance(value, list):
        return [shown(item, "number") for item in value]
    return flow(value) if isinstance(value, float) and not math.isfinite(value) else value


def every(fields: Iterable[Field]) -> Iterable[Field]:
    """Yield fields and all nested fields."""
    for field in fields:
        yield field
        yield from every(field.get("fields", ()))


def _rows(data: Any) -> bool:
    return isinstance(data, list)


def _about(form: Schema) -> str:
    return str(form.get("properties", {}).get("type", {}).get("description") or form.get("description", ""))


def _labels(path: Path, size: int | None) -> list[str] | None:
    """Return the names of a vector's components."""
    key = path[-1] if path else ""
    if key == "inertia":
        return TENSOR
    if key in ("rpy", "rpy_deg"):
        return TURNS
    if key in ("angles", "angles_deg"):
        return ["1st", "2nd", "3rd"]
    return WRENCH if size == 6 else COORDINATES.get(size or 0)
