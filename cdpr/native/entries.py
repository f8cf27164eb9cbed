"""C++ sources of exported programs: the headers, and the entries of the operations.

Entries of the kernel library are in its tables, `cdpr/native/tables/*.cpp`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

from cdpr.base.errors import CdprError
from cdpr.native import get_include
from cdpr.native.own import Own

NATIVE = Path(__file__).parent
TABLE = "operations.cpp"

ENTRY = re.compile(r'\bentry<((?:(?!\bentry<).)*?)>\(\s*"(\w+)"\)', re.DOTALL)
INCLUDE = re.compile(r"^\s*#\s*include\s*<([\w/]+\.(?:hpp|h))>", re.MULTILINE)


class Entry(NamedTuple):
    """Operation: `header` contains the struct and the function that are the arguments of its `entry<...>`."""

    header: str
    symbols: str


def listing(names: Iterable[str], own: Mapping[str, Entry] | None = None) -> tuple[list[str], dict[str, str]]:
    """Return the lines that include the headers of operations, and the C++ expression of each entry by name."""
    entries = {name: (own or {}).get(name) or entry_of(name) for name in sorted(set(names))}
    headers = sorted({entry.header for entry in entries.values()})
    includes = [f'#include "{header}"' if header.startswith("own/") else f"#include <{header}>" for header in headers]
    return includes, {name: f'entry<{entry.symbols}>("{name}")' for name, entry in entries.items()}


def own_entries(own: Mapping[str, Own]) -> tuple[dict[str, bytes], dict[str, Entry]]:
    """Return the headers of operations that are not in the kernel library, and the operations' entries."""
    headers = {f"own/{each.header.name}": each.header.read_bytes() for each in own.values()}
    return headers, {name: Entry(f"own/{each.header.name}", each.symbols) for name, each in own.items()}


def table(names: Iterable[str], own: Mapping[str, Entry] | None = None) -> bytes:
    """Return the C++ file that lists operations of the kernel library by name, and `own` ones."""
    includes, entries = listing(names, own)
    rows = [f"    {expression}," for expression in entries.values()]
    listed = ["static constexpr cdpr_entry entries[] = {", *rows, "};", ""] if rows else []
    lines = [
        "// Operations of the controller. Written by the exporter. SPDX-License-Identifier: Apache-2.0",
        "#include <cdpr/entry.hpp>",
        *includes,
        "",
        "namespace cdpr::CDPR_TARGET {",
        "",
        *listed,
        "extern const cdpr_group operations;",
        f"const cdpr_group operations = {{{'entries' if rows else 'nullptr'}, {len(rows)}}};",
        "",
        "}  // namespace cdpr::CDPR_TARGET",
        "",
    ]
    return "\n".join(lines).encode()


@cache
def entry_of(name: str) -> Entry:
    """Return the entry of an operation of the kernel library.

    Raises:
        CdprError: if no table of this installation contains it.
    """
    for path in sorted((NATIVE / "tables").glob("*.cpp")):
        text = path.read_text(encoding="utf-8")
        for arguments, found in ENTRY.findall(text):
            if found == name:
                return Entry(_header(INCLUDE.findall(text), arguments), " ".join(arguments.split()))
    raise CdprError(f"operation '{name}': expected an entry in {NATIVE / 'tables'}, found none; install cdpr again")


def _header(headers: Sequence[str], arguments: str) -> str:
    """Return the header that defines the function of an entry."""
    function = arguments.split(",", 1)[1].strip()
    found = re.match(r"static_cast<.*>\((\w+)", function) or re.match(r"(?:\w+::)*(\w+)", function)
    assert found
    defined = re.compile(rf"\bint\s+{found[1]}\s*\(")
    for header in (*headers, *headers_of(map(header_text, headers))):
        if defined.search(header_text(header)):
            return header
    raise CdprError(f"operation {found[1]}: found in no header of its table")


@cache
def header_text(name: str) -> str:
    """Return a header by its name in `#include <...>`; "" for one of the system."""
    path = Path(get_include()) / name
    return path.read_text(encoding="utf-8") if path.is_file() else ""


def headers_of(texts: Iterable[str]) -> dict[str, bytes]:
    """Return the headers of the kernel library that C++ files include, directly or not, by name."""
    found: dict[str, bytes] = {}
    todo = [name for text in texts for name in INCLUDE.findall(text)]
    while todo:
        name = todo.pop()
        if name in found or not (text := header_text(name)):
            continue
        found[name] = text.encode()
        todo += INCLUDE.findall(text)
    return dict(sorted(found.items()))
