"""Checksums and schemas of the files that cdpr writes and later reads back.

Every such file holds the SHA-256 of its content, so that damage, a manual edit or a mix-up of files is reported
instead of being used. It detects accidents; it is no protection against an attacker, who can compute a new checksum.

JSON files and lines of a ledger have it under the key "checksum". A line also covers the digest of the job that it
belongs to: lines of another job do not fit. Archives (NPZ) keep it as their comment, which other programs ignore.
"""

from __future__ import annotations

import hashlib
import json
import struct
import sys
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from types import UnionType
from typing import TYPE_CHECKING, Any, BinaryIO, TypeVar, get_args, get_origin, get_type_hints

if TYPE_CHECKING:
    from pydantic import TypeAdapter

T = TypeVar("T")

KEY = "checksum"
LENGTH = 2 * hashlib.sha256().digest_size  # characters of a checksum
BLOCK = 1 << 20  # bytes per read
COMMENT = struct.Struct("<H")  # length of the comment, the last field of that record
CHANGED = "it has changed since it was written: its checksum differs"


def checksum(content: bytes | memoryview) -> str:
    """Return the SHA-256 of bytes, in hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()


def sealed(content: Mapping[str, Any], job: str = "") -> dict[str, Any]:
    """Return plain JSON data with its checksum added, which also covers the digest of its `job`, if any."""
    plain: dict[str, Any] = json.loads(json.dumps(content))  # as read later: keys are texts
    plain.pop(KEY, None)
    return {**plain, KEY: _of(plain, job)}


def unsealed(text: str | bytes, job: str = "") -> dict[str, Any]:
    """Return the content of a JSON text after `sealed`.

    Raises:
        ValueError: if the text is damaged, was edited or belongs to another job; with the reason.
    """
    try:
        content = json.loads(text)
        if not isinstance(content, dict):
            raise ValueError(f"expected a JSON object, got {type(content).__name__}")
        found = content.pop(KEY, None)
        if found is None:
            raise ValueError("it has no checksum: an older version wrote it, or it was edited")
        if found != _of(content, job):
            raise ValueError(CHANGED)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    return content


def validated(content: object, schema: TypeAdapter[T]) -> T:
    """Return data validated by a schema.

    Raises:
        ValueError: if it does not match, with the first problem.
    """
    from pydantic import ValidationError  # takes long to import

    try:
        return schema.validate_python(content)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        where = ".".join(map(str, first["loc"]))
        raise ValueError(f"{where}: {first['msg']}" if where else first["msg"]) from None


def check_type(content: object, kind: Any) -> None:
    """Raise ValueError, with the first problem, if plain JSON data does not match a type.

    For files that are read often: pydantic is not used, because its import takes longer than the rest of
    `cdpr.load_run`.

    Args:
        content: result of `json.loads`.
        kind: a dataclass, `dict[str, T]`, `tuple[T, ...]`, a union or a type of JSON; other keys are ignored.
    """
    for problem in _problems(content, kind, ""):
        raise ValueError(problem)


def _problems(value: Any, kind: Any, where: str) -> Iterator[str]:
    plain, parts = get_origin(kind) or kind, get_args(kind)
    if is_dataclass(plain) and isinstance(value, dict):
        kinds = get_type_hints(plain)
        for field in fields(plain):
            if field.name in value:
                yield from _problems(value[field.name], kinds[field.name], f"{where}{field.name}.")
            elif field.default is field.default_factory is MISSING:
                yield f"{where}{field.name}: it is missing"
    elif plain is dict and isinstance(value, dict):
        for key, each in value.items():
            yield from _problems(each, parts[1], f"{where}{key}.")
    elif plain is tuple and isinstance(value, list):
        for i, each in enumerate(value):
            yield from _problems(each, parts[0], f"{where}{i}.")
    elif not _is_a(value, plain, parts):
        name = getattr(kind, "__name__", str(kind))
        yield f"{where.rstrip('.')}: expected {name}, got {type(value).__name__}"


def _is_a(value: Any, plain: Any, parts: tuple[Any, ...]) -> bool:
    if plain is UnionType:
        return any(not [*_problems(value, part, "")] for part in parts)
    if plain is float and isinstance(value, int):
        return abs(value) <= sys.float_info.max
    return plain is Any or (plain not in (dict, tuple) and isinstance(value, plain))


def opened(text: str | bytes, schema: TypeAdapter[T], job: str = "") -> T:
    """Return the content of a JSON text after `sealed`, validated by a schema.

    Raises:
        ValueError: as in `unsealed` and `validated`.
    """
    return validated(unsealed(text, job), schema)


def seal_archive(file: BinaryIO) -> None:
    """Add the checksum of a finished zip archive, open for reading and writing, as its comment."""
    file.seek(-COMMENT.size, 2)
    if file.read() != COMMENT.pack(0):
        raise ValueError("expected an archive without a comment")
    file.seek(-COMMENT.size, 2)
    file.write(COMMENT.pack(LENGTH))
    text = _of_bytes(file, file.seek(0, 2))
    file.seek(0, 2)
    file.write(text.encode())


def check_archive(file: BinaryIO) -> None:
    """Raise ValueError if an archive differs from the result of `seal_archive`; leave the file at its start."""
    size = file.seek(0, 2) - LENGTH
    file.seek(max(0, size))
    text = file.read()
    if size < 0 or text != _of_bytes(file, size).encode():
        raise ValueError("it has changed since it was written, or an older version wrote it: its checksum differs")
    file.seek(0)


def _of_bytes(file: BinaryIO, size: int) -> str:
    """Return the checksum of the first bytes of a file."""
    found = hashlib.sha256()
    file.seek(0)
    while size > 0 and (block := file.read(min(size, BLOCK))):
        found.update(block)
        size -= len(block)
    return found.hexdigest()


def _of(content: Mapping[str, Any], job: str) -> str:
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return checksum(f"{job}\n{text}".encode())
