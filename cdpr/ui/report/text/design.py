"""Result of a design as lines and tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cdpr.ui.report.text.aligned import digits, table

BEST = "best"
COMPROMISE = "compromise"
ROWS = 20  # printed rows of a Pareto front


def chosen(found: Mapping[str, Any]) -> str:
    """Return the name of the best candidate: "compromise" if there are several goals."""
    return COMPROMISE if found["front"] else BEST


def claim(found: Mapping[str, Any]) -> tuple[str, str]:
    """Return the mood ("good", "warn" or "bad") and a summary of the result."""
    count = found["candidates"]
    if not found["feasible"]:
        return "bad", f"None of {count} candidates satisfies all constraints; the nearest one is shown"
    some = found["feasible"]
    more = "" if not found["front"] else f", {len(found['front'])} of them on the Pareto front"
    summary = f"{some} of {count} candidates satisf{'ies' if some == 1 else 'y'} all constraints{more}"
    if not found["improved"]:
        return "warn", f"{summary}; none is better than the robot without changes"
    return "good", summary


def figures(found: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the heading and rows of the table of figures before and after."""
    rows: list[tuple[str, ...]] = [("figure", "before", chosen(found))]
    for name, unit in found["units"].items():
        title = f"{name} ({unit})" if unit else name
        rows.append((title, *(number(found[which]["figures"][name]) for which in ("before", "best"))))
    for k, goal in enumerate(found["goals"]):
        if goal.partition(" ")[2] in found["units"]:  # a single figure, which is listed above
            continue
        rows.append((goal, *(number(found[which]["goals"][k]) for which in ("before", "best"))))
    return rows


def variables(found: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the heading and rows of the table of variables, with initial values if the robot has them."""
    rows: list[tuple[str, ...]] = [("variable", "start", chosen(found), "from", "to", "keys")]
    for each in found["variables"]:
        low, high = map(digits, each["bounds"])
        value = digits(found["best"]["values"][each["name"]])
        rows.append((each["name"], digits(each["start"]), value, low, high, each["keys"]))
    return rows


def members(found: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the heading and rows of the table of the Pareto front, sorted by the first goal."""
    names = [each["name"] for each in found["variables"]]
    rows = [("number", *found["goals"], *names)]
    for each in sorted(found["front"], key=lambda row: row["goals"]):
        values = [digits(each["values"][name]) for name in names]
        rows.append((str(each["number"]), *map(number, each["goals"]), *values))
    return rows


def remarks(found: Mapping[str, Any]) -> list[str]:
    """Return remarks: violated constraints, missing values and refused candidates."""
    texts = []
    for which, title in (("before", "before"), ("best", chosen(found))):
        row = found[which]
        texts += [f"{title}: does not keep {text}" for text in row["violated"]]
        for name, share in row["missing"].items():
            texts.append(f"{title}: {name} has no value at {share:.1%} of the poses")
        if row["refused"]:
            texts.append(f"{title}: {row['refused']}")
    if found["refused"]:
        count = found["refused"]
        texts.append(f"{count} candidate{'s' * (count != 1)} rejected as invalid robots")
    return texts


def lines(found: Mapping[str, Any]) -> list[str]:
    """Return the result of `Designed.plain` as lines for a terminal."""
    optimizer = found["optimizer"]
    text = [f"{found['name']}: {optimizer['type']}, seed {optimizer['seed']}", f"{claim(found)[1]}.", ""]
    text += [*table(figures(found), ruled=True), ""]
    text += table([row[:-1] for row in variables(found)], ruled=True)
    if found["front"]:
        head, *rows = members(found)
        some = sorted({round(k * (len(rows) - 1) / (ROWS - 1)) for k in range(ROWS)})  # evenly spaced along the front
        text += ["", *table([head, *(rows[k] for k in some)], ruled=True)]
        text += [f"and {len(rows) - len(some)} more in the folder"] * (len(rows) > len(some))
    notes = remarks(found)
    return [*text, "", *notes] if notes else text


def number(value: float | None) -> str:
    """Return a number for a table; a dash for None."""
    return "-" if value is None else digits(value)
