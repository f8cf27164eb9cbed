"""The figures by which a run is judged at a glance, counted while it goes on: rows are seen once and forgotten."""

from __future__ import annotations

from copy import copy, deepcopy
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from cdpr.log.beyond import beyond, tables
from cdpr.log.run import Header, Run
from cdpr.log.singular import Singular
from cdpr.log.slack import Slack, slack
from cdpr.mechanics.reach import Reach
from cdpr.model.robot import Array
from cdpr.tension.status import Status

if TYPE_CHECKING:
    from cdpr.mechanics.closest import Closest

# Energy counts as balanced where what no work explains is below this share of what was turned over: engines of first
# order reach a thousandth at their usual steps, and damping or a wrong mass that matters is above it.
BALANCED = 0.01

# Energy that round-off may make or lose at rest, as a share of the work of the largest tension along the characteristic
# length: about 2e-6 J for the example robots, and the same share for robots of any size and force.
AT_REST = 1e-8

PIECE = 4096  # rows that are looked at together: enough that a call of numpy costs little for each
SUMMED = 4096  # samples whose squares are added up as one block


# Of runs that do not bring them: a page asks for them four times, and of a long run they take a walk through its log.
_COUNTED: WeakKeyDictionary[Run, dict[str, Any]] = WeakKeyDictionary()


def summarise(run: Run) -> dict[str, Any]:
    """Return errors, tensions, infeasible steps and speed of a run as plain numbers.

    Errors are norms over the sample's three components; `largest_step` is the largest change of one tension from one
    sample to the next; a cable that is broken does not count any more. `infeasible_steps` are samples whose wrench no
    tensions within the limits balance, as the solver says; `unanswered_steps` those at which it had no valid answer.
    `beyond_limits_steps`, where the robot has such limits, are samples with cables shorter or longer than allowed, or
    wound faster, and where the controller believes the robot to be another, told to pull less or more; where cables are
    not ideal, those whose true tension leaves the limits. `slack_samples` are those at which a cable has no tension,
    `slack_intervals` when which cable has none. `through_anchor_s`, `through_axis_s` and `passed`, a sentence, are
    there where one passes its anchor or its swivel axis: its force turns round within a step, no energy is balanced.
    `clearance_min_m`, where all cables have diameters, is the least clearance, with its time and pair. All samples are
    counted. Of a thinned log that stands alone only the rows in it can be: then `samples` is `logged_samples`.
    """
    counted = run.counted
    if counted is None:
        if run not in _COUNTED:
            _COUNTED[run] = _count(run)
        counted = _COUNTED[run]
    figures: dict[str, Any] = {"status": run.status, **deepcopy(counted), **run.clearance}
    if run.header.believed:
        figures["believed"] = run.header.believed
    if run.header.log_every > 1:
        figures |= {"log_step_s": run.header.log_step, "logged_samples": len(run.rows)}
    loop = run.timings.get("loop_s")
    if loop:
        figures["real_time_factor"] = figures["simulated_s"] / loop
    return figures


def _count(run: Run) -> dict[str, Any]:
    tally = Tally(run.header, len(run.rows))
    for first in range(0, len(run.rows), PIECE):
        tally.add(run.rows[first : first + PIECE])
    return tally.figures()


def left_and_slack(header: Header, rows: Array) -> tuple[Reach, Slack]:
    """Return which limits cables left, and when they were slack, in rows that are all samples of a run."""
    reach, loose = beyond_of(header), Slack()
    reach.add(rows)
    if len(rows):
        tension = rows[:, header.layout.columns[header.true_tension]]
        loose = loose.added(rows[:, 0], slack(tension, header) & sound(header, rows[:, 0]))
    return reach, loose


def sound(header: Header, time: Array) -> NDArray[np.bool_]:
    """Return which cables are not broken at these times (K,), (K, m): of the others nothing is asked any more."""
    found = np.ones((len(time), len(header.cables)), bool)
    for cable, since in header.broken:
        found[:, cable] &= time < since
    return found


def beyond_of(header: Header) -> Reach:
    """Return what counts where the cables of a run leave their limits."""
    limits = np.array([header.tension_min, header.tension_max])
    return beyond(header.layout, header.bounds, limits, header.broken, header.limit_changes)


class Tally:
    """Counts the samples of a run as they come, in pieces of any size, to the same bits.

    Extremes and counts need one number each. How a sum is rounded depends on what is added first: squared errors are
    added up in blocks of always the same samples. Of each sample its status is kept, one byte.

    Attributes:
        count: how many samples were counted.
        beyond: where cables left their limits.
        closest: how near they came to what they may touch, where somebody looks.
    """

    def __init__(self, header: Header, samples: int, closest: Closest | None = None) -> None:
        self._header = header
        self._status = np.empty(samples, np.int8)
        self._squares = np.empty((2, 0))  # of the norms of position and orientation error, in the present block
        self._sums: list[Array] = []  # of the blocks before, (2,) each
        self.beyond = beyond_of(header)
        self._found = Slack(), Singular()
        self.closest = closest
        self.count = 0
        self._start: Array | None = None  # the first row
        self._before: Array | None = None  # the tensions of the last sample
        self._final: dict[str, float] = {}
        self._low: dict[str, float] = {}
        self._high: dict[str, float] = {}

    @property
    def slack(self) -> Slack:
        """When cables were slack."""
        return self._found[0]

    @property
    def singular(self) -> Singular:
        """Cables whose direction turned over within a step."""
        return self._found[1]

    @property
    def status(self) -> NDArray[np.int8]:
        """What the solver's answer was found to be at each sample so far, a `cdpr.tension.Status`, (K,)."""
        return self._status[: self.count]

    def copy(self) -> Tally:
        """Return one that has counted as much; they share the table of statuses. `amend` comes next."""
        other = copy(self)
        other._final, other._low, other._high = dict(self._final), dict(self._low), dict(self._high)
        return other

    def put(self, first: int, status: NDArray[np.int8]) -> None:
        """Write the statuses of samples from `first` on, which were counted before."""
        self._status[first : first + len(status)] = status

    def amend(self, header: Header) -> None:
        """Go by a header in which other cables break, after the samples that were counted."""
        self._header = header
        self.beyond.lose(header.broken, tables(header.limit_changes))
        if self.closest is not None:
            self.closest.lose(header.broken)

    def add(self, rows: Array) -> None:
        """Count the samples that follow, (n, width); those that an interrupt cut short are given once more."""
        if not len(rows):
            return
        if self._start is None:
            self._start = rows[0].copy()
        part = Run(self._header, rows, start=self._start)
        now = slice(self.count, self.count + len(rows))
        self._status[now] = np.nan_to_num(part.solver_status, nan=-1.0)
        squares = np.empty((2, len(rows)))
        with np.errstate(over="ignore", invalid="ignore"):  # a diverged run is summed up too
            for i, error in enumerate((part.position_error, part.orientation_error)):
                norms = np.linalg.norm(error, axis=1)
                squares[i] = norms**2
                self._look(f"error {i}", norms)
            sums, squares = self._added(squares)
            intact = sound(self._header, part.time)
            self._look("tension", part.tension[intact])
            held = part.tension if self._before is None else np.concatenate([self._before, part.tension])
            self._look("step", np.abs(np.diff(held, axis=0))[intact[len(intact) - len(held) + 1 :]])
            self._look("cable tension", part.cable_tension[intact])
            beyond = self.beyond.copy()
            beyond.add(rows)
            loose = self.slack.added(part.time, slack(part.cable_tension, self._header) & intact)
            closest = None if self.closest is None else self.closest.copy()
            if closest is not None:
                closest.add(rows[:, 0], rows[:, self._header.layout.span("position", "orientation")])
            singular = self.singular.added(part, intact)
            for name in ("residual", "margin", "kinetic", "cable_work", "external_work"):
                self._look(name, part[name])
            parts = np.abs([part.kinetic, part.potential_change, part.cable_work, part.external_work])
            self._look("turned over", parts)
            self._look("unexplained", np.abs(part.energy_residual))
        self._final["time"] = float(part.time[-1])
        before = part.tension[-1:].copy()
        # What would be counted twice, last and at one go: between plain assignments there is no interrupt.
        told = sums, squares, beyond, (loose, singular), closest, before, now.stop
        self._sums, self._squares, self.beyond, self._found, self.closest, self._before, self.count = told

    def _added(self, squares: Array) -> tuple[list[Array], Array]:
        """Return the sums of whole blocks, and the squares of the last one, with those (2, n) that follow."""
        squares = np.concatenate([self._squares, squares], axis=1)
        whole = squares.shape[1] - squares.shape[1] % SUMMED
        blocks = np.split(squares[:, :whole], whole // SUMMED, axis=1) if whole else []
        return [*self._sums, *(block.sum(axis=1) for block in blocks)], squares[:, whole:]

    def figures(self) -> dict[str, Any]:
        """Return what `summarise` says of the samples."""
        figures: dict[str, Any] = {
            "samples": self.count,
            "simulated_s": self._final.get("time", 0.0),
            "infeasible_steps": int(np.count_nonzero(self.status == Status.INFEASIBLE)),
            "unanswered_steps": int(np.count_nonzero((self.status != Status.OK) & (self.status != Status.INFEASIBLE))),
        }
        if not self.count:
            return figures
        low, high = self._low, self._high
        figures["position_error_m"] = self._error(0)
        figures["orientation_error_rad"] = self._error(1)
        figures["tension_N"] = {
            "min": low.get("tension", 0.0),  # where all cables are broken from the first sample on
            "max": high.get("tension", 0.0),
            "largest_step": high.get("step", 0.0),
        }
        if not self._header.ideal_cables:
            figures["cable_tension_N"] = {
                "min": low.get("cable tension", 0.0),
                "max": high.get("cable tension", 0.0),
            }
        figures |= self.slack.figures(self._header.cables)
        figures["residual_max_N"] = high["residual"]
        figures["margin_min_N"] = low["margin"]
        figures["energy_J"] = self._energy()
        figures |= self.singular.figures(self._header.cables)
        if self.beyond.any:
            figures["beyond_limits_steps"] = self.beyond.counts()
        return figures

    def _look(self, name: str, values: Array) -> None:
        """Keep extremes and the last value; NaN stays."""
        if values.size:
            low, high = float(values.min()), float(values.max())
            self._low[name] = float(np.minimum(low, self._low.get(name, low)))
            self._high[name] = float(np.maximum(high, self._high.get(name, high)))
            self._final[name] = float(values.flat[-1])

    def _error(self, i: int) -> dict[str, float]:
        with np.errstate(over="ignore", invalid="ignore"):
            last = self._squares[i].sum()
            rms = float(np.sqrt(np.sum([*(sums[i] for sums in self._sums), last]) / self.count))
        return {"max": self._high[f"error {i}"], "rms": rms, "final": self._final[f"error {i}"]}

    def _energy(self) -> dict[str, float | bool]:
        """Largest kinetic energy, works, and the largest residual of their balance beside the energy turned over.

        That is the largest of kinetic energy, change of potential energy and works at any time; less than AT_REST
        counts as balanced.
        """
        turned_over, residual = self._high["turned over"], self._high["unexplained"]
        rest = AT_REST * self._high.get("tension", 0.0) * self._header.characteristic_length
        return {
            "kinetic_max": self._high["kinetic"],
            "cable_work": self._final["cable_work"],
            "external_work": self._final["external_work"],
            "turned_over": turned_over,
            "residual_max": residual,
            "balanced": residual <= max(BALANCED * turned_over, rest) and not self.singular.found,
        }
