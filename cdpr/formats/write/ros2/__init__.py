"""Export of a scenario as ROS 2 packages: a node that runs it, and a service that distributes a wrench.

There are two packages, because ROS 2 requires a separate one for messages: NAME (ament_python: node, launch file,
parameters, scenario) and NAME_interfaces (ament_cmake: service). ROS is not needed for the export; files/ contains the
templates.
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

# Output path of each template; {name} is the package name.
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
    """Write the packages into `folder`, which must be empty or missing; return the files, sorted by name.

    Equal scenarios give equal bytes.

    Raises:
        FormatError: if the scenario references other files.
        OutputError: if the folder is not empty or cannot be written.
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
    """Return the texts of all files by path.

    Raises:
        FormatError: if the scenario references other files.
    """
    text = scenario.resolved_yaml()
    for key, file in files_of_scenario(yaml.safe_load(text), scenario.plugins):
        raise FormatError(
            f"scenario '{scenario.name}': {dotted(key)} is the file '{file}', which a package for ROS 2 does not hold: "
            "leave it out (--set), or let the scenario say what is in it"
        )
    name = package_name(scenario.robot.name)
    # Names consist of letters, digits and -_. only and need no escapes in Python, XML or YAML.
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
    """Return a valid ROS 2 package name: lower-case letters, digits and single underscores, starting with a letter."""
    word = re.sub(r"[^a-z0-9]+", "_", robot.lower()).strip("_")
    return f"cdpr_{word}" if word else "cdpr_robot"
