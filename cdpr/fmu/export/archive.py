"""Archive of an exported FMU: the same bytes for the same model, source and compiler."""

from __future__ import annotations

import contextlib
import hashlib
import io
import uuid
import warnings
import zipfile
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path

from cdpr.base import ownership
from cdpr.base.errors import PluginError
from cdpr.fmu.export.cache import fmu_cache, keep_newest
from cdpr.fmu.export.description import IDENTIFIER, build_description, configuration, model_description, terminals
from cdpr.fmu.export.library import FLAGS, NATIVE, SOURCE, library, sources, target
from cdpr.fmu.export.variables import Model
from cdpr.fmu.read import trust
from cdpr.log.files import NAME_OR_FORCE_IN_PYTHON, ExistingFileError, make_folder, replacing, require_new

# earliest time that a zip archive supports
EPOCH = (1980, 1, 1, 0, 0, 0)

# FMUs in the user's cache, some 80 kB each: enough for a study, which makes one for each variant of its robot
KEPT = 1000


def fmu_bytes(model: Model, fmi: int, source_only: bool = False, platforms: Sequence[str] = (NATIVE,)) -> bytes:
    """Return the model as an FMU for co-simulation, FMI 2 or 3, with a binary for each platform (`library.target`).

    Raises:
        PluginError: if sources alone are requested for FMI 2, there is no C++ compiler, compilation fails, or binaries
            for this platform are not supported.
        OutputError: if the user's cache cannot be written.
    """
    if source_only and fmi == 2:
        raise PluginError(
            "FMI 2 allows only C as source, and that of cdpr is C++: leave --source-only out, or choose --fmi 3"
        )
    return assemble(model, fmi, {**sources(), **model.sources()}, () if source_only else FLAGS, platforms)


def write_fmu(
    model: Model,
    fmi: int,
    out: Path,
    source_only: bool = False,
    force: bool = False,
    platforms: Sequence[str] = (NATIVE,),
    remedy: str = NAME_OR_FORCE_IN_PYTHON,
) -> str:
    """Write the FMU into the file `out`, add it to the user's list of trusted FMUs and return its sha256.

    `remedy` is that of the error if the file exists without `force`.

    Raises:
        PluginError: as for `fmu_bytes`.
        OutputError: if a file cannot be written.
    """
    require_new(out, force, remedy)
    content = fmu_bytes(model, fmi, source_only, platforms)
    sha256 = hashlib.sha256(content).hexdigest()
    try:
        _write(out, content, force=force)
    except ExistingFileError:  # it was written beside it
        if not source_only:
            trust.add(sha256, out.name)
        raise
    if not source_only:
        trust.add(sha256, out.name)
    return sha256


def cached_fmu(model: Model, fmi: int = 3) -> Path:
    """Return the FMU of a model in the user's cache, created if necessary; errors as for `fmu_bytes`.

    Its name is its sha256, by which a caller may trust it.
    """
    content = fmu_bytes(model, fmi)
    path = fmu_cache() / f"{hashlib.sha256(content).hexdigest()}.fmu"
    try:
        whole = ownership.read_private(path) == content
        reason = f"{path} is damaged"
    except FileNotFoundError:
        whole, reason = False, ""
    except OSError as error:
        whole, reason = False, str(error)
    if not whole:
        if reason:
            warnings.warn(f"{reason}: it is replaced by a new one", stacklevel=2)
            with contextlib.suppress(OSError):  # `_write` reports what cannot be replaced
                path.unlink()
        _write(path, content, 0o600)
        keep_newest(path.parent, ".fmu", KEPT)
    return path


def _write(out: Path, content: bytes, mode: int | None = None, force: bool = True) -> None:
    make_folder(out.parent)
    with replacing(out, force) as file:
        file.write(content)
        if mode is not None:
            Path(file.name).chmod(mode)


def assemble(
    model: Model, fmi: int, files: Mapping[str, bytes], flags: Sequence[str], platforms: Sequence[str] = (NATIVE,)
) -> bytes:
    """Pack all files; binaries were compiled with these `flags`; none if there are no binaries."""
    variables = model.variables()
    digest = hashlib.sha256(configuration(model, "").encode())
    for content in files.values():
        digest.update(content)
    token = f"{{{uuid.UUID(digest.hexdigest()[:32])}}}"
    compiled = [name for name in files if name.endswith(".cpp")]
    entries = {
        "modelDescription.xml": model_description(model, variables, token, fmi),
        "resources/plant.cfg": configuration(model, token).encode(),
        **({"sources/buildDescription.xml": build_description(compiled)} if fmi == 3 else {}),
        **({"terminalsAndIcons/terminalsAndIcons.xml": terminals(variables)} if fmi == 3 else {}),
        "documentation/licenses/license.txt": (SOURCE / "LICENSE.txt").read_bytes(),
        **({f"sources/{name}": content for name, content in files.items()} if fmi == 3 else {}),
    }
    for name in dict.fromkeys(platforms) if flags else ():
        goal = target(name, fmi)
        entries[f"binaries/{goal.folder}/{IDENTIFIER}{goal.ending}"] = library(files, flags, goal)
    return zipped(tuple(entries.items()))


@lru_cache(maxsize=16)
def zipped(entries: tuple[tuple[str, bytes], ...]) -> bytes:
    """Return names and contents as an archive; cached: packing dominates an export, and a study repeats its robots."""
    result = io.BytesIO()
    with zipfile.ZipFile(result, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries:
            info = zipfile.ZipInfo(name, EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.create_system = 3  # Unix, on every platform
            info.external_attr = 0o644 << 16
            archive.writestr(info, content)
    return result.getvalue()
