"""The same closed loop on several engines, held against each other and against what is known of their schemes.

- `differences`: how far two runs are apart, quantity by quantity;
- `engines`: who takes part, who judges, and by which standard each is judged;
- `convergence`: an engine's limit for a vanishing step, against the judge's;
- `verdict`: one engine's run against its standard;
- `comparison`: runs all of them, each in a process of its own, and judges them; `finished` judges run folders;
- `excitation`: what the scenario never asks of an engine, of which agreement says nothing;
- `refinement`: the measured order;
- `baseline`: what is kept of a run, `baseline_file` where, and `baseline_check` holds a later run against it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

_HOME = {
    "Comparison": "cdpr.compare.job",
    "compare_finished": "cdpr.compare.finished",
    "compare_scenario": "cdpr.compare.job",
}

if TYPE_CHECKING:
    from cdpr.compare.finished import compare_finished
    from cdpr.compare.job import Comparison, compare_scenario
else:
    from cdpr.lazy import lazily

    __getattr__ = lazily(__name__, _HOME)

__all__ = ["Comparison", "compare_finished", "compare_scenario"]
