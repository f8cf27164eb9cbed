"""YAML with a comment on every key: description and unit from the models."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator
from typing import Any

from pydantic import BaseModel

from cdpr.base.problems import Path
from cdpr.config.describe import Place, describe
from cdpr.config.yaml_text import flow
from cdpr.plugins.registry import Registry, Role
from cdpr.scenario.choices import CORE_KEYS, DEFAULT_TYPE

WIDTH = 110  # of a line

CommentOf = Callable[[Path], str]


def commented(model: type[BaseModel], data: dict[str, Any], plugins: Registry, head: str) -> str:
    """Return YAML of `data`, which fits `model`, after the comment `head`.

    Options of controller and solver are described by their plugins.
    """

    def comment_of(path: Path) -> str:
        if isinstance(path[-1], int):
            return ""  # items are described above the list
        place = describe(model, path, data)
        if len(path) == 2 and path[0] in CORE_KEYS and path[1] not in CORE_KEYS[path[0]]:
            place = _of_plugin(str(path[0]), path[1:], data[path[0]], plugins)
        return place.description + (f" [{place.unit}]" if place.unit else "")

    return with_comments(data, comment_of, head)


def with_comments(data: dict[str, Any], comment_of: CommentOf, head: str) -> str:
    """Return YAML of `data` after the comment `head`; `comment_of` returns the comment of a key or list item, or ""."""
    lines = [line for part in head.split("\n") for line in _comment(part, "")]
    return "\n".join([*lines, *_mapping(data, (), comment_of)]) + "\n"


def _of_plugin(role: Any, path: Path, section: dict[str, Any], plugins: Registry) -> Place:
    role_: Role = role
    return describe(plugins.get(role_, section.get("type", DEFAULT_TYPE[role])).info.options, path, section)


def _mapping(data: dict[str, Any], path: Path, comment_of: CommentOf) -> Iterator[str]:
    indent = "  " * len(path)
    for key, value in data.items():
        here = (*path, key)
        if isinstance(value, dict):
            yield from _line(f"{indent}{key}:", comment_of(here), indent)
            yield from _mapping(value, here, comment_of)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            yield from _comment(comment_of(here), indent)
            for name in value[0]:
                if text := comment_of((*here, 0, name)):
                    yield from _comment(f"  {name}: {text}", indent)
            yield f"{indent}{key}:"
            for i, item in enumerate(value):
                yield from _line(f"{indent}- {flow(item)}", comment_of((*here, i)), indent)
        else:
            yield from _line(f"{indent}{key}: {flow(value)}", comment_of(here), indent)


def _line(text: str, comment: str, indent: str) -> Iterator[str]:
    """Yield a line with its comment behind it, or above it if the line would be too long."""
    if not comment:
        yield text
    elif len(text) + len(comment) + 4 <= WIDTH:
        yield f"{text}  # {comment}"
    else:
        yield from _comment(comment, indent)
        yield text


def _comment(text: str, indent: str) -> Iterator[str]:
    before = f"{indent}# "
    lead = text[: len(text) - len(text.lstrip())]
    wrapped = textwrap.wrap(text.strip(), WIDTH - len(before) - len(lead))
    yield from (f"{before}{lead}{'' if i == 0 else '  ' * bool(lead)}{line}" for i, line in enumerate(wrapped))
