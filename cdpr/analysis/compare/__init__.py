"""Comparison of the same closed loop on several engines.

- `differences`: differences of two runs by quantity;
- `engines`: selection of the engines, the judge and the standard of each engine;
- `convergence`: limit of an engine for a vanishing step, compared with the judge's;
- `verdict`: verdict on the run of one engine;
- `comparison`: comparison of all engines, each run in its own process; `finished` compares run folders;
- `excitation`: effects that a run does not exercise, so that agreement does not cover them;
- `refinement`: measured order of convergence;
- `baseline`: reference data of a run, `baseline_file` its file, `baseline_check` the check of later runs against it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

_HOME = {
    "Comparison": "cdpr.analysis.compare.job",
    "compare_finished": "cdpr.analysis.compare.finished",
    "compare_scenario": "cdpr.analysis.compare.job",
}

if TYPE_CHECKING:
    from cdpr.analysis.compare.finished import compare_finished
    from cdpr.analysis.compare.job import Comparison, compare_scenario
else:
    from cdpr.base.lazy import lazily

    __getattr__ = lazily(__name__, _HOME)

__all__ = ["Comparison", "compare_finished", "compare_scenario"]
