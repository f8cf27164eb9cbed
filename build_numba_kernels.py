"""Compiled numba kernels for a wheel, so that no first run has to compile them.

Shared objects of them are made by running examples with what the wheel is made of, for any processor of this kind.
The build fails where that is not possible. An editable install and a wheel for another system than Linux have none.
Goes when the last numba kernel has gone.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import NoReturn

ROOT = Path(__file__).parent
VARIABLE = "CDPR_BUILD_NUMBA"
SECONDS = 1200.0  # after which the compiler hangs: it takes a minute or two

# All that a first run may need: each example, and each solver and controller, for an instant.
RUNS = '''
import sys
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory

import cdpr
from cdpr.errors import CdprError
from cdpr.model import objects
from cdpr.plugins.registry import registry
from cdpr.scenario.overrides import CHOICES
from cdpr.workspace.path import touched

root = Path(sys.argv[1])
assert Path(cdpr.__file__).is_relative_to(root), cdpr.__file__


def run(name, **more):
    """Return whether it ran, as `cdpr run` does it."""
    short = {"simulation.duration": 0.02, "simulation.ends_early": True}
    changes = {CHOICES[role]: value for role, value in more.items()}
    try:
        scenario = cdpr.load_scenario(root / "scenarios" / f"{name}.yaml", overrides=short | changes)
        scenario.warnings
        with TemporaryDirectory() as out:  # logs hold pictures, which have kernels of their own
            touched(scenario.robot, cdpr.simulate(scenario, out=out), scenario.obstacles)
        return True
    except CdprError as error:  # an engine or a solver that is not installed here
        print(f"{name} {more}: {error}", file=sys.stderr)
        return False


if not run("caroca", backend="reference"):
    sys.exit("the example caroca does not run")
for path in sorted((root / "scenarios").glob("*.yaml")):
    run(path.stem)
    run(path.stem, backend="reference")
for backend in ("mujoco", "bullet", "dart"):
    run("caroca", backend=backend)
for solver in registry().names("solver"):
    run("caroca", solver=solver)
for controller in registry().names("controller"):
    run("caroca", controller=controller)
print(objects.fingerprint(), version("numba"))
'''


def requirements() -> list[str]:
    """Return what the kernels are compiled with: what cdpr runs with."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        needed: list[str] = tomllib.load(file)["project"]["dependencies"]
    return needed


def wanted() -> bool:
    """Return whether a wheel built here contains them."""
    return sys.platform == "linux" and os.environ.get(VARIABLE) != "0"


def compile_kernels(place: Path) -> Path:
    """Compile kernels in an empty folder; return the folder to install as `cdpr/kernels`."""
    compiler = os.environ.get("CC") or "cc"
    if shutil.which(compiler) is None:
        fail(f"there is no C compiler: '{compiler}' is not found; install one or set CC")
    env = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    # Behind ours: pip's build environment, which has the dependencies.
    path = [str(ROOT), str(described(place)), *filter(None, [os.environ.get("PYTHONPATH")])]
    env |= {
        "NUMBA_CACHE_DIR": str(place),
        "NUMBA_CPU_NAME": "generic",
        "NUMBA_CPU_FEATURES": "",
        "PYTHONPATH": os.pathsep.join(path),
    }
    words = [sys.executable, "-P", "-c", RUNS, str(ROOT)]
    try:
        done = subprocess.run(words, env=env, cwd=place, capture_output=True, text=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        fail(f"compiling them took longer than {SECONDS:g} s")
    if done.returncode != 0:
        fail(f"compiling them failed:\n{done.stderr.strip()[-2000:]}")
    portable, numba = done.stdout.split()[-2:]
    made = list(place.glob("kernels-*/objects-*.so"))
    if not made:
        fail(f"none were compiled:\n{done.stderr.strip()[-2000:]}")
    for path in made:
        folder = place / "install" / path.parent.name
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, folder / f"objects-{portable}-{path.stem.rpartition('-')[2]}.so")
        (folder / "numba").write_text(numba)
    return place / "install"


def described(place: Path) -> Path:
    """Return a folder with the metadata by which cdpr finds its own plugins: it is not installed where it is built."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        project = tomllib.load(file)["project"]
    folder = place / "metadata"
    about = folder / f"{project['name']}-{project['version']}.dist-info"
    about.mkdir(parents=True)
    head = f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    (about / "METADATA").write_text(head)
    groups = project["entry-points"].items()
    lines = [line for group, points in groups for line in (f"[{group}]", *(f"{k} = {v}" for k, v in points.items()))]
    (about / "entry_points.txt").write_text("\n".join(lines) + "\n")
    return folder


def fail(reason: str) -> NoReturn:
    """End the build."""
    sys.exit(
        f"cdpr: a wheel must contain compiled kernels: {reason}\n"
        f"Set {VARIABLE}=0 to build a wheel without them; its first run then compiles them."
    )
