"""A copy of the program to which tests add what a reader would."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

from conftest import ROOT

PACKAGES = ("cdpr", "cdpr_backends", "cdpr_controllers", "cdpr_solvers")


def copy_of_program(folder):
    """Return the folder, with a copy of the program, a function that adds to it, and one that calls it there."""
    for name in PACKAGES:
        # With what is compiled of it, which is valid there, too; links lead to headers of the copy.
        shutil.copytree(ROOT / name, folder / name, symlinks=True)

    def add(file, text, table, **lines):
        """Write the file, and into the table what follows on certain words."""
        if file is not None:
            (folder / file).write_text(text)
        content = (folder / table).read_text()
        for what, after in lines.values():
            assert content.count(after) == 1
            content = content.replace(after, after + what)
        (folder / table).write_text(content)

    def run(*arguments, **environment):
        """Call `cdpr`; or Python, where the first argument is its option."""
        arguments = arguments if arguments[0] == "-c" else ("-m", "cdpr", *arguments)
        return subprocess.run(
            [sys.executable, *map(str, arguments)],
            env={**os.environ, "PYTHONPATH": str(folder), **environment},
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=300,
        )

    return folder, add, run
