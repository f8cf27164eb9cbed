"""Designs: keys of a robot file varied within bounds until the robot is as good as it gets.

A study file names the robot, what is varied, figures that are asked of each candidate, what is to be large or small and
what must be kept (`schema`, `reader`, `plan`). A candidate's figures come from `cdpr.workspace` (`evaluate`), and how
good it is from these alone (`rank`). What asks for candidates is a seeded `search`; each evaluation is one line of a
ledger, so that an interrupted design is replayed from it and goes on to the same result, to the bit (`ask`, `run`).
"""

from typing import TYPE_CHECKING

from cdpr.design.plan import Design
from cdpr.design.reader import load_design
from cdpr.design.result import Designed
from cdpr.design.run import run_design
from cdpr.lazy import lazily

if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

__all__ = ["Design", "Designed", "load_design", "run_design"]
