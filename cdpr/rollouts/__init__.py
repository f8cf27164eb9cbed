"""Rollouts: one scenario run as a closed loop thousands of times, in threads that need no interpreter.

Keys of the scenario take a value for each case (`vary`). A case is the loop of `simulate`, to the same bits, with the
rows that are kept taken from a small ring of samples and its figures counted meanwhile (`case`, `figures`). Chunks of
cases go to threads or to a cluster, into memory or a folder that goes on where it stopped (`rollout`), and what comes
out are arrays over cases and samples (`result`).
"""

from typing import TYPE_CHECKING

from cdpr.lazy import lazily
from cdpr.rollouts.batch import Batch
from cdpr.rollouts.result import Rollouts
from cdpr.rollouts.rollout import rollout

if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

__all__ = ["Batch", "Rollouts", "rollout"]
