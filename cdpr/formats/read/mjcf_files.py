"""Includes of an MJCF model: as in MuJoCo, each `<include>` is replaced by the content of its file.

Only regular files in the model's folder and its subfolders are read, each once, up to a maximum depth and size.
"""

from __future__ import annotations

import os
from pathlib import Path

from cdpr.base.files import UnreadableError, read
from cdpr.base.problems import shown
from cdpr.formats.read.xml import MAX_ELEMENTS, Element, parse

MAX_INCLUDED = 8  # nesting depth
MAX_BYTES = 16 * 2**20  # of all included files together
ENDINGS = (".xml", ".mjcf")


def include(root: Element, path: Path) -> list[Element]:
    """Insert included files into a model; return the root of each, without its children.

    Elements keep their file and line.

    Raises:
        FormatError: if a file cannot be included.
    """
    included = _Included(path.parent.resolve(), path.parent)
    included.splice(root, 0)
    return included.roots


class _Included:
    def __init__(self, folder: Path, shown_folder: Path) -> None:
        self.folder, self.shown_folder = folder, shown_folder
        self.seen: set[Path] = set()
        self.roots: list[Element] = []
        self.bytes = self.elements = 0

    def splice(self, element: Element, depth: int) -> None:
        children = list[Element]()
        for child in element.children:
            self.elements += 1
            if child.name == "include":
                children += self._load(child, depth + 1).children
            else:
                self.splice(child, depth)
                children.append(child)
        if self.elements > MAX_ELEMENTS:
            raise element.wrong(f"with its included files it has more than {MAX_ELEMENTS} elements")
        element.children = children

    def _load(self, include: Element, depth: int) -> Element:
        name = include.attribute("file")
        if depth > MAX_INCLUDED:
            raise include.wrong(f"<include>: files include each other more than {MAX_INCLUDED} deep")
        file = Path(os.path.realpath(self.folder / name))  # unlike `resolve`, does not raise for cyclic links
        if Path(name).is_absolute() or not file.is_relative_to(self.folder):
            raise include.wrong(
                f"<include>: {shown(name)} is outside the folder of the model, and only files inside are read: copy it "
                "there"
            )
        if file in self.seen:
            raise include.wrong(f"<include>: {shown(name)} is included twice, which MuJoCo rejects: remove one")
        self.seen.add(file)
        try:
            content = read(str(file), MAX_BYTES - self.bytes, ENDINGS)
        except UnreadableError as error:
            raise include.wrong(f"<include>: {str(error).replace(str(self.folder), str(self.shown_folder))}") from None
        self.bytes += len(content)
        if self.bytes > MAX_BYTES:
            raise include.wrong(f"<include>: the included files are larger than {MAX_BYTES // 2**20} MiB together")
        root = parse(content, str(self.shown_folder / name))
        self.splice(root, depth)
        self.roots.append(root.without_children())
        return root
