"""A worker process: runs one case after another that its parent sends, and tells how each ended.

Started by `cdpr.jobs.pool`. Cases and answers go through a private socket; whatever engines print goes elsewhere.
"""

from __future__ import annotations

import faulthandler
import os
import sys
from multiprocessing.connection import Connection
from time import perf_counter

from cdpr.errors import CdprError, ExitCode, one_line
from cdpr.jobs.cases import BEGUN, Case, Outcome
from cdpr.log.run import Run
from cdpr.plugins.registry import use_files
from cdpr.processes import end_with
from cdpr.scenario import load_scenario
from cdpr.simulation.simulate import simulate


def main(descriptor: int, parent: int) -> None:
    """Answer the cases that come through the socket until the parent closes it or ends."""
    os.set_inheritable(descriptor, False)
    end_with(parent)
    faulthandler.enable()  # a crash in native code tells where Python was
    connection = Connection(descriptor)
    while True:
        try:
            case = connection.recv()
        except EOFError:
            return
        connection.send(_run(case, connection))


def _run(case: Case, connection: Connection) -> Outcome:
    started = perf_counter()
    begun = False

    def progress(done: int, total: int) -> None:
        nonlocal begun
        if not begun:
            begun = True
            connection.send(BEGUN)

    run: Run | None = None
    message, code = "", ExitCode.OK
    try:
        use_files(case.plugins)
        scenario = load_scenario(case.scenario, text=case.text, overrides=case.changes)
        run = simulate(scenario, out=case.out, progress=progress)
    except CdprError as error:
        run, message, code = error.run, str(error), error.exit_code
    except Exception as error:
        message, code = f"internal error: {one_line(error)}", ExitCode.INTERNAL
    seconds = {"case_s": perf_counter() - started}
    if run is None:
        return Outcome(case.key, "failed", message, case.out or "", timings=seconds, code=code)
    return Outcome(
        case.key,
        run.status,
        message,
        case.out or "",
        run.summary(),
        run.header.versions,
        {**run.timings, **seconds},
        code,
    )


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
