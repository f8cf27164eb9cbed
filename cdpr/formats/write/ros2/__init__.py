"""A scenario as a skeleton of packages for ROS 2: a node that wraps the run, and a service that distributes a wrench.

Two packages, since messages need one of their own: NAME (ament_python: node, launch file, parameters, the scenario) and
NAME_interfaces (ament_cmake: the service). No ROS is needed here; files/ holds the texts.
"""

from __future__ import annotations

import re
from pathlib import Path

import yaml

from cdpr.errors import FormatError, OutputError
from cdpr.log.files import replace
from cdpr.problems import dotted
from cdpr.scenario import Scenario
from cdpr.scenario.named_files import files_of_scenario

FILES = Path(__file__).parent / "files"

# Where each text goes; {name} is that of the package.
LAYOUT = {
    "README.md": "README.md",
    "package.xml": "{name}/package.xml",
    "setup.py": "{name}/setup.py",
    "setup.cfg": "{name}/setup.cfg",
    "node.py": "{name}/{name}/node.py",
    "launch.py": "{name}/launch/{name}.launch.py",
    "parameters.yaml": "{name}/config/parameters.yaml",
    "interfaces_package.xml": "{name}_interfaces/package.xml",
    "CMakeLists.txt": "{name}_interfaces/CMakeLists.txt",
    "DistributeWrench.srv": "{name}_interfaces/srv/DistributeWrench.srv",
}


def write_ros2(scenario: Scenario, folder: Path) -> list[Path]:
    """Write the packages into `folder`, empty or not there yet; return the files, by their names.

    The same scenario gives the same bytes. Raises FormatError where the scenario needs files beside it, OutputError
    where something cannot be written or is there already.
    """
    content = packages(scenario)
    try:
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise OutputError(f"{folder}: is there already, and is no empty folder: choose another, or empty it")
        for path in content:
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: cannot be written: {error.strerror or error}") from error
    for path, text in content.items():
        replace(folder / path, text)
    return [folder / path for path in content]


def packages(scenario: Scenario) -> dict[str, str]:
    """Return the texts of all files by their paths; FormatError as above."""
    text = scenario.resolved_yaml()
    for key, file in files_of_scenario(yaml.safe_load(text), scenario.plugins):
        raise FormatError(
            f"scenario '{scenario.name}': {dotted(key)} is the file '{file}', which a package for ROS 2 does not hold: "
            "leave it out (--set), or let the scenario say what is in it"
        )
    name = package_name(scenario.robot.name)
    # Names are letters, digits and -_. alone: they need no escapes in Python, XML or YAML.
    told = f"scenario '{scenario.name}' of the cable-driven parallel robot '{scenario.robot.name}'"
    found = {
        f"{name}/config/scenario.yaml": text,
        f"{name}/resource/{name}": "",
        f"{name}/{name}/__init__.py": "",
    }
    for source, path in LAYOUT.items():
        template = (FILES / f"{source}.in").read_text(encoding="utf-8")
        filled = template.replace("@PACKAGE@", name).replace("@DESCRIPTION@", told)
        found[path.format(name=name)] = filled
    return dict(sorted(found.items()))


def package_name(robot: str) -> str:
    """Return a name that ROS 2 takes: lower-case letters, digits and single underscores, a letter first."""
    word = re.sub(r"[^a-z0-9]+", "_", robot.lower()).strip("_")
    return f"cdpr_{word}" if word else "cdpr_robot"
