"""Parameter studies: one scenario run many times with changed keys, each case in a worker process.

A study file defines axes, whose product is the cases (`schema`, `points`, `plan`). All cases are checked before the
first one runs. Each has an identifier computed from its scenario and changes. The folder's ledger records finished
cases (`folder`), so that an interrupted study can be resumed (`run`, `cluster`). The table (`table`) depends on the
study alone, not on the machine, the time or the number of workers.
"""

from typing import TYPE_CHECKING

from cdpr.analysis.study.plan import Study, StudyCase, load_study
from cdpr.analysis.study.run import Results, run_study
from cdpr.base.lazy import lazily

if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

__all__ = ["Results", "Study", "StudyCase", "load_study", "run_study"]
