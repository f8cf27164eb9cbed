"""Type hash of ROS 2 messages: RIHS01, the SHA-256 of a type's description (REP 2016)."""

from __future__ import annotations

import hashlib
import json
from functools import cache
from typing import Any

from cdpr.log.ros2 import fields, full_name, item

# type_description_interfaces/msg/FieldType: type numbers, and offsets of arrays and sequences.
_NESTED = 1
_KINDS = {"uint8": 3, "int32": 6, "uint32": 7, "int64": 8, "uint64": 9, "float32": 10, "float64": 11}
_KINDS |= {"bool": 15, "byte": 16, "string": 17}
_ARRAY, _BOUNDED, _UNBOUNDED = 48, 96, 144


@cache
def type_hash(kind: str) -> str:
    """Return the hash of a type known to `cdpr.log.ros2.fields`: "RIHS01_" and 64 digits."""
    needed = [kind]
    for known in needed:  # grows during the iteration
        parts = (item(part)[0] for part, _ in fields(known))
        needed += [part for part in dict.fromkeys(parts) if part not in _KINDS and part not in needed]
    described = {
        "type_description": _described(kind),
        "referenced_type_descriptions": sorted(map(_described, needed[1:]), key=lambda one: one["type_name"]),
    }
    return f"RIHS01_{hashlib.sha256(json.dumps(described).encode()).hexdigest()}"


def _described(kind: str) -> dict[str, Any]:
    return {
        "type_name": full_name(kind),
        "fields": [{"name": name, "type": _type(part)} for part, name in fields(kind)],
    }


def _type(kind: str) -> dict[str, Any]:
    part, size, bounded = item(kind)
    added = 0 if size is None else _ARRAY if not bounded else _BOUNDED if size else _UNBOUNDED
    return {
        "type_id": _KINDS.get(part, _NESTED) + added,
        "capacity": size or 0,
        "string_capacity": 0,
        "nested_type_name": "" if part in _KINDS else full_name(part),
    }
