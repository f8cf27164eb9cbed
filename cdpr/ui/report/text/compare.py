"""Comparison as text and aligned tables, for a terminal of 80 columns."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping
from typing import Any

from cdpr.analysis.compare.differences import QUANTITIES
from cdpr.ui.report.text.aligned import digits, table

WIDTH = 80
VERDICTS = {True: "agree", False: "DISAGREE", None: "not judged"}

DIFFERENT_SOLVERS = "The runs use different solvers; differences are shown, not judged."

Figures = Mapping[str, Any]


def lines(figures: Figures) -> Iterator[str]:
    """Yield the lines: the verdict, a table per engine, the orders, and engines that did not run."""
    yield from _wrapped(f"{VERDICTS[figures['agrees']]}: {subject(figures)}")
    if figures["agrees"] is None and different_solvers(figures):
        yield DIFFERENT_SOLVERS
    for group in figures["groups"]:
        yield ""
        yield from _wrapped(f"solver {group['solver']}: {VERDICTS[group['agrees']]}{_about(group)}")
        for row in group["engines"]:
            yield from _wrapped(f"{row['label']}: {outcome(row)}")
            yield from table([TITLES[row["standard"]], *_rows(row)], left=2) if row["differences"] else ()
            for text in notes(row):
                yield from _wrapped(f"  {text}", "    ")
        for text in among(group):
            yield from _wrapped(text)
        if group["orders"]:
            yield from table([ORDER_TITLES, *map(order_cells, group["orders"])], left=3)
        for text in (*order_reasons(group), *truth_error(group)):
            yield from _wrapped(text)
    for name, reason in figures["absent"].items():
        yield from _wrapped(f"{name}: not run: {reason}")


def different_solvers(figures: Figures) -> bool:
    """Return True if finished runs with different tension solvers were compared."""
    return any(", " in group["solver"] for group in figures["groups"])


def subject(figures: Figures) -> str:
    """Return a description of the compared runs."""
    judge = figures["judge"]
    return (
        f"{figures['scenario']}, {figures['duration_s']:g} s, control {1e3 * figures['control_step_s']:g} ms, "
        f"physics {1e3 * figures['physics_step_s']:g} ms; judge {judge['backend']}, order {judge['order'] or 'unknown'}"
        f"{_compared(figures)}"
    )


def _compared(figures: Figures) -> str:
    """Return the number of compared samples, if logs contain only a part of them."""
    part = figures.get("compared")
    return f"; compared are {part['logged_samples']} of {part['samples']} samples, as logged" if part else ""


def outcome(row: Figures) -> str:
    """Return the outcome of an engine with its reason, declared scheme and order, and time per step."""
    text = row["outcome"].upper() if row["outcome"] in ("disagrees", "failed") else row["outcome"]
    text += f": {row['reason']}" if row["reason"] else ""
    facts = [row["scheme"].replace("_", " ")] if row["scheme"] else []
    facts += [f"order {row['order']}"] if row["order"] else []
    facts += [f"{row['step_us']:.3g} µs a step"] if row["step_us"] else []
    return f"{text} ({', '.join(facts)})" if facts else text


def notes(row: Figures) -> Iterator[str]:
    """Yield remarks beside the tables: limits of the check, differing solver statuses and vertices."""
    if row["standard"] == "order" and row["differences"]:
        yield LIMIT_ALONE
    for key, what in (("statuses", "another solver status"), ("vertices", "tensions at another vertex")):
        if row[key]:
            first = row[key][0]
            count = sum(span["samples"] for span in row[key])
            yield f"{what} in {count} samples, first at {first['start']:.6g} to {first['end']:.6g} s"


def among(group: Figures) -> Iterator[str]:
    """Yield the judge's tensions, features that the scenario does not cover, and differences within schemes."""
    tension = group["judge_tension_N"]
    if tension:
        span = f"{tension['min'] or 0:.5g} to {tension['max'] or 0:.5g} N"
        cost = f"; {group['judge_step_us']:.3g} µs a step" if group["judge_step_us"] else ""
        yield f"the judge's tensions are {span}, their largest step {tension['largest_step'] or 0:.4g} N{cost}"
    if group["unexcited"]:
        what = (
            "not in the compared samples, so perhaps not covered"
            if group["thinned"]
            else "not covered by this scenario"
        )
        yield f"{what}: {'; '.join(group['unexcited'])}"
    for scheme, worst in group["same_scheme"].items():
        parts = ", ".join(f"{value:.1e} {QUANTITIES[name].unit}" for name, value in worst.items())
        yield f"engines of the scheme {scheme.replace('_', ' ')} are at most {parts} apart"


def order_cells(measured: Figures) -> list[str]:
    """Return an engine's row in the table of orders."""
    order = "-" if measured["order"] is None else f"{measured['order']:.3f}"
    control = "" if measured["control_step"] is None else f"{1e3 * measured['control_step']:g}"
    steps = " ".join(f"{1e3 * step:g}" for step in measured["steps"])
    errors = f"{measured['errors'][0]:.1e} to {measured['errors'][-1]:.1e}" if measured["errors"] else ""
    return [measured["backend"], f"{order} of {measured['declared']}", measured["outcome"], control, steps, errors]


def order_reasons(group: Figures, *, failed: bool = False) -> Iterator[str]:
    """Yield the reasons why orders differ from declared ones or were not measured; only of failed runs if `failed`."""
    for measured in group["orders"]:
        if measured["reason"] and (measured["outcome"] == "failed" or not failed):
            yield f"measured order of {measured['backend']}: {measured['outcome']}: {measured['reason']}"


def truth_error(group: Figures) -> Iterator[str]:
    """Yield the accuracy of the reference run for measured orders."""
    known = [each["truth_error"] for each in group["orders"] if each["truth_error"] is not None]
    if known:
        yield f"orders are shown, not judged; the error of the reference is at most about {digits(max(known))} m"


# Note on faults that vanish with the step or are small compared with its error.
LIMIT_ALONE = (
    "judged by its limit for a vanishing step, because the judge offers no scheme that it declares: commands that act "
    "a step late, or a friction of 1e-4 1/s, may not show"
)

ORDER_TITLES = ["engine", "order", "", "control", "steps (ms)", "errors (m)"]
FIRST = ["quantity", "", "largest", "rms", "at s"]
TITLES = {
    "scheme": [*FIRST, "beyond scheme", "allowed"],
    "order": [*FIRST, "limit (rms)", "allowed"],
    "none": FIRST,
}


def _rows(row: Figures) -> Iterator[list[str]]:
    checks = {check["quantity"]: check for check in row["checks"]}
    for name, found in row["differences"].items():
        quantity = QUANTITIES[name]
        cells = [quantity.title, quantity.unit, *map(digits, (found["max"], found["rms"])), f"{found['time']:.6g}"]
        if row["standard"] != "none":
            cells += check_cells(checks[name]) if name in checks else ["", "not judged"]
        yield cells


def check_cells(check: Figures) -> list[str]:
    """Return the judged value and its bound."""
    mark = "" if check["agrees"] else " !"
    return [f"{digits(check['value'])}{mark}", digits(check["high"])]


def worst(row: Figures) -> tuple[float, str] | None:
    """Return the largest ratio of a value to its bound, and its quantity; None if nothing is judged.

    Above 1 the engine disagrees.
    """
    shares = [
        (check["value"] / check["high"], title)
        for check in row["checks"]
        if check["value"] is not None and check["high"] and (title := QUANTITIES[check["quantity"]].title)
    ]
    return max(shares, default=None)


def _about(group: Figures) -> str:
    if group["problem"]:
        return f": {group['problem']}"
    return "" if group["continuous"] else ": its tensions may jump, the pose is judged"


def _wrapped(text: str, indent: str = "  ") -> list[str]:
    return textwrap.wrap(text, WIDTH, subsequent_indent=indent)
