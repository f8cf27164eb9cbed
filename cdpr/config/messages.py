"""Conversion of pydantic errors into one message per problem, in terms of a scenario.

Pydantic reports a union once per branch and a short tuple once per missing item, without units and allowed keys. Here a
union gives the errors of the intended branch, or one message that names all branches.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sized
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from pydantic import BaseModel, ValidationError

from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import Path, dotted, shown
from cdpr.base.units import known_unit
from cdpr.config.describe import Place, describe, search_below

# Errors of type "wrong kind of value", with the expected kind.
KINDS = {
    "float_type": "a number",
    "float_parsing": "a number",
    "int_type": "a whole number",
    "int_parsing": "a whole number",
    "int_from_float": "a whole number",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "string_type": "a text",
    "tuple_type": "a list",
    "list_type": "a list",
    "dict_type": "a mapping",
    "model_type": "a mapping",
    "model_attributes_type": "a mapping",
    "literal_error": "",
    "none_required": "null",
}

DECIMAL = r"[-+]?[0-9]+,[0-9]+(?:[eE][-+]?[0-9]+)?"  # a number with a decimal comma

QUANTITY = r"([-+]?(?:[0-9]+(?:[.,][0-9]*)?|[.,][0-9]+)(?:[eE][-+]?[0-9]+)?) ?([^\W\d].{0,19}|%|°)"  # 25 kg

BOUNDS = {
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
}


OBVIOUS = 4  # items up to which a list needs no explanation, as a quaternion
FEW = 3  # largest number of suggested places for a misplaced key

Search = Callable[[str], list[Path]]  # places of keys of this name in the whole file


@dataclass(frozen=True)
class Message:
    """Problem of a model: path, message, and whether the key itself is wrong."""

    path: Path
    text: str
    at_key: bool = False


@dataclass(frozen=True)
class _Fault:
    type: str
    path: Path
    unions: tuple[tuple[Path, str], ...]  # unions on the way: path and branch
    value: Any
    context: dict[str, Any]
    message: str
    kinds: tuple[str, ...] = ()  # kinds of value expected by all branches together


def explain(
    error: ValidationError,
    model: type[BaseModel],
    data: Any,
    core_keys: Iterable[str] = (),
    search: Search | None = None,
    base: Path = (),
) -> list[Message]:
    """Return the problems of `data`; `core_keys` are allowed in addition to the keys of `model`.

    `search` finds other places of an unknown key in the file, whose section `base` is `data`. By default, only the
    sections below the key's own are searched.
    """
    faults = [_fault(row, data) for row in error.errors(include_url=False) if not _implied(row)]
    faults = [replace(fault, kinds=_kinds(fault, model, data)) for fault in faults]
    messages: dict[Path, Message] = {}
    nearby = cache(lambda section: search_below(model, section, data))
    for fault in _collapse(faults, 0):
        messages.setdefault(fault.path, _message(fault, model, data, tuple(core_keys), nearby, search, base))
    return list(messages.values())


def _implied(row: Any) -> bool:
    """Return True for an error of pydantic that another one explains, such as too few items of which some are wrong."""
    if row["type"] == "default_factory_not_called":
        return True
    return (
        row["type"] == "too_short" and isinstance(row["input"], Sized) and len(row["input"]) >= row["ctx"]["min_length"]
    )


def _fault(row: Any, data: Any) -> _Fault:
    """Split pydantic's location into the path in the data and the branches of unions."""
    path: Path = ()
    unions: list[tuple[Path, str]] = []
    node = data
    kind = row["type"]
    for i, part in enumerate(row["loc"]):
        is_key = (isinstance(node, dict) and part in node) or (
            isinstance(node, list) and isinstance(part, int) and part < len(node)
        )
        if is_key and not _is_branch(node, row["loc"][i:], kind):
            node = node[part]
            path = (*path, part)
        elif kind == "missing" and i == len(row["loc"]) - 1:
            if isinstance(part, int):  # an item of a tuple: the list is too short
                kind = "wrong_size"
            else:
                path = (*path, part)
        else:
            unions.append((path, str(part)))
    if kind in ("too_long", "too_short"):
        kind = "wrong_size"
    return _Fault(kind, path, tuple(unions), row["input"], row.get("ctx", {}), row["msg"])


def _is_branch(node: Any, rest: tuple[int | str, ...], kind: str) -> bool:
    """Return True if the first part of a location names the `type` of a section that also has a key of this name."""
    if not isinstance(node, dict) or node.get("type") != rest[0] or len(rest) < 2:
        return False
    return rest[1] in node or (kind == "missing" and len(rest) == 2)


def _collapse(faults: list[_Fault], depth: int) -> list[_Fault]:
    """Reduce each union to the errors of the intended branch, or to one that names all branches."""
    result = [fault for fault in faults if len(fault.unions) <= depth]
    roots = dict.fromkeys(fault.unions[depth][0] for fault in faults if len(fault.unions) > depth)
    for root in roots:
        branches: dict[str, list[_Fault]] = {}
        for fault in faults:
            if len(fault.unions) > depth and fault.unions[depth][0] == root:
                branches.setdefault(fault.unions[depth][1], []).append(fault)
        result += _likely_branch(root, [_collapse(branch, depth + 1) for branch in branches.values()])
    return result


def _likely_branch(root: Path, branches: list[list[_Fault]]) -> list[_Fault]:
    """Return the errors of the branch that accepts the given kind of value; merge all branches if there is none."""
    for branch in branches:
        if not any(fault.path == root and fault.type in KINDS for fault in branch):
            return branch
    wrong = [fault for branch in branches for fault in branch if fault.path == root and fault.type in KINDS]
    kinds = dict.fromkeys(kind for fault in wrong for kind in fault.kinds)
    return [replace(wrong[0], kinds=tuple(kinds))]


def _kinds(fault: _Fault, model: type[BaseModel], data: Any) -> tuple[str, ...]:
    if fault.type not in KINDS:
        return ()
    if fault.type == "literal_error":
        return (f"one of {_listed(fault.context['expected'])}",)
    place = describe(model, fault.path, data)
    if fault.type in ("tuple_type", "list_type"):
        return (f"{place.size} {place.item}" if place.size else f"a list{place.item and ' of '}{place.item}",)
    if KINDS[fault.type] == "a mapping" and place.keys:
        return (f"a mapping ({', '.join(place.keys)})",)
    return (KINDS[fault.type],)


def _message(
    fault: _Fault,
    model: type[BaseModel],
    data: Any,
    core_keys: tuple[str, ...],
    nearby: Callable[[Path], Search],
    search: Search | None,
    base: Path,
) -> Message:
    path, found = fault.path, shown(fault.value)
    place = describe(model, path, data)
    unit = f" ({place.unit})" if place.unit else ""
    if fault.type == "missing":
        meaning = f": {place.description}" if place.description else ""
        return Message(path, f"required but not given{meaning}{unit}")
    if fault.type == "extra_forbidden":
        allowed = (*core_keys, *describe(model, path[:-1], data).keys)
        return _unknown_key(path, allowed, _key_meant(fault, allowed, nearby, search, base))
    if fault.type in ("union_tag_invalid", "union_tag_not_found", "model_attributes_type") and place.types:
        return _unknown_type(fault, place.types)
    if fault.type == "literal_error" and len(fault.kinds) == 1:
        hint = did_you_mean(str(fault.value), _words(fault.context["expected"]))
        return Message(path, f"expected {fault.kinds[0]}, got {found}{'; ' + hint.strip() if hint else ''}")
    if fault.kinds:
        return Message(path, f"expected {' or '.join(fault.kinds)}{unit}, got {found}{_remedy(fault, place)}")
    if fault.type == "finite_number":
        return Message(path, f"expected a finite number{unit}, got {found}")
    if fault.type in BOUNDS:
        words, key = BOUNDS[fault.type]
        limit = fault.context[key]
        limit = f"{limit:g}" if isinstance(limit, float) else str(limit)
        return Message(path, f"must be {words} {limit}{unit}, got {found}")
    if fault.type == "wrong_size":
        return Message(path, _wrong_size(fault, place, unit))
    if "error" in fault.context:  # a ValueError of a model's own validator
        return Message(path, str(fault.context["error"]))
    return Message(path, f"{fault.message[:1].lower()}{fault.message[1:]}{unit}, got {found}")


def _remedy(fault: _Fault, place: Place) -> str:
    """Return advice on numbers with decimal comma or unit, and on a bare `type`."""
    unit = place.unit
    if isinstance(fault.value, str) and "type" in place.keys:
        return f"; write {{type: {fault.value}}}"
    if not isinstance(fault.value, str) or not {"a number", "a whole number"} & set(fault.kinds):
        return ""
    if re.fullmatch(DECIMAL, fault.value):
        return f"; write {fault.value.replace(',', '.')}, with a point"
    quantity = re.fullmatch(QUANTITY, fault.value)
    if not quantity:
        return ""
    number, given, wanted = quantity[1].replace(",", "."), known_unit(quantity[2]), known_unit(unit)
    if given is None or wanted is None or given.exponents != wanted.exponents:
        return f"; write the number alone{unit and f', in {unit}'}"
    value = number if given.factor == wanted.factor else f"{float(number) * given.factor / wanted.factor:.12g}"
    return f"; write {value}, without the unit: it is always {unit}"


def _unknown_key(path: Path, allowed: tuple[str, ...], hint: str) -> Message:
    listed = f"allowed: {', '.join(allowed)}" if allowed else "none is allowed here"
    return Message(path, f"unknown key {shown(path[-1])}: {hint}{listed}", at_key=True)


def _key_meant(
    fault: _Fault, allowed: tuple[str, ...], nearby: Callable[[Path], Search], search: Search | None, base: Path
) -> str:
    """Return a suggestion: the same key in deeper sections, else a similar allowed key, else the key anywhere.

    If the unknown key is a section with a single key, as in `--set a.b=1`, the single key is searched, too.
    """
    *parent, key = fault.path
    in_file = search if search is not None else lambda _: []
    at_root = search is not None and not base and not parent
    places = in_file(str(key)) if at_root else nearby(tuple(parent))(str(key))
    if hint := _places(places, written=True) or did_you_mean(str(key), allowed) or _places(in_file(str(key))):
        return hint
    value = fault.value
    while isinstance(value, dict) and len(value) == 1:
        ((key, value),) = value.items()
    return _places(in_file(str(key)))


def _places(places: list[Path], written: bool = False) -> str:
    """Return a suggestion of a few places of a key, with the YAML text if there is only one and it is `written`."""
    text = f", written {_nested(places[0])}" if written and len(places) == 1 else ""
    return f"did you mean {' or '.join(map(dotted, places))}{text}? " if 0 < len(places) <= FEW else ""


def _nested(path: Path) -> str:
    return f"{path[0]}: {{{_nested(path[1:])}}}" if len(path) > 1 else f"{path[0]}: ..."


def _unknown_type(fault: _Fault, types: tuple[str, ...]) -> Message:
    listed = f"allowed: {', '.join(types)}"
    if not isinstance(fault.value, dict):
        return Message(fault.path, f"expected a mapping with a type ({listed}), got {shown(fault.value)}")
    path = (*fault.path, "type")
    if "type" not in fault.value:
        return Message(path, f"required but not given; {listed}")
    given = fault.value["type"]
    return Message(path, f"unknown type {shown(given)}: {did_you_mean(str(given), types)}{listed}")


def _wrong_size(fault: _Fault, place: Place, unit: str) -> str:
    found = len(fault.value) if isinstance(fault.value, list) else 0
    if place.size is not None:
        meaning = place.description.partition(";")[0]
        which = f": {meaning}" if place.size > OBVIOUS and meaning.count(",") >= place.size - 1 else ""
        return f"expected {place.size} {place.item or 'items'}{unit}{which}, got {found}"
    if "max_length" in fault.context and found > fault.context["max_length"]:
        return f"expected at most {fault.context['max_length']} items, got {found}"
    return f"expected {fault.context.get('min_length', 1)} or more items, got {found}"


def _words(listed: str) -> list[str]:
    """Split pydantic's list "'a', 'b' or 'c'"."""
    return [word.strip(" '") for word in listed.replace(" or ", ", ").split(",") if word.strip(" '")]


def _listed(expected: str) -> str:
    return ", ".join(_words(expected))
