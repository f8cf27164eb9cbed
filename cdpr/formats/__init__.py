"""Import and export of other programs' file formats; no other package depends on a format."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cdpr.formats.read.import_files import import_file as import_file
else:
    from cdpr.base.lazy import lazily

    __getattr__ = lazily(__name__, {"import_file": "cdpr.formats.read.import_files"})

__all__ = ["import_file"]
