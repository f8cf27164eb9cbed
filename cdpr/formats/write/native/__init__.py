"""Motion, controller and tension distribution of a scenario for real-time programs: a header and a file of numbers."""

from __future__ import annotations

from pathlib import Path

from cdpr.formats.write.native.header import header_text
from cdpr.formats.write.native.layout import Layout
from cdpr.log.files import NAME_OR_FORCE_IN_PYTHON, replace_all, require_new
from cdpr.scenario import Scenario
from cdpr.simulation.exported import control_of

HEADER, NUMBERS = "robot.h", "robot.bin"


def native_files(scenario: Scenario) -> dict[str, bytes]:
    """Return the contents of the files by name; equal scenarios give equal bytes.

    Raises:
        CdprError: if the scenario has parts that cannot be exported, such as a solver without a compiled operation.
    """
    control = control_of(scenario, "native")
    layout = Layout.of(control.pipeline)
    header, signature = header_text(control, layout)
    return {HEADER: header.encode(), NUMBERS: layout.file(signature)}


def write_native(
    scenario: Scenario, folder: Path, force: bool = False, remedy: str = NAME_OR_FORCE_IN_PYTHON
) -> list[Path]:
    """Write the files into `folder`, which is created if necessary; return their paths.

    `remedy` is that of the error if a file exists without `force`.

    Raises:
        CdprError: as `native_files`.
        OutputError: if a file exists (without `force`) or cannot be written.
    """
    content = native_files(scenario)
    for name in content:
        require_new(folder / name, force, remedy)
    replace_all(folder, content, force)
    return [folder / name for name in content]
