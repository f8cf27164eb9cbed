"""XML trees whose elements have line numbers. Entities and external resources are never resolved."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import lru_cache
from typing import Any
from xml.parsers import expat

from cdpr.base.errors import FormatError
from cdpr.base.fields import MAX_MAGNITUDE
from cdpr.base.problems import shown
from cdpr.formats.read.imported import refuse
from cdpr.formats.read.unread import Unread

MAX_DEPTH = 64
MAX_ELEMENTS = 200_000


class Attributes(dict[str, str]):
    """Attributes of an element; a lookup records the name in `read`, iteration does not."""

    def __init__(self, given: Mapping[str, str], read: set[str] | None = None) -> None:
        super().__init__(given)
        self.read = set[str]() if read is None else read

    def __getitem__(self, name: str) -> str:
        value = super().__getitem__(name)
        self.read.add(name)
        return value

    def __contains__(self, name: object) -> bool:
        found = super().__contains__(name)
        if found:
            self.read.add(str(name))
        return found

    def get(self, name: str, otherwise: Any = None) -> Any:
        """Return an attribute, or a default if it is missing."""
        if super().__contains__(name):
            self.read.add(name)
        return super().get(name, otherwise)


class Element:
    """Element that records which of its parts are read.

    Attributes:
        name: name without namespace prefix.
        file: its file.
        line: its first line.
        attributes: its attributes.
        children: child elements; `all`, `find` and `child` record the returned ones as read.
    """

    def __init__(
        self,
        name: str,
        file: str,
        line: int,
        attributes: Mapping[str, str],
        children: list[Element] | None = None,
        text: str = "",
    ) -> None:
        self.name, self.file, self.line = name, file, line
        self.attributes = attributes if isinstance(attributes, Attributes) else Attributes(attributes)
        self.children = [] if children is None else children
        self._text = [text] if text else []
        self._read = self._text_read = self._done = False

    @property
    def text(self) -> str:
        """Text of the element itself, without that of its children."""
        self._text_read = True
        return "".join(self._text)

    @property
    def at(self) -> str:
        """Its position, for messages."""
        return f"{self.file}:{self.line}"

    def append(self, text: str) -> None:
        """Append text to the element."""
        self._text.append(text)

    def all(self, name: str) -> list[Element]:
        """Return the children of this name."""
        found = [child for child in self.children if child.name == name]
        for child in found:
            child.touch()
        return found

    def find(self, name: str) -> Element | None:
        """Return the first child of this name, or None."""
        found = next((child for child in self.children if child.name == name), None)
        if found is not None:
            found.touch()
        return found

    def child(self, name: str) -> Element:
        """Return the only child of this name.

        Raises:
            FormatError: if there is none, or several.
        """
        found = self.all(name)
        if len(found) != 1:
            raise self.wrong(f"expected one <{name}> within <{self.name}>, got {len(found)}")
        return found[0]

    def touch(self, *names: str) -> None:
        """Record the element and these attributes as read."""
        self._read = True
        self.attributes.read.update(names)

    def done(self) -> None:
        """Mark the element and its content as reported, for example by a separate message."""
        self._done = True

    def without_children(self) -> Element:
        """Return the element without its children; both share the record of read attributes."""
        other = Element(self.name, self.file, self.line, Attributes(self.attributes, self.attributes.read))
        other._text = self._text
        return other

    def known_as(self, name: str, **attributes: str) -> Element:
        """Return the element under another name, with default attributes; both share the record of read attributes."""
        other = Element(name, self.file, self.line, Attributes({**attributes, **self.attributes}, self.attributes.read))
        other.children = self.children
        return other

    def unread(self) -> Iterator[Unread]:
        """Yield the elements, attributes and texts that were not read."""
        yield from self._parts("")[1]

    def _parts(self, above: str) -> tuple[bool, list[Unread]]:
        """Return whether anything here was read, and the unread parts."""
        if self._done:
            return True, []
        name = f"<{self.name}>{above}"
        read, found = self._read or self._text_read or bool(self.attributes.read), list[Unread]()
        for key in self.attributes:
            if key not in self.attributes.read and key.partition(":")[0] != "xmlns":
                found.append(Unread(self.file, self.line, f"attribute '{key}' of {name}"))
        if not self._text_read and (text := "".join(self._text).strip()):
            found.append(Unread(self.file, self.line, f"text {shown(text)} of {name}"))
        for child in self.children:
            child_read, parts = child._parts(f" in <{self.name}>")
            read = read or child_read
            found += parts
        return read, found if read else [Unread(self.file, self.line, name)]

    def everywhere(self) -> Iterator[Element]:
        """Yield the element and all descendants, in document order."""
        yield self
        for child in self.children:
            yield from child.everywhere()

    def attribute(self, name: str) -> str:
        """Return an attribute.

        Raises:
            FormatError: if it is missing or empty.
        """
        value = str(self.attributes.get(name, "")).strip()
        if not value:
            raise self.wrong(f"<{self.name}> has no attribute '{name}'")
        return value

    def number(self) -> float:
        """Return the text as a finite number.

        Raises:
            FormatError: if it is not one.
        """
        return self.vector(1)[0]

    def vector(self, count: int | None = None) -> list[float]:
        """Return the text as finite numbers, separated by blanks or commas.

        Raises:
            FormatError: if it does not contain `count` numbers.
        """
        return self._numbers(self.text, f"<{self.name}>", count)

    def attribute_number(self, name: str, otherwise: float | None = None) -> float:
        """Return an attribute as a finite number, or a default if it is missing.

        Raises:
            FormatError: if it is not one.
        """
        if otherwise is not None and not self.attributes.get(name, "").strip():
            return otherwise
        return self._numbers(self.attribute(name), f"{name} of <{self.name}>", 1)[0]

    def attribute_vector(self, name: str, count: int | None = None) -> list[float]:
        """Return an attribute as finite numbers.

        Raises:
            FormatError: if it does not contain `count` numbers.
        """
        return self._numbers(self.attribute(name), f"{name} of <{self.name}>", count)

    def wrong(self, text: str) -> FormatError:
        """Return an error for this position."""
        return refuse(self.file, self.line, text)

    def _numbers(self, text: str, what: str, count: int | None) -> list[float]:
        words = text.replace(",", " ").split()
        try:
            found = [float(word) for word in words if "_" not in word]
        except ValueError:
            found = []
        sound = len(found) == len(words) and all(math.isfinite(x) and abs(x) <= MAX_MAGNITUDE for x in found)
        if not sound or not found or count not in (None, len(found)):
            many = "numbers" if count is None else "a number" if count == 1 else f"{count} numbers"
            raise self.wrong(f"{what}: expected {many}, of at most {MAX_MAGNITUDE:g}, got {shown(text.strip())}")
        return found


def parse(content: bytes, file: str) -> Element:
    """Return the root of a document.

    Raises:
        FormatError: if it is not well-formed, too large, or declares entities or default attributes.
    """
    tree = _Tree(file)
    tree.feed(content)
    return tree.root


@lru_cache(maxsize=1)  # each format calls it
def root_of(content: bytes) -> tuple[str, dict[str, str]]:
    """Return name and attributes of the root element without reading further; "" if there is none."""
    parser = expat.ParserCreate()
    found: list[tuple[str, dict[str, str]]] = []

    def start(name: str, attributes: dict[str, str]) -> None:
        found.append((name, attributes))
        raise StopIteration

    parser.StartElementHandler = start
    with suppress(StopIteration, expat.ExpatError, ValueError, LookupError):
        parser.Parse(content, True)
    return found[0] if found else ("", {})


class _Tree:
    def __init__(self, file: str) -> None:
        self.file, self.open, self.count = file, list[Element](), 0
        self.root = Element("", file, 1, {})
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._text
        self.parser.EntityDeclHandler = self._entity
        self.parser.AttlistDeclHandler = self._attribute
        skipped: Callable[[str, bool], None] = self._skipped
        self.parser.SkippedEntityHandler = skipped

    def feed(self, content: bytes) -> None:
        try:
            self.parser.Parse(content, True)
        except expat.ExpatError as error:
            raise self._wrong(f"invalid XML: {expat.ErrorString(error.code)}") from None
        except (ValueError, LookupError) as error:  # unknown encoding
            raise self._wrong(f"invalid XML: {error}") from None

    def _wrong(self, text: str) -> FormatError:
        return refuse(self.file, self.parser.CurrentLineNumber, text)

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self.count += 1
        if self.count > MAX_ELEMENTS or len(self.open) >= MAX_DEPTH:
            raise self._wrong(f"more than {MAX_ELEMENTS} elements, or nested more than {MAX_DEPTH} deep")
        element = Element(name.rpartition(":")[2], self.file, self.parser.CurrentLineNumber, attributes)
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def _end(self, _: str) -> None:
        self.open.pop()

    def _text(self, text: str) -> None:
        self.open[-1].append(text)

    def _entity(self, name: str, *_: object) -> None:
        raise self._wrong(f"it declares the entity '{name}': entities are not resolved; write the text itself")

    def _attribute(self, element: str, name: str, _: str, default: str | None, __: bool) -> None:
        """Reject default attributes: with them a small file could fill the memory."""
        if default is not None:
            raise self._wrong(
                f"it declares a default for the attribute '{name}' of <{element}>: write it in the element"
            )

    def _skipped(self, name: str, _: bool) -> None:
        raise self._wrong(f"it uses the entity '{name}', which is unknown: write the text itself")
