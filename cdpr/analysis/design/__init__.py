"""Design optimisation: keys of a robot file varied within bounds to optimise figures of the robot.

A study file names the robot, the variables, figures of each candidate, goals and constraints (`schema`, `reader`,
`plan`). The figures come from `cdpr.analysis.workspace` (`evaluate`), and the ranking depends on them alone (`rank`). A
seeded `search` proposes candidates. Each evaluation is one line of a ledger, from which an interrupted design is
replayed and continued to the identical result (`evaluations`, `run`).
"""

from typing import TYPE_CHECKING

from cdpr.analysis.design.plan import Design
from cdpr.analysis.design.reader import load_design
from cdpr.analysis.design.result import Designed
from cdpr.analysis.design.run import run_design
from cdpr.base.lazy import lazily

if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

__all__ = ["Design", "Designed", "load_design", "run_design"]
