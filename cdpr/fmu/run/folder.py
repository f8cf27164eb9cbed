"""Temporary folders for extracted FMUs."""

from __future__ import annotations

from cdpr.base import ownership
from cdpr.base.errors import OutputError
from cdpr.base.temporary import TemporaryFolder

PREFIX = "cdpr-fmu-"


class Folder(TemporaryFolder):
    """New folder of this process, whose content may be executed.

    Raises:
        OutputError: if it cannot be created, or others may write to it.
    """

    def __init__(self) -> None:
        try:
            super().__init__(PREFIX)
        except OSError as error:
            raise OutputError(
                f"no temporary folder for an FMU can be made: {error.strerror or error}; set TMPDIR to a folder that "
                "can be written"
            ) from None
        if found := ownership.fault(self.path):
            self.remove()
            raise OutputError(f"{self.path}: is not used for an FMU: {found}; or set TMPDIR to a folder of your own")
