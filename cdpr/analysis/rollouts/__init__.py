"""Rollouts: one scenario run as a closed loop thousands of times, in threads without the interpreter.

Keys of the scenario have a value for each case (`vary`). A case is the loop of `simulate`, with the same bits; its
samples go through a small ring buffer, from which rows and figures are taken (`case`, `figures`). Chunks of cases run
in threads or on a cluster; results stay in memory or go to a folder that can be continued (`rollout`). They are arrays
over cases and samples (`result`).
"""

from typing import TYPE_CHECKING

from cdpr.analysis.rollouts.batch import Batch
from cdpr.analysis.rollouts.result import Rollouts
from cdpr.analysis.rollouts.rollout import rollout
from cdpr.base.lazy import lazily

if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

__all__ = ["Batch", "Rollouts", "rollout"]
