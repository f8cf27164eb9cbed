"""Text parts of a run's report as HTML: status, figures, events and cables. Texts of scenarios are escaped."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

import numpy as np

from cdpr.log.run import CLEARANCE, Run
from cdpr.log.summary import not_judged
from cdpr.mechanics.contacts import passing
from cdpr.model.robot import Array
from cdpr.ui.report.pages.page import banner, swatch, table
from cdpr.ui.report.plots.histories import histories
from cdpr.ui.report.style import SHADES, cable_looks
from cdpr.ui.report.style import events as in_order
from cdpr.ui.report.text.aligned import number, unit_for
from cdpr.ui.report.text.least import least_of
from cdpr.ui.report.text.reservations import fallback, lost, reservations

MOST_EVENTS = 200

BANNERS = {
    "finished": ("good", "Finished"),
    "ended": ("good", "Ended by the plant"),
    "diverged": ("bad", "Diverged"),
    "infeasible": ("bad", "Stopped as infeasible"),
    "unanswered": ("bad", "Stopped: no valid answer of the solver"),
    "beyond_limits": ("bad", "Stopped: limit violation of a cable"),
    "touched": ("bad", "Stopped: clearance of cables too small"),
    "interrupted": ("warn", "Interrupted"),
    "failed": ("bad", "Failed"),
    "running": ("warn", "Did not end: the process still runs or was killed"),
}

# Errors of the estimate: title, key of its figures and unit.
ESTIMATE = (
    ("Error of the estimated position", "position_error_m", "m"),
    ("Error of the estimated attitude", "orientation_error_rad", "rad"),
    ("Error of the estimated velocity", "velocity_error_m_s", "m/s"),
    ("Error of the estimated angular velocity", "angular_velocity_error_rad_s", "rad/s"),
)


def ending(run: Run, happened: str = "") -> str:
    """Return the banner: status of the run, its message, and `happened`, a sentence on the run."""
    mood, text = BANNERS.get(run.status, ("warn", escape(run.status)))
    doubts = [*reservations(run), *fallback(run), *lost(run)]
    if mood == "good" and doubts:
        mood, text = "warn", escape(f"{text}, but {'; '.join(doubts)}")
    causes = "; ".join(filter(None, (run.message, happened)))
    message = f": {escape(causes)}" if causes else ""
    return banner(mood, text, message)


def summary(run: Run, least: Mapping[str, Mapping[str, Any]], touch: str | None = None) -> str:
    """Return the figures of `Run.summary` and `least` in readable units; the last row has wall-clock times."""
    figures = run.summary()
    out = "<h2>Summary</h2>\n"
    if not figures["samples"]:
        return out + "<p>The run has no sample.</p>"
    errors = []
    for name, base, key in (
        ("Position error", "m", "position_error_m"),
        ("Orientation error", "rad", "orientation_error_rad"),
    ):
        scale, unit = unit_for(figures[key].values(), base)
        errors.append((f"{name} ({unit})", *(number(scale * figures[key][part]) for part in ("max", "rms", "final"))))
    out += table(errors, ("Norm of the error", "largest", "rms", "final")) + "\n"
    tension, energy = figures["tension_N"], figures["energy_J"]
    kind = "nominal tension" if run.header.takes_lengths else "tension"
    rows = [
        (f"Smallest {kind} (N)", number(tension["min"])),
        (f"Largest {kind} (N)", number(tension["max"])),
        *_true(figures),
        (f"Largest change of a {kind} from one sample to the next (N)", number(tension["largest_step"])),
        ("Smallest margin to a limit (N)", number(figures["margin_min_N"])),
        ("Largest residual of the distribution (N)", number(figures["residual_max_N"])),
        *([("Smallest clearance (m)", _clearance(figures))] if "clearance_min_m" in figures else []),
        *([("Contact of cables", escape(touch))] if touch else []),
        *((escape(title.capitalize()), escape(text)) for title, text in least_of(least)),
        *([] if least else [("Smallest capacity margin and stiffness", "not computed: use cdpr run --statics")]),
        ("Steps without valid tensions", _bad_steps(run)),
        (
            "Work of cables; of external wrenches (J)",
            "; ".join(number(energy[f"{by}_work"]) for by in ("cable", "external")),
        ),
        *((f"Work of {escape(name)} (J)", number(energy[column])) for name, column in run.header.further_works.items()),
        *_estimate(figures),
        ("Unexplained energy; total exchange (J)", _balance(figures)),
        ("Samples; simulated time", f"{figures['samples']}; {figures['simulated_s']:.6g} s"),
        *([("Samples in the log, and in the figures", _logged(run))] if run.header.log_every > 1 else []),
    ]
    if run.timings:
        times = [f"{name.removesuffix('_s')} {number(value)} s" for name, value in run.timings.items()]
        if "real_time_factor" in figures:
            times.append(f"{number(figures['real_time_factor'])} times real time")
        rows.append(("Wall clock", escape(", ".join(times))))
    return out + table(rows)


def _true(figures: dict[str, Any]) -> list[tuple[str, str]]:
    """Return rows on true tensions, if these differ from the commands, and on slack cables."""
    rows = []
    if "cable_tension_N" in figures:
        felt = figures["cable_tension_N"]
        rows.append(("Smallest; largest tension in the cables (N)", f"{number(felt['min'])}; {number(felt['max'])}"))
    if figures.get("slack_samples"):
        count = len(figures["slack_intervals"])
        rows.append(("Samples with slack cables; intervals", f"{figures['slack_samples']}; {count}"))
    if "lost_steps" in figures:
        rows.append(("Lost full steps of steppers", str(figures["lost_steps"])))
    if "motor_current_A" in figures:
        current, voltage, energy = (
            figures[key] for key in ("motor_current_A", "motor_voltage_V", "electrical_energy_J")
        )
        rows.append(("Largest motor current; largest rms (A)", f"{number(current['max'])}; {number(current['rms'])}"))
        rows.append(("Largest motor voltage (V)", number(voltage["max"])))
        rows.append(
            ("Electrical energy used; fed back (J)", f"{number(energy['used'])}; {number(energy['regenerated'])}")
        )
    return rows


def _estimate(figures: dict[str, Any]) -> list[tuple[str, str]]:
    """Return rows on the errors of the estimate, and on its consistency; none without an estimator."""
    found = figures.get("estimate")
    if found is None:
        return []
    rows = [
        (f"{title}: largest; rms ({unit})", f"{number(found[key]['max'])}; {number(found[key]['rms'])}")
        for title, key, unit in ESTIMATE
    ]
    titles = {"nis": "NIS of the innovation", "nees": "NEES of the estimate"}
    for key, title in titles.items():
        if each := found.get(key):
            share = f"{100.0 * each['inside_95_percent']:.3g} %"
            rows.append((f"{title}, mean per value (1 if consistent)", number(each["mean_per_value"])))
            rows.append((f"{title}, samples within the 95 % band", share))
    return rows


def _clearance(figures: dict[str, Any]) -> str:
    gap, at, by = (figures[key] for key in CLEARANCE)
    if through := passing(by, gap):
        return f"none: {escape(through)} at {at:.6g} s"
    return f"{number(gap)} at {at:.6g} s, {escape(by)}"


def _bad_steps(run: Run) -> str:
    if run.header.log_every > 1:  # solver statuses are known only for logged steps
        figures = run.summary()
        return str(figures["infeasible_steps"] + figures["unanswered_steps"] or "none")
    found = histories(run).status
    counts = [(int(np.count_nonzero(found == status)), name) for status, name in SHADES.items()]
    return ", ".join(f"{count} {name}" for count, name in counts if count) or "none"


def _logged(run: Run) -> str:
    return f"{len(run.rows)}, one each {run.header.log_step:g} s; these figures count all"


def _balance(figures: dict[str, Any]) -> str:
    energy, why = figures["energy_J"], not_judged(figures)
    text = f"{number(energy['residual_max'])}; {number(energy['turned_over'])}"
    verdict = f"not judged, {escape(why)}" if why else "out of balance"
    return text if energy["balanced"] else f"<strong>{text}: {verdict}</strong>"


def provenance(run: Run) -> str:
    """Return the tables of settings, versions and unused scenario keys."""
    head = run.header
    rows = [
        ("Scenario", escape(head.scenario)),
        ("Robot", f"{escape(head.robot)}; {len(head.cables)} cables, platform of {head.mass:g} kg"),
        ("Backend", escape(head.backend)),
        ("Controller", escape(head.controller)),
        *([("Estimator", escape(head.estimator))] if head.estimator else []),
        ("Tension solver", escape(head.solver)),
        *([("Nominal model", escape(head.believed))] if head.believed else []),
        *([("Controlled directions", escape(", ".join(head.controlled)))] if head.controlled else []),
        ("Control step; physics step", f"{1e3 * head.control_step:g} ms; {1e3 * head.physics_step:g} ms"),
        ("Gravity (m/s²)", escape(", ".join(f"{g:g}" for g in head.gravity))),
        ("Seed", str(head.seed)),
        ("Versions", escape(", ".join(f"{name} {version}" for name, version in head.versions.items()))),
        ("Keys not used", ", ".join(f"<code>{escape(key)}</code>" for key in run.unused) or "none"),
    ]
    return "<h2>Run</h2>\n" + table(rows)


def events(run: Run) -> str:
    """Return the numbered list of events."""
    out = "<h2>Events</h2>\n"
    if not run.events:
        return out + "<p>None.</p>"
    rows = []
    for i, event in enumerate(in_order(run)[:MOST_EVENTS], 1):
        until = event.when.removeprefix(f"{event.time:.6g}")
        at = f'<button type="button" class="at" data-time="{event.time:.9g}">{event.time:.6g}</button>'
        rows.append((str(i), f"{at}{until}", escape(event.kind), escape(event.text)))
    out += table(rows, ("No.", "Time (s)", "Kind", "What happened"), numeric=False)
    if len(run.events) > MOST_EVENTS:
        out += f"\n<p>And {len(run.events) - MOST_EVENTS} more in the log.</p>"
    return out + "\n<p>Dotted lines mark them in the figures; steps without valid tensions are shaded.</p>"


def cables(run: Run) -> str:
    """Return the limits and the extreme values of true tension and length of each cable."""
    head = run.header
    rows = []
    tension, length = (histories(run)[what].values for what in ("cable_tension", "length"))
    for i, (name, look) in enumerate(zip(head.cables, cable_looks(head.cables), strict=True)):
        limits = (head.tension_min[i], head.tension_max[i])
        rows.append((swatch(look) + escape(name), *map(number, (*limits, *_ends(tension[:, i]), *_ends(length[:, i])))))
    titles = ("Cable", "t_min (N)", "t_max (N)", "lowest (N)", "highest (N)", "shortest (m)", "longest (m)")
    return f"<h2>Cables</h2>\n{table(rows, titles)}"


def scenario(run: Run) -> str:
    """Return the resolved scenario, folded."""
    return (
        "<h2>Scenario</h2>\n<details><summary>The resolved scenario</summary>\n"
        f"<pre>{escape(run.header.scenario_yaml)}</pre></details>"
    )


def _ends(values: Array) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if len(finite) else (np.nan, np.nan)
