"""YAML writer whose output the strict parser reads back unchanged.

PyYAML's dumper follows YAML 1.1: it would write the text '1e-3' without quotes and tag the float 1e-05.
"""

from __future__ import annotations

import json
import re
from functools import lru_cache
from typing import Any

PLAIN = r"(?a)[A-Za-z_][\w./-]*(?: [\w./-]+)*"
ELSEWHERE = {"yes", "no", "on", "off", "true", "false", "null"}  # not text for other readers, in any case

SPECIAL = {"nan": ".nan", "inf": ".inf", "-inf": "-.inf"}


def dump(data: dict[str, Any]) -> str:
    """Return block YAML of a mapping, in its order; lists of scalars on one line, floats by `repr`."""
    return "".join(_section(json.dumps({key: value})) for key, value in data.items())


@lru_cache(maxsize=64)
def _section(content: str) -> str:
    """Return block YAML of JSON; cached, because scenarios written together often differ in one section only."""
    return "\n".join(_block(json.loads(content), "")) + "\n"


def _block(data: dict[str, Any], indent: str) -> list[str]:
    lines: list[str] = []
    for key, value in data.items():
        head = f"{indent}{_text(key)}:"
        if isinstance(value, dict) and value:
            lines += [head, *_block(value, indent + "  ")]
        elif isinstance(value, list) and any(isinstance(item, (dict, list)) for item in value):
            lines += [head, *_items(value, indent)]
        else:
            lines.append(f"{head} {flow(value)}")
    return lines


def _items(items: list[Any], indent: str) -> list[str]:
    lines: list[str] = []
    for item in items:
        if isinstance(item, dict) and item:
            first, *rest = _block(item, indent + "  ")
            lines += [f"{indent}- {first.strip()}", *rest]
        else:
            lines.append(f"{indent}- {flow(item)}")
    return lines


def flow(value: Any) -> str:
    """Return a value on one line."""
    if type(value) is float:
        text = repr(value)
        return SPECIAL.get(text, text)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_text(key)}: {flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(flow(item) for item in value) + "]"
    if isinstance(value, str):
        return _text(value)
    if value is None or isinstance(value, bool):
        return json.dumps(value)
    return repr(value)


def _text(text: str) -> str:
    if re.fullmatch(PLAIN, text) and text.lower() not in ELSEWHERE:
        return text
    quoted = json.dumps(text, ensure_ascii=False)
    return "".join(char if char.isprintable() else f"\\U{ord(char):08X}" for char in quoted)
