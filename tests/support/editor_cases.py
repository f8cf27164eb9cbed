"""A scenario with its robot in a folder of its own, for the editor to edit."""

from __future__ import annotations

import shutil
from pathlib import Path

from conftest import ROOT

SCENARIOS = ROOT / "scenarios"


def caroca_in(folder: Path) -> Path:
    """Copy a scenario and its robot there; return the folder."""
    (folder / "robots").mkdir()
    shutil.copy(SCENARIOS / "caroca.yaml", folder)
    shutil.copy(SCENARIOS / "robots/caroca.yaml", folder / "robots")
    return folder
