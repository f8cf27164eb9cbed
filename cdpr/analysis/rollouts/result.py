"""Result of a rollout: arrays over cases and samples, the end of each case, and figures of all its samples."""

from __future__ import annotations

import importlib
import json
import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from cdpr.analysis.jobs.cases import Outcome
from cdpr.analysis.rollouts.figures import FIGURES
from cdpr.base.column import Column
from cdpr.base.errors import OutputError, PluginError
from cdpr.log.files import NAME_OR_FORCE_IN_PYTHON, make_folder, replacing, require_new
from cdpr.model.robot import Array

if TYPE_CHECKING:
    from pandas import DataFrame

QUANTILES = {"q05": 0.05, "median": 0.5, "q95": 0.95}
PIECE = 1 << 20  # numbers of a table in memory at a time


@dataclass(frozen=True, eq=False)
class Rollouts:
    """N cases of one scenario, with K samples of each.

    Kept columns are attributes with their names in a run: `position` is (N, K, 3) m, `tension` (N, K, m) N; the
    solver's status is `solver_status`. After the end of a case its rows are NaN. Arrays are read-only.

    Attributes:
        name: name of the scenario.
        time: (K,) s, of the kept samples.
        values: values of each varied key, by key, (N, ...) for numbers.
        rows: (N, K, W) all columns side by side; those of a rollout with a folder stay on disk.
        columns: names of the columns.
        cables: names of the cables.
        outcomes: end of each case, with its message.
    """

    name: str
    time: Array
    values: Mapping[str, Sequence[Any]]
    rows: Array
    columns: tuple[Column, ...]
    cables: tuple[str, ...]
    outcomes: tuple[Outcome, ...]

    def __len__(self) -> int:
        return len(self.outcomes)

    def __repr__(self) -> str:
        ended = ", ".join(f"{count} {status}" for status, count in self.counts.items())
        kept = ", ".join(column.name for column in self.columns)
        return f"<Rollouts of {self.name}: {len(self)} cases ({ended}), {len(self.time)} samples each of {kept}>"

    def __getitem__(self, name: str) -> Array:
        """Return a column by name: (N, K) for one number, else (N, K, width); columns of cables are (N, K, m)."""
        if name not in self._places:
            raise KeyError(
                f"{name}: not recorded; recorded columns: {', '.join(self._places)}; choose columns by columns="
            )
        block, column = self.rows[:, :, self._places[name]], next(each for each in self.columns if each.name == name)
        return block[:, :, 0] if column.width == 1 else block

    def __getattr__(self, name: str) -> Array:
        if name.startswith("_") or "columns" not in self.__dict__:  # during a copy
            raise AttributeError(name)
        try:
            return self["status" if name == "solver_status" else name]
        except KeyError as error:
            raise AttributeError(error.args[0]) from None

    @cached_property
    def status(self) -> NDArray[np.str_]:
        """Return the status of each case, (N,): that of a run, or "failed", also if the scenario rejects its values."""
        return np.array([outcome.status for outcome in self.outcomes])

    @property
    def messages(self) -> list[str]:
        """Return the reason of each early end; "" for the other cases."""
        return [outcome.message for outcome in self.outcomes]

    @property
    def counts(self) -> dict[str, int]:
        """Number of cases by status."""
        return dict(Counter(self.status.tolist()))

    @cached_property
    def figures(self) -> dict[str, Array]:
        """Return figures of all samples of each case, (N,), named with units as in a study; NaN for missing ones."""
        rows = [outcome.summary for outcome in self.outcomes]
        numbers = {name: [row.get(name) for row in rows] for name in ("samples", *FIGURES)}
        return {name: np.array([np.nan if x is None else x for x in found]) for name, found in numbers.items()}

    def summary(self) -> dict[str, Any]:
        """Return the share of finished cases, the cases with samples without valid tensions, and quantiles of figures.

        The quantiles are those of the finished cases.
        """
        done = self.status == "finished"
        figures = {name: found[done] for name, found in self.figures.items()}
        strained = (figures["infeasible_steps"] > 0) | (figures["unanswered_steps"] > 0)
        result: dict[str, Any] = {
            "cases": len(self),
            "status": self.counts,
            "finished_share": float(done.mean()),
            "strained_share": float(strained.sum() / len(self)),
        }
        for name in FIGURES if done.any() else ():
            found = {key: float(np.quantile(figures[name], share)) for key, share in QUANTILES.items()}
            result[name] = {"min": float(figures[name].min()), **found, "max": float(figures[name].max())}
        return result

    def to_pandas(self) -> DataFrame:
        """Return a row for each case: its values, status, message and figures.

        Raises:
            PluginError: if pandas is missing.
        """
        keys = {key: list(values) for key, values in self.values.items()}
        ended = {"status": self.status, "message": self.messages}
        frame: DataFrame = _module("pandas").DataFrame({**keys, **ended, **self.figures})
        return frame.rename_axis("case")

    def save(self, path: str | os.PathLike[str], force: bool = False) -> None:
        """Write all results as .npz, or the rows as a .parquet table with a row for each case and sample.

        The .npz has an array for each column, with the names of this class, `time`, the values as `vary:KEY`, `status`,
        `messages` and the figures.

        Raises:
            OutputError: if the file cannot be written.
            PluginError: if pyarrow is missing.
        """
        out = Path(path)
        if out.suffix not in WRITERS:
            raise OutputError(f"{out}: expected a name that ends in {' or '.join(WRITERS)}")
        require_new(out, force, NAME_OR_FORCE_IN_PYTHON)
        make_folder(out.parent)
        with replacing(out, force) as file:
            WRITERS[out.suffix](self, file)

    @cached_property
    def _places(self) -> dict[str, slice]:
        """Return the position of each column in the rows."""
        places, start = {}, 0
        for column in self.columns:
            places[column.name] = slice(start, start := start + (column.width or len(self.cables)))
        return places


def _npz(found: Rollouts, file: BinaryIO) -> None:
    arrays: dict[str, Any] = {"time": found.time, "status": found.status, "messages": np.array(found.messages)}
    for column in found.columns:
        arrays["solver_status" if column.name == "status" else column.name] = found[column.name]
    for key, values in found.values.items():
        numbers = isinstance(values, np.ndarray)
        arrays[f"vary:{key}"] = values if numbers else np.array([json.dumps(value) for value in values])
    arrays |= {**found.figures, "cables": np.array(found.cables)}
    np.savez(file, **arrays)


def _parquet(found: Rollouts, file: BinaryIO) -> None:
    arrow, parquet = _module("pyarrow"), _module("pyarrow.parquet")
    names = ["case", "t", *(name for column in found.columns for name in column.headings(found.cables))]
    kinds = [arrow.int64(), *[arrow.float64()] * (len(names) - 1)]
    schema = arrow.schema(list(zip(names, kinds, strict=True)))
    with parquet.ParquetWriter(file, schema) as writer:
        for cases in _pieces(found):
            rows = found.rows[cases].reshape(-1, found.rows.shape[2])
            numbers = np.repeat(np.arange(cases.start, cases.stop), len(found.time))
            times = np.tile(found.time, cases.stop - cases.start)
            columns = [arrow.array(column) for column in (numbers, times, *np.ascontiguousarray(rows.T))]
            writer.write_table(arrow.Table.from_arrays(columns, schema=schema))


def _pieces(found: Rollouts) -> Iterator[slice]:
    size = max(1, PIECE // max(1, found.rows[0].size))
    for first in range(0, len(found), size):
        yield slice(first, min(first + size, len(found)))


WRITERS = {".npz": _npz, ".parquet": _parquet}


def _module(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.partition(".")[0]
        raise PluginError(f"this needs {package}, which is not installed: pip install 'cdpr[data]'") from error
