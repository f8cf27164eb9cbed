"""CPU and wall seconds of whole commands, of the stages of a run, and of a plain script beside them, and their ratios.

Each figure is the minimum of several fresh processes, all kinds in turn, after one of each that is not counted.
Run: python benchmarks/start.py [COUNT] [--json]
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).parent.parent
SCENARIO = str(ROOT / "scenarios" / "caroca.yaml")
SCRIPT = str(ROOT / "benchmarks" / "script.py")
COUNT = 5
CDPR = ["-m", "cdpr"]


def run(duration: float, *more: str) -> list[str]:
    """Words of `cdpr run` for this many simulated seconds."""
    return [*CDPR, "run", SCENARIO, "--set", f"simulation.duration={duration}", *more]


COMMANDS = {
    "import": ["-c", "import numpy, yaml, click, pluggy, pydantic"],
    "import_mujoco": ["-c", "import numpy, yaml, click, pluggy, pydantic, mcap, mujoco"],
    "help": [*CDPR, "--help"],
    "validate": [*CDPR, "validate", SCENARIO],
    "info": [*CDPR, "info", SCENARIO],
    "run": run(2, "--no-report"),
    "run_report": run(2),
    "run_4s": run(4, "--no-report"),
    "script_4s": [SCRIPT, "4", "script.csv"],
    "run_0.01s": run(0.01, "--no-report"),
    "run_mujoco_0.01s": run(0.01, "--no-report", "--backend", "mujoco"),
    "script_0.01s": [SCRIPT, "0.01", "script.csv"],
}

# Required ratios of CPU seconds: a command, what it is compared with, and the highest ratio.
RATIOS = (
    ("validate", "import", 1.6),
    ("run_mujoco_0.01s", "import_mujoco", 1.6),
    ("run_mujoco_0.01s", "script_0.01s", 2.0),
    ("info", "validate", 1.3),
)

# Stages of a run, in order: each reports the CPU seconds of the process so far.
STAGES = f"""
import json, time
told = {{}}
def stage(name):
    told[name] = time.process_time()
stage("python")
import numpy; stage("numpy")
import click, yaml; stage("click, yaml")
from pydantic import BaseModel; stage("pydantic")
from cdpr.scenario import load_scenario; stage("cdpr.scenario")
from cdpr.plugins.registry import registry; registry(); stage("plugins found")
scenario = load_scenario({SCENARIO!r}, overrides={{"simulation.duration": 2.0}}); stage("scenario loaded")
scenario.warnings; stage("judged")

from cdpr.native import library; stage("kernels loaded")
from cdpr.simulation import simulate; stage("cdpr.simulation")
from cdpr.simulation.start import attempt
made = attempt(scenario, {{}}, None, "out"); stage("folder made")
loop, recorder = made.begin(); stage("parts built")
loop.run(recorder.rows, recorder.flush, steps=2000); stage("2000 steps")
run = made.end(None); run.summary(); stage("log closed, summary")
print(json.dumps(told))
"""


def timed(words: list[str], folder: str, env: dict[str, str] | None = None) -> tuple[float, float]:
    """CPU (user and system) and wall seconds of one Python process."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), perf_counter()
    subprocess.run(
        [sys.executable, *words], cwd=folder, env={**os.environ, **(env or {})}, check=True, capture_output=True
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, perf_counter() - start


def stages() -> dict[str, float]:
    """CPU seconds of each stage of a run."""
    with tempfile.TemporaryDirectory() as folder:
        told = subprocess.run(
            [sys.executable, "-c", STAGES], cwd=folder, check=True, capture_output=True, text=True
        ).stdout
    found: dict[str, float] = json.loads(told.splitlines()[-1])
    ends = list(found.values())
    return {name: end - before for (name, end), before in zip(found.items(), [0.0, *ends], strict=False)}


def measure(count: int = COUNT) -> dict[str, float]:
    """All figures, s: of commands CPU, and wall as NAME_wall; of stages as "stage NAME"."""
    found: dict[str, float] = {}

    def keep(name: str, seconds: float) -> None:
        found[name] = min(seconds, found.get(name, seconds))

    with tempfile.TemporaryDirectory() as folder:
        for turn in range(count + 1):
            rows = {name: timed(words, folder) for name, words in COMMANDS.items()}
            parts = stages()
            if turn:
                for name, (cpu, wall) in rows.items():
                    keep(name, cpu)
                    keep(f"{name}_wall", wall)
                for name, cpu in parts.items():
                    keep(f"stage {name}", cpu)
    return found


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if word != "--json"]
    figures = measure(int(words[0]) if words else COUNT)
    if "--json" in sys.argv:
        print(json.dumps(figures, indent=2))
    else:
        for name in (name for name in figures if not name.endswith("_wall")):
            wall = figures.get(f"{name}_wall")
            print(f"{name:<28}{figures[name]:.3f} s CPU" + (f"   {wall:.3f} s" if wall is not None else ""))
        for name, other, most in RATIOS:
            print(f"{name} / {other}: {figures[name] / figures[other]:.2f} (at most {most:g})")
