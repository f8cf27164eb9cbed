"""Cost of `cdpr gui`: time until its scene appears, real-time factor, cost of drawing, growth of memory."""

from __future__ import annotations

import argparse
import json
import os
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

SCENARIO = str(Path(__file__).parent.parent / "scenarios" / "caroca.yaml")
BACKENDS = ("reference", "mujoco", "bullet", "dart")
READY, DRAWING, KEEPS, FEWEST = 3.0, 0.20, 0.99, 55.0  # s, cores, simulated s a second, frames a second
GROWTH = 4.0  # MB between the middle third of a time and its last: the allocator's, not ours
SECONDS = 10.0  # of a measurement in real time
TICK = os.sysconf("SC_CLK_TCK")

LOOP = """
import sys, time, cdpr
with cdpr.Simulation(sys.argv[1], backend=sys.argv[2], overrides={"simulation.duration": 1e3}) as sim:
    sim.step(2000)
    start = time.process_time()
    sim.step(10000)
    print(time.process_time() - start)
    sim.close()
"""


class Window:
    """Browser's use of a socket, as seen by the server."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket

    def say(self, **words: Any) -> None:
        self.socket.send(json.dumps(words))

    def until(self, kind: str, **such: Any) -> dict[str, Any]:
        while True:
            message = json.loads(self.socket.recv(timeout=60))
            if message["kind"] == kind and all(message.get(key) == value for key, value in such.items()):
                return message

    def watch(self, seconds: float) -> list[float]:
        """Take all for so long; return the times of the frames, s of the simulation."""
        end, times = time.perf_counter() + seconds, []
        while (left := end - time.perf_counter()) > 0.0:
            try:
                message = json.loads(self.socket.recv(timeout=left))
            except TimeoutError:
                break
            if message["kind"] == "frame":
                times.append(message["t"])
        return times


@contextmanager
def served(backend: str, *options: str) -> Iterator[tuple[Window, subprocess.Popen[str], float]]:
    """A server, a window on it whose scene is there, and how long that took, s."""
    command = [
        sys.executable,
        "-m",
        "cdpr",
        "gui",
        SCENARIO,
        "--backend",
        backend,
        "--no-open",
        "--port",
        "0",
        *options,
    ]
    start = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            address = process.stdout.readline().strip().replace("http:", "ws:")
            with connect(address, max_size=None, compression=None, open_timeout=60) as socket:
                window = Window(socket)
                window.until("scene")
                window.until("status", phase="ready")
                yield window, process, time.perf_counter() - start
        finally:
            process.send_signal(signal.SIGINT)


def used(pid: int) -> float:
    """Processor time of a process, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICK


def held(pid: int) -> float:
    """Memory that a process holds, MB."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def ready() -> list[str]:
    """Measure the time until the scene appears."""
    times, took = [], []
    for _ in range(5):
        with served("reference") as (_, process, seconds):
            times.append(seconds)
            took.append(used(process.pid))
    print(
        f"scene ready {min(times):.2f} s after the command, at best of 5 (at most {READY:g}; {_list(times)}), "
        f"of which {min(took):.2f} s of a core"
    )
    return ["ready"] * (min(times) > READY)


def keeps_time(backend: str) -> list[str]:
    """Measure the real-time factor and its cost."""
    with served(backend, "--set", "simulation.duration=1000") as (window, process, _):
        window.say(do="run")
        window.watch(2.0)
        before, start = used(process.pid), time.perf_counter()
        times = window.watch(SECONDS)
        took, seconds = used(process.pid) - before, time.perf_counter() - start
    loop = subprocess.run([sys.executable, "-c", LOOP, SCENARIO, backend], capture_output=True, text=True, check=True)
    steps = float(loop.stdout) / 10.0  # a second of simulated time
    pace, rate = (times[-1] - times[0]) / seconds, len(times) / seconds
    drawing = took / seconds - steps * pace
    print(
        f"{backend}: {pace:.3f} s a second (at least {KEEPS:g}), {rate:.1f} frames/s (at least {FEWEST:g}), "
        f"{took / seconds:.1%} of a core, of which steps {steps:.1%} and drawing {drawing:.1%} (at most {DRAWING:.0%})"
    )
    missed = {"pace": pace < KEEPS, "frames/s": rate < FEWEST, "drawing": drawing > DRAWING}
    return [f"{backend}: {name}" for name, misses in missed.items() if misses]


def grows(minutes: float) -> list[str]:
    """Measure the growth of memory: half the time one long run with disturbances, then repeated runs."""
    slices = max(6, round(minutes))  # of each half
    sizes: dict[str, list[float]] = {"one run": [], "runs anew": []}
    with served("reference", "--set", f"simulation.duration={60.0 * minutes:g}") as (window, process, _):
        window.say(do="run")
        for half, held_then in sizes.items():
            for _ in range(slices):
                window.watch(30.0 * minutes / slices)
                held_then.append(held(process.pid))
                window.say(do="push", force=[20, 0, 0], duration=0.5)
                if half == "runs anew":
                    window.say(do="reset")
                    window.say(do="run")
    missed = []
    for half, values in sizes.items():
        third = len(values) // 3
        growth = statistics.median(values[-third:]) - statistics.median(values[third : 2 * third])
        print(
            f"{half}, {minutes / 2:g} minutes: {growth:+.1f} MB from the middle third to the last "
            f"(at most {GROWTH:g}); "
            f"{_list(values)}"
        )
        missed += [f"growth, {half}"] * (growth > GROWTH)
    return missed


def _list(values: list[float]) -> str:
    return " ".join(f"{value:.3g}" for value in values)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=0.0, help="how long to look whether it grows")
    parser.add_argument("--backend", action="append", choices=BACKENDS, help="default: all")
    options = parser.parse_args()
    missed = ready()
    for backend in options.backend or BACKENDS:
        missed += keeps_time(backend)
    if options.minutes:
        missed += grows(options.minutes)
    if missed:
        raise SystemExit(f"missed: {', '.join(missed)}")


if __name__ == "__main__":
    main()
