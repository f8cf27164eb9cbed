"""An FMU that misbehaves on demand: parameter `fault`, one of FAULTS, from the step that begins at `fault_time` on."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cdpr.fmu.export.archive import assemble
from cdpr.fmu.export.library import FLAGS, sources
from cdpr.fmu.export.models import Plant
from cdpr.fmu.export.variables import Variable

FAULTS = ("none", "discard", "error", "fatal", "nan", "segfault", "abort", "exit", "hang", "log", "print")


@dataclass(frozen=True, eq=False)
class FaultyPlant(Plant):
    def variables(self) -> list[Variable]:
        choice = Variable("fault", "parameter", (), "", (0.0,), f"number of one of {', '.join(FAULTS)}")
        when = Variable("fault_time", "parameter", (), "s", (0.0,), "when it begins")
        return [*super().variables(), choice, when]


def write_faulty_fmu(plant: FaultyPlant, fmi: int, path: Path) -> Path:
    """Write the FMU; the library is compiled once, then comes from the cache. At `fault` 0 it is a sound plant."""
    files = {**sources(), "fault.cpp": Path(__file__).with_name("fault.cpp").read_bytes()}
    for name in ("fault.cpp", "instance.cpp"):  # not by a flag: objects of the other files come from the cache
        files[name] = b"#define CDPR_FAULTS\n" + files[name]
    path.write_bytes(assemble(plant, fmi, dict(sorted(files.items())), FLAGS))
    return path
