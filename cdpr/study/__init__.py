"""Studies: one scenario run many times with any of its keys changed, each case in a worker process.

A study file names axes, and their product is the cases (`schema`, `points`, `plan`). Each is checked before the first
one runs, and has an identity of its own: what it changes, in which scenario. What has ended stands in the folder's
ledger (`folder`), so that a study goes on where it was stopped (`run`, `cluster`). The table (`table`) depends on the
study alone, not on who computed it, when, or beside how many others.
"""

from typing import TYPE_CHECKING

from cdpr.lazy import lazily
from cdpr.study.plan import Study, StudyCase, load_study
from cdpr.study.run import Results, run_study

if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

__all__ = ["Results", "Study", "StudyCase", "load_study", "run_study"]
