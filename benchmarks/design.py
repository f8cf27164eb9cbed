"""Advantage of optimizers over random candidates: the same number of evaluations, ten seeds each."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

from cdpr.analysis.design import Design, load_design, run_design
from cdpr.base.errors import PluginError

STUDIES = Path(__file__).parent.parent / "scenarios" / "studies"
SEARCHES = ("random", "differential_evolution", "cma")
SEEDS = 10
EVALUATIONS = 400
ROUNDS, CHUNK = 5, 300  # of the times, and evaluations in each


def other(design: Design, search: str, seed: int, evaluations: int) -> Design:
    """The same design with another search."""
    changed = {"type": search, "seed": seed, "evaluations": evaluations}
    optimizer = design.section.optimizer.model_copy(update=changed)
    return replace(design, section=design.section.model_copy(update={"optimizer": optimizer}))


def volume(design: Design) -> float:
    """Return the figure found; nothing if no candidate satisfies all constraints."""
    with TemporaryDirectory() as folder:
        found = run_design(design, folder)
    value = found.goals(found.best)[0]
    return value if found.feasible and value is not None else 0.0


def seconds(design: Design, jobs: int) -> float:
    """Time of an evaluation."""
    with TemporaryDirectory() as folder:
        start = perf_counter()
        run_design(design, folder, jobs=jobs)
        return (perf_counter() - start) / design.section.optimizer.evaluations


def main() -> None:
    numbers = [int(word) for word in sys.argv[1:] if word.isdigit()]
    evaluations = numbers[0] if numbers else EVALUATIONS
    design = load_design(STUDIES / "design_box.yaml")
    found: dict[str, list[float]] = {}
    for search in SEARCHES:
        try:
            found[search] = [volume(other(design, search, seed, evaluations)) for seed in range(SEEDS)]
        except PluginError as error:
            print(error, file=sys.stderr)
    chance = found["random"]
    rows = {
        name: {
            "median_m3": median(values),
            "least_m3": min(values),
            "to_random": median(values) / median(chance),
            "better_seeds": sum(a > b for a, b in zip(values, chance, strict=True)),
        }
        for name, values in found.items()
    }
    short = other(design, "random", 0, CHUNK)
    times = [[seconds(short, jobs) for jobs in (1, 2)] for _ in range(ROUNDS)]
    one, two = (min(column) for column in zip(*times, strict=True))
    result = {"evaluations": evaluations, "seeds": SEEDS, "searches": rows, "two_at_a_time": one / two}
    if "--json" in sys.argv:
        print(json.dumps(result, indent=1))
        return
    print(f"{evaluations} evaluations, {SEEDS} seeds; volume of the best, m^3")
    for name, row in rows.items():
        print(f"  {name:24}", *(f"{key} {value:8.4g}" for key, value in row.items()))
    print(f"  two candidates at a time are {one / two:.2f} times as fast; one takes {1e3 * one:.1f} ms")


if __name__ == "__main__":
    main()
