"""Worker process: runs the cases that it receives one by one, and returns their outcomes.

All workers are forks of one process, which `cdpr.analysis.jobs.forks` starts and controls. Cases and outcomes use a
private socket per worker, separate from the output of engines.
"""

from __future__ import annotations

import faulthandler
import gc
import os
import socket
import sys
import traceback
import warnings
from contextlib import suppress
from multiprocessing.connection import Connection
from time import perf_counter
from typing import NoReturn

from cdpr.analysis.jobs.cases import BEGUN, Case, Outcome
from cdpr.analysis.jobs.forks import NUMBER, RUNNING, START
from cdpr.base.errors import CdprError, ExitCode, OptionsLeftOut, one_line
from cdpr.base.processes import end_with
from cdpr.log.run import Run
from cdpr.native.operations import operations
from cdpr.plugins.registry import registry, use_files
from cdpr.scenario import Scenario, load_scenario
from cdpr.scenario.schema import ScenarioSection
from cdpr.simulation.loop_parts import check_entries
from cdpr.simulation.whole_run import simulate


def main(descriptor: int, parent: int) -> None:
    """Fork workers and report their exit statuses on request, until the socket closes or the parent ends."""
    end_with(parent)
    warnings.simplefilter("ignore", OptionsLeftOut)  # the planner of the cases reports `Scenario.notes`
    here = os.getpid()
    ScenarioSection.model_rebuild()  # would otherwise be done in each worker
    operations()  # loads the kernel library
    gc.freeze()  # objects loaded so far are shared with the forks
    with socket.socket(fileno=descriptor) as requests:
        requests.set_inheritable(False)
        while True:
            what, descriptors, _, _ = socket.recv_fds(requests, 1 + NUMBER.size, 2)
            if not what:
                return
            if what != START:
                pid, status = os.waitpid(NUMBER.unpack(what[1:])[0], os.WNOHANG)
                requests.sendall(NUMBER.pack(status if pid else RUNNING))
                continue
            connection, output = descriptors
            pid = _forked()
            if pid == 0:
                requests.close()
                _begin(connection, output, here)
            for each in descriptors:
                os.close(each)
            requests.sendall(NUMBER.pack(pid))


def _forked() -> int:
    """Fork; return the number of the worker, 0 in the worker itself, or -1 if the system has no resources."""
    try:
        pid = os.fork()
    except OSError:
        return -1
    with suppress(OSError):  # done by both, so that the group exists before anyone uses it
        os.setpgid(pid, pid)
    return pid


def _begin(descriptor: int, output: int, parent: int) -> NoReturn:
    """Run a worker until the socket closes, and exit like an interpreter."""
    code = 1
    try:
        end_with(parent)
        os.dup2(output, 1)
        os.dup2(output, 2)
        os.close(output)
        faulthandler.enable()  # prints the Python stack of a crash in native code
        _work(Connection(descriptor))
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:
        traceback.print_exc()
    finally:
        with suppress(Exception):
            sys.stdout.flush()
        os._exit(code)


def _work(connection: Connection) -> None:
    with suppress(EOFError):
        connection.recv().enter()
    while True:
        try:
            case = connection.recv()
        except EOFError:
            return
        connection.send(_run(case, connection))


_before: dict[str, Scenario] = {}  # last scenario by file; cases differ in a few keys


def _load(case: Case) -> Scenario:
    use_files(case.plugins)
    check_entries(case.parts)
    before = _before.get(case.scenario)
    same = before is not None and before.plugins is registry()
    scenario = load_scenario(case.scenario, text=case.text, overrides=case.changes, before=before if same else None)
    _before.clear()
    _before[case.scenario] = scenario
    return scenario


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
        run = simulate(_load(case), out=case.out, progress=progress)
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
