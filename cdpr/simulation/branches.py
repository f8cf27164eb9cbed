"""Snapshots of a simulation, and branches that continue from them."""

from __future__ import annotations

import os
from dataclasses import dataclass

from cdpr.base.errors import CdprError, PluginError
from cdpr.log.recorder import Recorder, RecorderSnapshot
from cdpr.log.run_folder import RunFolder, folder_name, next_folder
from cdpr.plugins import TensionSolver
from cdpr.simulation.live import Interventions
from cdpr.simulation.moment import Moment
from cdpr.simulation.pace import Pace
from cdpr.simulation.session import Done


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Snapshot of a simulation, or of a lane of a batch, from which it can continue several times."""

    moment: Moment
    done: Done
    samples: RecorderSnapshot | None = None  # of a simulation
    of: object = None

    def __repr__(self) -> str:
        return f"<Snapshot at {self.moment.time:.6g} s>"


class Branches(Interventions):
    """Snapshot and restore of a simulation; after a restore its log continues in another folder."""

    _recorder: Recorder
    _pace: Pace
    _origin: object  # since the last reset

    def snapshot(self) -> Snapshot:
        """Return a snapshot of plant, controller, solver, events and time.

        Raises:
            PluginError: if the backend, the controller or the solver does not support snapshots.
        """
        with self._exclusive("snapshot"):
            self._ready(also_done=True)
            scenario = self._runner.scenario
            entry = scenario.plugins.get("solver", scenario.solver.type)
            solver = self._loop.parts.solver
            if entry.info.properties.get("warm_start") and type(solver).snapshot is TensionSolver.snapshot:
                raise PluginError(f"solver '{entry.info.name}' has a state, but does not support snapshots")
            moment = self._loop.snapshot()
            samples = self._recorder.snapshot(moment.count)
            return Snapshot(moment, self._runner.session.snapshot(), samples, self._origin)

    def restore(self, snapshot: Snapshot, *, out: str | os.PathLike[str] | None = None) -> None:
        """Restore a snapshot of this simulation; the following samples have the same bits.

        A simulation with a log continues in another folder. That folder also contains the samples from the start, and
        its run.json names the folder and the time of the branch. The log in the previous folder ends at its last
        sample.

        Args:
            snapshot: snapshot taken since the last reset. Later samples are discarded.
            out: other folder, new or empty; by default the name of the first folder with -2, -3, ...

        Raises:
            CdprError: if the samples do not fit into memory; the simulation is unchanged.
            OutputError: if the folder cannot be written; the simulation is unchanged.
        """
        with self._exclusive("restore"):
            if not isinstance(snapshot, Snapshot) or snapshot.samples is None or snapshot.of is not self._origin:
                raise CdprError("restore: expected a snapshot of this simulation, taken since its last reset")
            self._ready(also_done=True)
            if self._recorder.on_disk:
                raise CdprError(
                    "restore: not possible with samples that are stored in the log only: omit `out`, or set log.step"
                )
            if out is not None and self._runner.folder is None:
                raise CdprError("restore: `out` requires a simulation with a log, requested at its creation")
            if self._runner.folder is not None:
                self._branch(self._runner.folder, snapshot, out)
            with self._kept():
                self._runner.session.restore(snapshot.done)
                self._recorder.restore(snapshot.samples)
                self._pace = Pace(self._recorder.flush)
                self._runner.revise()
                self._loop.restore(snapshot.moment)
                if self._runner.folder is not None:
                    self._recorder.flush(snapshot.moment.count)

    def _branch(self, before: RunFolder, snapshot: Snapshot, out: str | os.PathLike[str] | None) -> None:
        """End the present log, and begin one in another folder."""
        path = next_folder(before.first) if out is None else folder_name(out)
        here = {"folder": str(before.path), "time": snapshot.moment.time}
        scenario = self._runner.scenario.yaml_in
        folder = RunFolder(path, self._runner.header, branch=here, first=before.first, scenario=scenario)
        with self._kept():
            self._runner = self._runner.branch(folder)
            assert self._runner.recorder is not None
            self._recorder = self._runner.recorder
