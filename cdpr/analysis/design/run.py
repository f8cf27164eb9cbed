"""Execution of a design: replay of the recorded evaluations, then new ones."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version

from pydantic import TypeAdapter

from cdpr.analysis.design.evaluations import Evaluations
from cdpr.analysis.design.plan import Design
from cdpr.analysis.design.result import KIND, NAME, Designed
from cdpr.analysis.design.search import require, run_search, size
from cdpr.analysis.jobs.folder import JobFolder
from cdpr.base.checksums import opened
from cdpr.base.errors import CdprError, LogError, OutputError
from cdpr.base.problems import shown
from cdpr.base.version import VERSION
from cdpr.log.run_folder import folder_name
from cdpr.native.operations import kernels_version


@dataclass(frozen=True)
class Computed:
    """Parts of design.json that a resumed design needs."""

    versions: Mapping[str, str]


COMPUTED = TypeAdapter(Computed)


def run_design(
    design: Design,
    out: str | os.PathLike[str],
    *,
    jobs: int = 1,
    resume: bool = False,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Designed:
    """Evaluate all candidates of a design and write the result.

    Args:
        design: the design.
        out: folder; new, empty, or with a part of this design if `resume` is set.
        jobs: number of threads; the result does not depend on it.
        resume: replay the evaluations in `out` and continue; the result equals that of an uninterrupted design.
        progress: called with the number of evaluated candidates and their total.

    Returns:
        All candidates in their order, and the best of them; its files are in `out`.

    Raises:
        OutputError: if `out` has other content or cannot be written.
        PluginError: if a package is missing.
        CdprError: if the unchanged robot cannot be evaluated.

    Example:
        >>> import tempfile
        >>> from cdpr.analysis.design import load_design, run_design
        >>> design = load_design("design_box", evaluations=2)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     found = run_design(design, f"{folder}/out")
        ...     print(found)
        <Designed design_box: 2 candidates, 1 feasible>
    """
    if jobs < 1:
        raise CdprError(f"jobs: expected a whole number from 1 on, got {shown(jobs)}")
    versions = versions_of(design)
    given, n = design.section.optimizer, len(design.targets)
    path = folder_name(out)
    content = {"name": design.name, "cases": given.evaluations, "digest": design.digest, "versions": versions}
    folder = JobFolder(path, KIND, content)
    try:
        if folder.rows:
            if not resume:
                count = len(folder.rows)
                text = f"holds {count} evaluations of this design: --resume continues them (in Python resume=True)"
                raise OutputError(f"{path}: {text}")
            _expect(folder, versions)
        evaluate = Evaluations(design, folder, jobs, progress)
        try:
            low, high = design.bounds
            population = size(given.population, n, given.evaluations)
            run_search(design.search, evaluate, (design.start - low) / (high - low), given.seed, population)
        finally:
            evaluate.close()
        found = Designed(design, path, tuple(evaluate.rows), versions)
        found.write()
        return found
    finally:
        folder.close()


def versions_of(design: Design) -> dict[str, str]:
    """Return the versions of all software that computes the design.

    Raises:
        PluginError: if a package is missing.
    """
    names = ["numpy", *require(design.search)]
    known = {"cdpr": VERSION, "kernels": kernels_version(), "python": platform.python_version()}
    return known | {name: version(name) for name in names}


def _expect(folder: JobFolder, versions: Mapping[str, str]) -> None:
    """Raise OutputError if the folder was computed by other versions, whose candidates or figures may differ."""
    path = folder.path / NAME
    try:
        before = opened(path.read_bytes(), COMPUTED).versions
    except (OSError, ValueError) as error:
        raise LogError(f"{path}: cannot be read ({error}); choose another folder") from error
    differ = [
        f"{name} {before.get(name, 'none')}, here {here}" for name, here in versions.items() if before.get(name) != here
    ]
    if differ:
        raise OutputError(f"{folder.path}: was computed by other versions: {'; '.join(differ)}; choose another folder")
