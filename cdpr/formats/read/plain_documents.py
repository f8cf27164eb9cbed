"""Plain data of other programs, in JSON, YAML or XML, with the line of each value."""

from __future__ import annotations

from typing import Any

from cdpr.base.problems import Mark, Path
from cdpr.config.document import Document
from cdpr.formats.read.xml import Element, parse
from cdpr.formats.read.yaml_reader import Node, document_of

MISSING = ("", "none", "null", "nan", "inf", "-inf", "+inf", "infinity", "-infinity", ".inf", ".nan")


def plain_document(content: bytes, file: str) -> Node:
    """Return the root of a document, whose format the first character shows.

    In XML as of xmltodict, elements of one name are a list, and a tuple is written as text.

    Raises:
        CdprError: if it cannot be parsed.
    """
    begin = content.lstrip()[:1]
    if begin == b"<":
        root = parse(content, file)
        document = Document({}, file, values={(): Mark(file, root.line, 1)})
        document.data.update(_children(root, (), document))
        return Node(document)
    if begin in (b"{", b"["):  # JSON: between its values tabs are allowed, inside of them they are not
        content = content.replace(b"\t", b" ")
    return document_of(content, file)


def is_missing(value: Any) -> bool:
    """Return True for null and for infinite numbers, which some programs write instead."""
    if isinstance(value, float):
        return not abs(value) < float("inf")
    return value is None or (isinstance(value, str) and value.strip().lower() in MISSING)


def items_of(node: Node) -> list[Node]:
    """Return the items of a list, or a single value as a list: XML does not distinguish them.

    Raises:
        FormatError: if there are none.
    """
    return [node] if node.value is not None and not isinstance(node.value, list) else node.items()


def _children(element: Element, path: Path, document: Document) -> dict[str, Any]:
    """Return the children and attributes of an element as a dictionary; their lines are added to the document."""
    names: dict[str, list[Element]] = {}
    for child in element.children:
        names.setdefault(child.name, []).append(child)
    found: dict[str, Any] = {}
    for name, children in names.items():
        several = len(children) > 1
        values = [
            _value(child, (*path, name, k) if several else (*path, name), document) for k, child in enumerate(children)
        ]
        document.keys[*path, name] = Mark(element.file, children[0].line, 1)
        found[name] = values if several else values[0]
    return found


def _value(element: Element, path: Path, document: Document) -> Any:
    document.values[path] = Mark(element.file, element.line, 1)
    if element.children:
        return _children(element, path, document)
    text = element.text.strip()
    if "," in text:
        return [_scalar(part.strip(" ()[]")) for part in text.strip(" ()[]").split(",")]
    return _scalar(text)


def _scalar(text: str) -> Any:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text or None
