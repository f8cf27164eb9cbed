"""FMUs for tests: archives with a description and, if need be, a library, made in a moment."""

from __future__ import annotations

import zipfile
from pathlib import Path
from xml.sax.saxutils import quoteattr

# Definitions of every FMU of these tests.
UNITS = {
    "N": {"kg": 1, "m": 1, "s": -2},
    "kN": {"kg": 1, "m": 1, "s": -2, "factor": 1000},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "m": {"m": 1},
    "mm": {"m": 1, "factor": 0.001},
    "m/s": {"m": 1, "s": -1},
    "rad": {"rad": 1},
    "deg": {"rad": 1, "factor": 0.017453292519943295},
    "rad/s": {"rad": 1, "s": -1},
    "1/s": {"s": -1},
}
# Enough of the head of a shared library to look like one: ELF, 64 bit, little endian, shared, x86_64.
ELF = b"\x7fELF\x02\x01\x01" + bytes(9) + b"\x03\x00\x3e\x00" + bytes(44)
PLANT = {
    "cable_tension": ("input", 8, "N"),
    "external_wrench": ("input", 6, None),
    "position": ("output", 3, "m"),
    "quaternion": ("output", 4, None),
    "velocity": ("output", 3, "m/s"),
    "angular_velocity": ("output", 3, "rad/s"),
    "cable_length": ("output", 8, "m"),
}


def attributes(**given: object) -> str:
    """Attributes of an XML element, those that are None left out."""
    return "".join(f" {key}={quoteattr(str(value))}" for key, value in given.items() if value is not None)


def variable(
    fmi: int,
    name: str,
    reference: int,
    causality: str,
    *,
    shape: tuple[int, ...] = (),
    unit: str | None = None,
    kind: str | None = None,
    alias: str | None = None,
    start: str | None = None,
) -> str:
    """One variable."""
    size = 1
    for each in shape:
        size *= each
    if start is None and causality in ("input", "parameter"):
        start = " ".join(["0"] * size)
    common = attributes(name=name, valueReference=reference, causality=causality)
    if fmi == 2:
        assert not shape
        return f"<ScalarVariable{common}><{kind or 'Real'}{attributes(unit=unit, start=start)}/></ScalarVariable>"
    inner = "".join(f'<Dimension start="{each}"/>' for each in shape)
    inner += f"<Alias{attributes(name=alias)}/>" if alias else ""
    kind = kind or "Float64"
    return f"<{kind}{common}{attributes(unit=unit, start=start)}>{inner}</{kind}>"


def signals(fmi: int, table: dict[str, tuple[str, int, str | None]]) -> list[str]:
    """Variables of whole signals by name: causality, number, unit; arrays in FMI 3, families from 1 in FMI 2."""
    result: list[str] = []
    for name, (causality, size, unit) in table.items():
        if fmi == 3:
            result.append(variable(3, name, len(result) + 1, causality, shape=(size,), unit=unit))
        else:
            for i in range(size):
                result.append(variable(2, f"{name}[{i + 1}]", len(result) + 1, causality, unit=unit))
    return result


def description(
    fmi: int = 3,
    variables: list[str] | None = None,
    *,
    identifier: str = "plant",
    version: str | None = None,
    interface: str = "CoSimulation",
    head: str = "",
    more: str = "",
    units: dict[str, dict[str, float]] | None = None,
    **capabilities: object,
) -> str:
    """A modelDescription.xml; by default a plant with the signals of cdpr."""
    rows = signals(fmi, PLANT) if variables is None else variables
    token = attributes(**{"guid" if fmi == 2 else "instantiationToken": "{1}"})
    defined = "".join(
        f"<Unit{attributes(name=name)}><BaseUnit{attributes(**base)}/></Unit>"
        for name, base in (UNITS if units is None else units).items()
    )
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n{head}'
        f"<fmiModelDescription{attributes(fmiVersion=version or f'{fmi}.0', modelName='plant')}{token}>"
        f"<{interface}{attributes(modelIdentifier=identifier, **capabilities)}/>"
        f"<UnitDefinitions>{defined}</UnitDefinitions>{more}"
        f'<DefaultExperiment stepSize="0.001"/>'
        f"<ModelVariables>{''.join(rows)}</ModelVariables><ModelStructure/></fmiModelDescription>"
    )


def make_fmu(
    path: Path,
    xml: str | bytes | None = None,
    *,
    fmi: int = 3,
    library: bytes | None = ELF,
    platform: str | None = None,
    identifier: str = "plant",
    files: dict[str, bytes] | None = None,
    entries: list[tuple[zipfile.ZipInfo, bytes]] | None = None,
) -> Path:
    """Write an FMU; `xml` is its description, by default that of a plant."""
    folder = platform or ("linux64" if fmi == 2 else "x86_64-linux")
    ending = "dll" if "win" in folder else "so"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", description(fmi) if xml is None else xml)
        if library is not None:
            archive.writestr(f"binaries/{folder}/{identifier}.{ending}", library)
        for name, content in (files or {}).items():
            archive.writestr(name, content)
        for info, content in entries or []:
            archive.writestr(info, content)
    return path
