"""A small controller FMU for tests, compiled from controller.c; see there for its variables."""

from __future__ import annotations

import os
import shlex
import subprocess
from pathlib import Path

from fmu_cases import description, make_fmu, variable

from cdpr.fmu.export.library import STANDARD

SOUND, ENDS, STANDS_STILL = 0.0, 1.0, 2.0
ROWS = (
    ("position", "input", 3, "m"),
    ("velocity", "input", 3, "m/s"),
    ("desired_position", "input", 3, "m"),
    ("desired_velocity", "input", 3, "m/s"),
    ("wrench", "output", 6, ("N",) * 3 + ("N.m",) * 3),
    ("mass", "parameter", 0, None),
    ("gravity", "parameter", 3, None),
    ("kp", "parameter", 0, None),
    ("kd", "parameter", 0, None),
    ("mode", "parameter", 0, None),
)


def c_compiler() -> list[str]:
    """Return the command of the C compiler."""
    return shlex.split(os.environ.get("CC", "").strip() or "cc")


def write_controller(path: Path, fmi: int, *flags: str, **capabilities: object) -> Path:
    """Compile and write the FMU; `flags` go to the compiler, `capabilities` into the description."""
    library = path.with_suffix(".so")
    source = Path(__file__).with_name("controller.c")
    subprocess.run(
        [*c_compiler(), f"-DFMI={fmi}", *flags, "-std=c99", "-shared", "-fPIC", f"-I{STANDARD}", "-o", library, source],
        check=True,
    )
    variables: list[str] = []
    for name, causality, size, unit in ROWS:
        for i, each in enumerate([f"{name}[{i + 1}]" for i in range(size)] or [name]):
            own = unit[i] if isinstance(unit, tuple) else unit
            variables.append(variable(fmi, each, len(variables), causality, unit=own))
    xml = description(fmi, variables, identifier="controller", **capabilities)
    return make_fmu(path, xml, fmi=fmi, library=library.read_bytes(), identifier="controller")
