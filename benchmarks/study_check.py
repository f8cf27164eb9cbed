"""Cost of checking a case of a study before the first one runs, in units of one numpy.linalg.pinv of a 6x8 matrix."""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from cdpr.analysis.study import Study, load_study

ROOT = Path(__file__).parent.parent
STUDY = """
scenario: {scenario}
axes:
  - {{key: controller.kd, linspace: {{start: 20, stop: 80, count: 30}}}}
  - {{key: controller.kp, logspace: {{start: 100, stop: 1600, count: 50}}}}
"""
CHUNK = 25  # cases
PINVS = 200
LIMIT = 150.0


def measured(path: Path, ended: Mapping[str, Any]) -> tuple[Study, float, float]:
    """The study, and the medians of what a case and a pinv cost, s."""
    matrix = np.random.default_rng(0).standard_normal((6, 8))
    cases, pinvs = [], []
    begun = perf_counter()

    def progress(done: int, total: int) -> None:
        nonlocal begun
        if done and done % CHUNK == 0:
            cases.append((perf_counter() - begun) / CHUNK)
            start = perf_counter()
            for _ in range(PINVS):
                np.linalg.pinv(matrix)
            pinvs.append((perf_counter() - start) / PINVS)
            begun = perf_counter()

    study = load_study(path, progress=progress, ended=ended)
    return study, median(cases[1:]), median(pinvs[1:])


def measure() -> dict[str, float]:
    """All figures."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "study.yaml"
        path.write_text(STUDY.format(scenario=os.path.relpath(ROOT / "scenarios" / "caroca.yaml", name)))
        study, case, pinv = measured(path, {})
        ended = {one.id: (one.checked, one.versions) for one in study.cases[len(study.cases) // 10 :]}
        again, resumed, its_pinv = measured(path, ended)
        assert again.digest == study.digest
    return {"cases": len(study.cases), "case_us": 1e6 * case, "pinvs": case / pinv, "resumed_pinvs": resumed / its_pinv}


if __name__ == "__main__":
    figures = measure()
    if "--json" in sys.argv:
        print(json.dumps(figures, indent=1))
    else:
        for name, value in figures.items():
            print(f"{name:<16}{value:.4g}")
    sys.exit(7 if figures["pinvs"] > LIMIT else 0)
