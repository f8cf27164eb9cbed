"""Commands in README and docs/: their places, their requirements, and how a test runs each."""

from __future__ import annotations

import glob
import re
import shlex
import shutil
from pathlib import Path

import caspr_cases
import firmware_cases
import sdf_cases
from conftest import ROOT
from plugin_cases import SUCCESSOR, TRAJECTORY, wirex

PAGES = {
    path.relative_to(ROOT).as_posix(): path.read_text()
    for path in (ROOT / "README.md", *sorted(ROOT.glob("docs/*.md")))
}

# Placeholders for what a reader has.
YOURS = {"runs/...": "runs/one"}
SHORT = ["--set", "simulation.duration=0.02"]
# Arguments behind those of the page, by the beginning of a command: the same command in less time.
SHORTER = {
    "gui": ["--no-open", "--port", "0"],
    "run": [*SHORT, "--no-report"],
    "study": ["--dry-run"],  # no scheduler needed
    "design": ["--evaluations", "5"],
    "compare scenarios/": SHORT,
    "workspace compare": ["--count", "20"],
    "bench solvers": ["--poses", "2", "--adversaries", "1", "--solvers", "qp,osqp"],
}
# Seconds even so: engines and workers in processes of their own, all problems of the kit, kernels that only they need.
# A command that takes a file is here exactly if the one that writes the file is.
SLOW = (
    "baseline",
    "bench",
    "check",
    "compare scenarios/",
    "design",
    "fmu export scenarios/planar.yaml -o loop.fmu",
    "info gcode",
    "run gcode",
    "run scenarios/caroca.yaml --set believed",
    "run scenarios/caroca.yaml --set robot.cable.diameter",
    "run scenarios/cogiro_pulleys.yaml",
    "run scenarios/remote_plant.yaml",
    "run scenarios/thesis.yaml",
    "run scenarios/sagging.yaml",
    "run scenarios/winch.yaml",
    "size scenarios/winch.yaml --broken",
    "study scenarios/studies/thesis_belief.yaml",
    "study scenarios/studies/thesis_ch6.yaml",
    "tension scenarios/robots/caroca.yaml --solver all",
    "validate 'scenarios/*.yaml'",
    "validate gcode",
    "view gcode",
    "workspace compare",
    "workspace export out/proved.npz",
    "workspace ifcow scenarios/robots/caroca.yaml --cable-diameter 0.01 --method rays",
    "workspace static scenarios/robots/caroca.yaml --method certify",
    "workspace static scenarios/robots/cogiro.yaml --method turns",
    "workspace wrench-feasible",
)
# tests/project/test_docs.py runs its commands in full length, and compares their output with the tables.
WHOLE = "docs/teaching.md"
# Exit codes other than 0, as stated on the page.
CODES = {"cdpr check controller Hover": 7}
# Commands that no test runs unchanged, with the reason.
NOT_RUN = {
    "pip install 'cdpr[mujoco]'": "needs an index of packages",
    "pip install --editable .": "needs an index of packages; test_packages.py installs the package offline",
    "python docs/thesis.py out/thesis out/belief": "takes minutes and rewrites docs/; test_docs.py holds its parts",
    "openssl": "another program",
    "g++": "needs a file of the reader; test_native_headers.py compiles one that includes all headers",
    "cmake -S examples/realtime": "compiles; test_export_native.py builds the same programs",
    "python -m ziglang": "another program",
    "build/realtime": "compiled by the line above; test_export_native.py runs it",
    "dask": "another program, which listens; tests of studies start schedulers of their own",
    "export DASK": "a setting of the shell",
}
# Plugins that the page builds; tests/plugins/test_packages.py installs them and runs these.
INSTALLED = re.compile(r"\b(weighted|drag)\b")


def commands(text: str) -> list[str]:
    """The commands of the console blocks, each in one line and without its comment."""
    blocks = re.findall(r"^```console\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    lines = "".join(blocks).replace("\\\n", "").splitlines()
    return [shlex.join(shlex.split(line.removeprefix("$ "), comments=True)) for line in lines]


def words(command: str) -> list[str]:
    """The arguments of a cdpr command, as a shell in the current folder gives them."""
    given = shlex.split(command)[1:]
    if ">" in given:
        given = given[: given.index(">")]
    given = [YOURS.get(word, word) for word in given]
    return [name for word in given for name in (sorted(glob.glob(word)) if "*" in word else [word])]


def shorter(command: str) -> list[str]:
    """Additions to a command that make it fast enough for a test."""
    said = command.removeprefix("cdpr ")
    return [word for start, more in SHORTER.items() if said.startswith(start) for word in more]


def code(command: str) -> int:
    """The exit code of a command."""
    return next((code for start, code in CODES.items() if command.startswith(start)), 0)


def make_folder(folder: Path) -> None:
    """The scenarios, and what the commands call a reader's own."""
    shutil.copytree(ROOT / "scenarios", folder / "scenarios")
    shutil.copytree(ROOT / "scenarios" / "robots", folder / "robots")
    shutil.copy(ROOT / "scenarios/robots/caroca.yaml", folder / "my_robot.yaml")
    scenario = (ROOT / "scenarios/caroca.yaml").read_text()
    (folder / "my_scenario.yaml").write_text(re.sub(r"duration: 4.0 .*", "duration: 0.02", scenario))
    study = (ROOT / "scenarios/studies/gains.yaml").read_text()
    (folder / "my_study.yaml").write_text(study.replace("../", "scenarios/"))
    theirs = folder / "theirs"
    theirs.mkdir()
    caspr_cases.model(theirs, "CoGiRo", cables_=caspr_cases.cables(default="original", name="original"))
    for name, text in (("caroca.yaml", SUCCESSOR), ("trajectory.yaml", TRAJECTORY), ("IPAnema.wcrfx", wirex())):
        (theirs / name).write_text(text)
    (theirs / "hall.sdf").write_text(sdf_cases.text())
    (theirs / "config.g").write_text(firmware_cases.RRF)
    (theirs / "anchors.csv").write_text("-2,-2,3\n2,-2,3\n2,2,3\n-2,2,3\n")
    hover, _ = re.findall(r"^```python\n(import cdpr\n.*?)^run = ", PAGES["docs/plugins.md"], re.DOTALL | re.MULTILINE)
    (folder / "hover.py").write_text(hover)
