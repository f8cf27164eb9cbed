"""Summary figures of a run, counted during the run with each row seen only once."""

from __future__ import annotations

from copy import copy, deepcopy
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from cdpr.log.clearance_rows import add_rows
from cdpr.log.consistency import Consistency, consistency
from cdpr.log.electrical import Electrical, electrical
from cdpr.log.header import Header
from cdpr.log.limit_violations import beyond, tables
from cdpr.log.lost_steps import LostSteps, lost_steps
from cdpr.log.run import Run
from cdpr.log.singular import PASSED, Singular
from cdpr.log.slack import Slack, slack
from cdpr.mechanics.reach import Reach
from cdpr.model.robot import Array
from cdpr.tension.status import Status

if TYPE_CHECKING:
    from cdpr.mechanics.closest import Closest

# Energy counts as balanced if the unexplained part is below this share of the energy turned over: first-order engines
# reach a thousandth at usual steps, and significant damping or mass errors exceed it.
BALANCED = 0.01

# Round-off of the energy at rest, as a share of the work of the largest true tension along the characteristic length:
# about 2e-6 J for the example robots, scaled with size and force.
AT_REST = 1e-8

UNKNOWN = "unknown_works"  # figure with the names of the sources of unknown work

PIECE = 4096  # rows per batch, large enough to make numpy's call overhead negligible
SUMMED = 4096  # samples per block of summed squares


# Cache for runs without stored figures: pages need them four times, and long logs are slow to read.
_COUNTED: WeakKeyDictionary[Run, dict[str, Any]] = WeakKeyDictionary()


def summarise(run: Run) -> dict[str, Any]:
    """Return errors, tensions, infeasible steps and speed of a run as plain numbers.

    All samples are counted. Of a thinned log without run.json, only its rows can be: `samples` then equals
    `logged_samples`.

    - Errors are norms over the three components of a sample.
    - `tension_N` are commanded tensions. If winches take lengths or rates, they are those that the nominal cables have
      at rest with these. `cable_tension_N` are the true tensions of cables that are not ideal.
    - `largest_step` is the largest change of a tension between two samples. Broken cables do not count.
    - `infeasible_steps` are samples whose wrench no tensions within the limits balance, according to the solver;
      `unanswered_steps` are solver failures.
    - `beyond_limits_steps`, if the robot has such limits, are samples with too short, too long or too fast cables. With
      a nominal model they include commands outside the true limits, and with non-ideal cables true tensions outside
      them.
    - `slack_samples` are samples with a slack cable, `slack_intervals` the intervals by cable.
    - `lost_steps`, if the robot has stepper motors, is the number of full steps by which they are wrong at the end;
      `lost_steps_intervals` are the intervals by cable, with positive numbers of steps if the cable was paid out.
    - `motor_current_A`, `motor_voltage_V` and `electrical_energy_J`, if motors have electrical data, are the largest
      magnitudes of all motors, the largest rms current, and the energies that the motors used and fed back.
    - `estimate`, with an estimator, contains the errors of its estimate, and for `nis` and `nees` the mean per value,
      which is 1 for an estimator whose model is right, and the share of the samples within the 95 % band.
      `unfitted_samples` are those at which no pose fits the measured lengths, if the estimator fits poses.
    - `energy_J` contains the work of each source, named by its column. `balanced` is None if the work of a source is
      unknown; `unknown_works` then names these sources.
    - `through_anchor_s`, `through_axis_s` and the sentence `passed` exist if a cable passes its anchor or swivel axis:
      its force reverses within a step, and energy is not balanced.
    - `clearance_min_m`, if all cables have diameters, is the smallest clearance, with its time and pair.
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
    tally = Accumulator(run.header, len(run.rows))
    for first in range(0, len(run.rows), PIECE):
        tally.add(run.rows[first : first + PIECE])
    return tally.figures()


def left_and_slack(header: Header, rows: Array) -> tuple[Reach, Slack]:
    """Return the limit violations and slack intervals in rows that are all samples of a run."""
    reach, loose = beyond_of(header), Slack()
    reach.add(rows)
    if len(rows):
        tension = rows[:, header.layout.columns[header.true_tension]]
        loose = loose.added(rows[:, 0], slack(tension, header) & sound(header, rows[:, 0]))
    return reach, loose


def sound(header: Header, time: Array) -> NDArray[np.bool_]:
    """Return True for cables that are not broken at these times (K,), (K, m)."""
    found = np.ones((len(time), len(header.cables)), bool)
    for cable, since in header.broken:
        found[:, cable] &= time < since
    return found


def beyond_of(header: Header) -> Reach:
    """Return the counter of limit violations of a run."""
    limits = np.array([header.tension_min, header.tension_max])
    return beyond(header.layout, header.bounds, limits, header.broken, header.limit_changes)


class Accumulator:
    """Counter of a run's samples in batches of any size, with bit-identical results.

    Extremes and counts need one number each. The rounding of a sum depends on the order, so squared errors are summed
    in fixed blocks of samples. The status of each sample is stored in one byte.

    Attributes:
        count: number of counted samples.
        beyond: limit violations.
        closest: clearance monitor; None if clearances are unknown.
    """

    def __init__(self, header: Header, samples: int, closest: Closest | None = None) -> None:
        self._header = header
        # columns of energy that comes from outside
        self._sources = ("cable_work", "external_work", *header.further_works.values())
        self._status = np.empty(samples, np.int8)
        self._squares = np.empty((2, 0))  # squared norms of position and orientation error in the current block
        self._sums: list[Array] = []  # (2,) of each complete block
        self.beyond = beyond_of(header)
        self._found = Slack(), Singular(), LostSteps(), Electrical(), Consistency()
        self.closest = closest
        self.count = 0
        self._start: Array | None = None  # first row
        self._before: Array | None = None  # tensions of the last sample
        self._final: dict[str, float] = {}
        self._low: dict[str, float] = {}
        self._high: dict[str, float] = {}

    @property
    def slack(self) -> Slack:
        """Intervals with slack cables."""
        return self._found[0]

    @property
    def singular(self) -> Singular:
        """Passages through anchors and axes."""
        return self._found[1]

    @property
    def lost(self) -> LostSteps:
        """Steps that stepper motors lost."""
        return self._found[2]

    @property
    def status(self) -> NDArray[np.int8]:
        """Solver status of each sample so far, a `cdpr.tension.Status`, (K,)."""
        return self._status[: self.count]

    def copy(self) -> Accumulator:
        """Return a copy that shares the table of statuses; call `amend` next."""
        other = copy(self)
        other._final, other._low, other._high = dict(self._final), dict(self._low), dict(self._high)
        return other

    def put(self, first: int, status: NDArray[np.int8]) -> None:
        """Restore the statuses of counted samples from `first` on."""
        self._status[first : first + len(status)] = status

    def amend(self, header: Header) -> None:
        """Set a header with other broken cables, effective after the counted samples."""
        self._header = header
        self.beyond.lose(header.broken, tables(header.limit_changes))
        if self.closest is not None:
            self.closest.lose(header.broken)

    def add(self, rows: Array) -> None:
        """Count the next samples, (n, width); samples cut short by an interrupt are passed again."""
        if not len(rows):
            return
        if self._start is None:
            self._start = rows[0].copy()
        part = Run(self._header, rows, start=self._start)
        now = slice(self.count, self.count + len(rows))
        self._status[now] = np.nan_to_num(part.solver_status, nan=-1.0)
        squares = np.empty((2, len(rows)))
        with np.errstate(over="ignore", invalid="ignore"):  # diverged runs are counted, too
            for i, error in enumerate((part.position_error, part.orientation_error)):
                norms = np.linalg.norm(error, axis=1)
                squares[i] = norms**2
                self._update_extremes(f"error {i}", norms)
            sums, squares = self._added(squares)
            intact = sound(self._header, part.time)
            self._update_extremes("tension", part.tension[intact])
            held = part.tension if self._before is None else np.concatenate([self._before, part.tension])
            self._update_extremes("step", np.abs(np.diff(held, axis=0))[intact[len(intact) - len(held) + 1 :]])
            self._update_extremes("cable tension", part.cable_tension[intact])
            beyond = self.beyond.copy()
            beyond.add(rows)
            loose = self.slack.added(part.time, slack(part.cable_tension, self._header) & intact)
            closest = None if self.closest is None else self.closest.copy()
            if closest is not None:
                add_rows(closest, self._header.layout, rows)
            lost = lost_steps(self.lost, self._header, rows)
            motors = electrical(self._found[3], self._header, rows)
            estimate = consistency(self._found[4], self._header, rows)
            found = loose, self.singular.added(part, intact), lost, motors, estimate
            for name in ("residual", "margin", "kinetic", *self._sources):
                self._update_extremes(name, part[name])
            parts = np.abs([part.kinetic, part.potential_change, *(part[name] for name in self._sources)])
            self._update_extremes("turned over", parts)
            self._update_extremes("unexplained", np.abs(part.energy_residual))
        self._final["time"] = float(part.time[-1])
        before = part.tension[-1:].copy()
        # State that must not be counted twice is assigned last: no interrupt occurs between plain assignments.
        updated = sums, squares, beyond, found, closest, before, now.stop
        self._sums, self._squares, self.beyond, self._found, self.closest, self._before, self.count = updated

    def _added(self, squares: Array) -> tuple[list[Array], Array]:
        """Return the sums of complete blocks and the squares of the current one, including the next squares (2, n)."""
        squares = np.concatenate([self._squares, squares], axis=1)
        whole = squares.shape[1] - squares.shape[1] % SUMMED
        blocks = np.split(squares[:, :whole], whole // SUMMED, axis=1) if whole else []
        return [*self._sums, *(block.sum(axis=1) for block in blocks)], squares[:, whole:]

    def figures(self) -> dict[str, Any]:
        """Return the figures of the samples, see `summarise`."""
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
            "min": low.get("tension", 0.0),  # default if all cables are broken from the first sample on
            "max": high.get("tension", 0.0),
            "largest_step": high.get("step", 0.0),
        }
        if not self._header.ideal_cables:
            figures["cable_tension_N"] = {
                "min": low.get("cable tension", 0.0),
                "max": high.get("cable tension", 0.0),
            }
        figures |= self.slack.figures(self._header.cables) | self.lost.figures(self._header.cables)
        figures |= self._found[3].figures(0.0 if self._start is None else float(self._start[0]))
        figures |= self._found[4].figures()
        figures["residual_max_N"] = high["residual"]
        figures["margin_min_N"] = low["margin"]
        figures["energy_J"] = self._energy()
        figures |= self.singular.figures(self._header.cables)
        if self.beyond.any:
            figures["beyond_limits_steps"] = self.beyond.counts()
        return figures

    def _update_extremes(self, name: str, values: Array) -> None:
        """Update extremes and the last value; NaN persists."""
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

    def _energy(self) -> dict[str, Any]:
        """Return the figures of the energy balance.

        The energy turned over is the largest of kinetic energy, change of potential energy and works at any time.
        Residuals below AT_REST count as balanced.
        """
        unknown = self._header.unknown_works
        turned_over, residual = self._high["turned over"], self._high["unexplained"]
        rest = AT_REST * self._high.get("cable tension", 0.0) * self._header.characteristic_length
        return {
            "kinetic_max": self._high["kinetic"],
            **{name: self._final[name] for name in self._sources},
            "turned_over": turned_over,
            "residual_max": residual,
            "balanced": None if unknown else residual <= max(BALANCED * turned_over, rest) and not self.singular.found,
            **({UNKNOWN: unknown} if unknown else {}),
        }


def not_judged(figures: dict[str, Any]) -> str:
    """Return why the energy balance of a summary is not judged; "" if it is."""
    if unknown := figures["energy_J"].get(UNKNOWN):
        return f"the work of {' and of '.join(unknown)} is unknown"
    return str(figures.get(PASSED, ""))
