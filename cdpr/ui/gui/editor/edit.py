"""Edits of a YAML text that preserve everything else: comments, order, spacing, quotes and line ends.

A value is changed in place. The result is parsed and compared with the intended data; an edit that gives anything else
is rejected, so that file and form always agree. Aliases (*name) of edited values are expanded first.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any, Literal

from cdpr.base.errors import CdprError
from cdpr.base.problems import Path, dotted
from cdpr.config.document import copied
from cdpr.config.overrides import plain_value
from cdpr.config.problems import Problems
from cdpr.config.yaml_nodes import parse
from cdpr.config.yaml_text import dump, flow
from cdpr.ui.gui.editor.tree import Node, after_break, blank_end, line_break, line_end, line_start, tree

WIDTH = 110  # of a newly written line

Step = tuple[Literal["put", "add", "cut", "append"], Path, Any]


def set_value(text: str, path: Path, value: Any) -> str:
    """Return the text with a value at `path`; missing parent sections are created.

    Existing lists and sections are changed item by item.

    Raises:
        CdprError: if the value cannot be written.
    """
    before = read(text)
    try:
        value = plain_value(value)
    except ValueError as error:
        raise CdprError(f"{dotted(path)}: {error}") from None
    meant = copied(before)
    _assign(meant, path, value)
    return _reach(text, before, meant)


def remove(text: str, path: Path) -> str:
    """Return the text without a key or list item.

    Raises:
        CdprError: if it does not exist.
    """
    before = read(text)
    meant = copied(before)
    holder = _at(meant, path[:-1])
    keys = list(holder) if isinstance(holder, dict) else range(len(holder)) if isinstance(holder, list) else ()
    if not path or path[-1] not in keys:
        raise CdprError(f"{dotted(path)}: is not given in the file, so it cannot be removed")
    del holder[path[-1]]
    return _checked(_cut(_unshared(text, path), path), meant)


def insert(text: str, path: Path, value: Any) -> str:
    """Return the text with an item appended to the list at `path`, which is created if missing."""
    items = _at(read(text), path)
    if items is not None and not isinstance(items, list):
        raise CdprError(f"{dotted(path)}: is not a list, so nothing can be inserted")
    return set_value(text, path, [*(items or []), value])


def read(text: str) -> dict[str, Any]:
    """Return the data of a text.

    Raises:
        CdprError: if it is not valid YAML.
    """
    problems = Problems()
    document = parse(text, "", problems)
    if document is None:
        raise CdprError(f"not written: {problems.items[0].text}")
    return document.data


def same(one: Any, other: Any) -> bool:
    """Return True if plain data are equal, including types; the order of keys is ignored."""
    return json.dumps(one, sort_keys=True) == json.dumps(other, sort_keys=True)


def _assign(data: Any, path: Path, value: Any) -> None:
    """Set a value in plain data."""
    if not path:
        raise CdprError("a key is missing")
    node = data
    for i, part in enumerate(path):
        last = i == len(path) - 1
        if isinstance(node, dict) and isinstance(part, str):
            if last:
                node[part] = value
            elif node.get(part) is None:
                node[part] = {}
        elif isinstance(node, list) and isinstance(part, int) and part < len(node):
            if last:
                node[part] = value
        else:
            raise CdprError(f"{dotted(path)}: there is no {dotted(path[: i + 1])} in the file")
        node = node[part]


def _at(data: Any, path: Path) -> Any:
    for part in path:
        if isinstance(data, dict):
            data = data.get(str(part))
        elif isinstance(data, list) and isinstance(part, int) and part < len(data):
            data = data[part]
        else:
            return None
    return data


def _reach(text: str, before: dict[str, Any], meant: dict[str, Any]) -> str:
    """Transform the text from the old to the new data in small steps."""
    for kind, path, value in _steps(before, meant, ()):
        if kind == "put":
            text = _put(_unshared(text, path), path, value)
        elif kind == "add":
            text = _add(_unshared(text, path[:-1], below=False), path[:-1], str(path[-1]), value)
        elif kind == "append":
            text = _append(_unshared(text, path, below=False), path, value)
        else:
            text = _cut(_unshared(text, path), path)
    return _checked(text, meant)


def _steps(old: Any, new: Any, path: Path) -> Iterator[Step]:
    """Yield the steps, in order, that transform the old value into the new one."""
    if same(old, new):
        return
    if isinstance(old, dict) and isinstance(new, dict) and (new or not path):
        kept = [key for key in old if key in new]
        for key in kept:
            yield from _steps(old[key], new[key], (*path, key))
        yield from (("add", (*path, key), value) for key, value in new.items() if key not in old)
        yield from (("cut", (*path, key), None) for key in old if key not in new)
    elif isinstance(old, list) and isinstance(new, list) and old and new:
        for i, (one, other) in enumerate(zip(old, new, strict=False)):
            yield from _steps(one, other, (*path, i))
        yield from (("append", path, value) for value in new[len(old) :])
        yield from (("cut", (*path, i), None) for i in reversed(range(len(new), len(old))))
    else:
        yield "put", path, new


def _checked(text: str, meant: dict[str, Any]) -> str:
    """Return the text if its data equal `meant`; raise CdprError otherwise."""
    if not same(read(text), meant):
        raise CdprError("this change would alter the rest of the file: edit the text directly")
    return text


def _unshared(text: str, path: Path, *, below: bool = True) -> str:
    """Expand the aliases affected by an edit: on the path and, if `below`, inside the value."""
    while True:
        root = tree(text)
        chain = root.chain(path)
        whole = below and len(chain) == len(path) + 1  # the value goes: the target of its alias can stay
        names = {node.name for node in (chain[:-1] if whole else chain) if node.kind != "alias"}
        names |= {node.name for _, node in chain[-1].walk() if node.kind != "alias"} if below else set()
        through = [] if whole else chain[-1:]
        aliases = [(at, node) for at, node in root.walk() if node.kind == "alias"]
        found = next(((at, node) for at, node in aliases if node in through or node.name in names), None)
        if found is None:
            return text
        at, alias = found
        text = text[: alias.start] + flow(_at(read(text), at)) + text[alias.end :]


def _put(text: str, path: Path, value: Any) -> str:
    """Replace the value at `path`."""
    chain = tree(text).chain(path)
    node, around = chain[-1], chain[-2]
    inline = any(each.flow for each in chain[:-1])
    start, end = node.start, node.end
    if inline or around.kind == "list" or ((node.kind in ("scalar", "alias") or node.flow) and not _tall(value, path)):
        space = " " if start == end and not text[start - 1].isspace() else ""  # the value was empty
        return text[:start] + space + _quoted(value, node.style) + text[end:]
    key = around.keys[around.index(path[-1]) or 0]
    colon = text.index(":", blank_end(text, key.end)) + 1
    broken = line_end(text, colon)
    if not _tall(value, path) and node.outer < broken:
        return text[: node.outer] + flow(value) + text[end:]
    head = text[colon:broken].rstrip() if broken <= node.outer else ""
    rest = line_end(text, end)
    tail = text[end:rest].rstrip()
    after = text[rest:]
    if not _tall(value, path):
        return f"{text[:colon]} {flow(value)}{head}{tail}{after}"
    lines = _lines(value, _column(text, key))
    return text[:colon] + head + tail + "".join(line_break(text) + line for line in lines) + after


def _add(text: str, path: Path, word: str, value: Any) -> str:
    """Add a key to the mapping at `path`."""
    chain = tree(text).chain(path)
    node = chain[-1]
    if node.kind != "mapping":  # the value is empty
        return _put(text, path, {word: value})
    pair = flow({word: value})[1:-1]
    if node.flow:
        return _into_brackets(text, node, pair)
    column = _column(text, node.keys[0])
    at = line_end(text, node.end)
    if _tall(value, (*path, word)):
        lines = [" " * column + pair[: len(pair) - len(flow(value))].rstrip(), *_lines(value, column)]
    else:
        lines = [" " * column + pair]
    return text[:at] + "".join(line_break(text) + line for line in lines) + text[at:]


def _append(text: str, path: Path, value: Any) -> str:
    """Append an item to the non-empty list at `path`."""
    node = tree(text).chain(path)[-1]
    if node.flow:
        return _into_brackets(text, node, flow(value))
    at = line_end(text, node.end)
    return f"{text[:at]}{line_break(text)}{' ' * _column(text, node)}- {flow(value)}{text[at:]}"


def _into_brackets(text: str, node: Node, written: str) -> str:
    """Append an item to a flow mapping or list."""
    if not node.items:
        return text[: node.start + 1] + written + text[node.start + 1 :]
    last = node.items[-1]
    return f"{text[: last.end]}, {written}{text[last.end :]}"


def _cut(text: str, path: Path) -> str:
    """Remove the key or item at `path`."""
    chain = tree(text).chain(path)
    node, around = chain[-1], chain[-2]
    i = around.index(path[-1])
    assert i is not None
    if len(around.items) == 1:
        if len(path) == 1:
            raise CdprError(f"{dotted(path)}: is the only key of the file; it cannot be removed")
        return _put(text, path[:-1], {} if around.kind == "mapping" else [])
    firsts = around.keys if around.kind == "mapping" else around.items
    if around.flow:
        if i + 1 < len(firsts):
            return text[: firsts[i].outer] + text[firsts[i + 1].outer :]
        return text[: around.items[i - 1].end] + text[node.end :]
    start = firsts[i].outer if around.kind == "mapping" else _dash(text, around, i)
    below = after_break(text, node.end)
    if not text[line_start(text, start) : start].strip():  # alone on its lines
        return text[: line_start(text, start)] + text[below:]
    following = firsts[i + 1].outer if around.kind == "mapping" else _dash(text, around, i + 1)
    return text[:start] + text[following:]


def _dash(text: str, items: Node, i: int) -> int:
    """Return the offset of an item's dash in a block list."""
    return items.start if i == 0 else blank_end(text, items.items[i - 1].end)


def _column(text: str, node: Node) -> int:
    return node.start - line_start(text, node.start)


def _tall(value: Any, path: Path) -> bool:
    """Return True if a value takes several lines."""
    if isinstance(value, list):
        return any(isinstance(item, dict) for item in value)
    if not isinstance(value, dict) or not value:
        return False
    return len(flow(value)) + len(dotted(path)) > WIDTH or any(_tall(item, path) for item in value.values())


def _lines(value: Any, column: int) -> list[str]:
    """Return the lines of a value below a key at this column."""
    if isinstance(value, list):
        return [f"{' ' * column}- {flow(item)}" for item in value]
    return [f"{' ' * (column + 2)}{line}" for line in dump(value).splitlines()]


def _quoted(value: Any, style: str) -> str:
    """Return a value on one line, with a text's previous quotes."""
    if isinstance(value, str) and style in ("'", '"') and value.isprintable() and not set(value) & {"'", '"', "\\"}:
        return f"{style}{value}{style}"
    return flow(value)
