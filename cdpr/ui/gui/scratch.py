"""Temporary folders for runs that exceed the memory and for files to import.

Each is removed with its window or, if that was killed, by the next window.
"""

from __future__ import annotations

import tempfile

from cdpr.base import temporary

PREFIX = "cdpr-gui-"


def scratch() -> temporary.TemporaryFolder:
    """Return a new folder."""
    return temporary.TemporaryFolder(PREFIX)


def sweep() -> None:
    """Remove the folders of killed windows; if locks are not supported, none."""
    temporary.sweep(tempfile.gettempdir(), PREFIX)
