"""The host in C, host.c, that runs exported FMUs without Python."""

from __future__ import annotations

import subprocess
import zipfile
from pathlib import Path

from fmu.controller import c_compiler

from cdpr.fmu.export.library import STANDARD
from cdpr.fmu.read.archive import open_archive

STEPS, STEP = 200, 0.001
STRICT = ("-Wall", "-Wextra", "-Wshadow", "-Wvla", "-Werror")


def compile_host(folder, *compiler, flags=(), ending=""):
    """Compile the host by a compiler, that of the system unless given, and return its path."""
    host = folder / f"host{ending}"
    source = Path(__file__).with_name("host.c")
    libraries = ["-lm"] if ending else ["-ldl", "-lm"]
    command = [*(compiler or c_compiler()), "-std=c99", *STRICT, *flags, f"-I{STANDARD}", "-o", host, source]
    subprocess.run([*command, *libraries], check=True)
    return host


def arguments(path, folder, shared=None):
    """Extract an FMU and return the arguments of the host that runs it, its library in place of `shared`."""
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    about = open_archive(path).description
    fmi = about.fmi[0]
    place = folder / "resources"
    resources = place.as_uri() if fmi == "2" else f"{place}/"
    names = [
        f"{name}[1]" if fmi == "2" else name for name in ("cable_tension", "command", "external_force", "position")
    ]
    inputs = {each.name for each in about.variables if each.causality == "input"}
    names.remove(names[0] if names[1] in inputs else names[1])
    pull, wrench, position = [about.find(name).value_reference for name in names]
    m = sum(each.size for each in about.variables if each.name.startswith("cable_length"))
    shared = shared or next(folder.rglob("cdpr_plant.*"))
    numbers = [fmi, STEPS, STEP, m, pull, wrench, position]
    return [shared, about.token, resources, *map(str, numbers)]
