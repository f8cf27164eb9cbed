"""Mean and spread of a study over its seeds, and the consistency of all runs, against statistics and scipy."""

from __future__ import annotations

import csv
import json
import statistics

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import ROOT
from scipy import stats
from study_cases import write_study

import cdpr
from cdpr.analysis.jobs.cases import Outcome
from cdpr.analysis.study import Results, load_study, run_study
from cdpr.analysis.study.figures import FIGURES, figures
from cdpr.analysis.study.spread import seed_axis
from cdpr.analysis.study.table import make_table
from cdpr.ui.cli import cli
from cdpr.ui.report.figures.study_layout import layouts
from cdpr.ui.report.pages.study import render

SEEDS = "  - {key: simulation.seed, values: [1, 2, 3, 4]}\n"
KP = "  - {key: controller.kp, values: [100, 200]}\n"
ROUND_OFF = 1e-12  # relative, of sums of a few numbers

ERRORS = {100: [1e-3, 4e-3, 2e-3, 7e-3], 200: [5e-3, 5e-3, 1e-3, 3e-3]}
NEES = {100: [9.0, 14.0, 11.0, 20.0], 200: [40.0, 45.0, 38.0, 52.0]}


def results(tmp_path, axes=KP + SEEDS, status=lambda labels: "finished"):
    """A study whose runs have the figures above: nothing is simulated."""
    study = load_study(write_study(tmp_path, "axes:\n" + axes))
    rows = {}
    for case in study.cases:
        kp, i = case.labels.get("controller.kp", 100), case.labels["simulation.seed"] - 1
        nees = {"mean_per_value": 1.0 + 0.1 * i, "inside_95_percent": 0.9, "last": NEES[kp][i], "last_values": 12.0}
        summary = {"position_error_m": {"max": ERRORS[kp][i], "rms": 0.0}, "estimate": {"nees": nees}}
        rows[case.id] = Outcome(case.id, status(case.labels), "", "", summary)
    return Results(study, tmp_path, rows, make_table(study, rows))


def test_mean_deviation_and_band_of_each_combination(tmp_path):
    found = results(tmp_path).spreads
    assert [each.labels for each in found] == [{"controller.kp": 100}, {"controller.kp": 200}]
    for each, values in zip(found, ERRORS.values(), strict=True):
        spread = each.figures["position_error_max_m"]
        assert (each.runs, each.used) == (4, 4)
        assert spread.mean == pytest.approx(statistics.fmean(values), rel=ROUND_OFF)
        assert spread.std == pytest.approx(statistics.stdev(values), rel=ROUND_OFF)
        first, second, third, last = sorted(values)  # with four runs, 2.5 % is at 3 * 0.025 of the way between two
        assert spread.low == pytest.approx(first + 0.075 * (second - first), rel=ROUND_OFF)
        assert spread.high == pytest.approx(last - 0.075 * (last - third), rel=ROUND_OFF)


def test_the_last_squares_of_all_runs_are_judged_together(tmp_path):
    """Of 48 degrees of freedom: the first combination is consistent, the second is not."""
    good, bad = (each.consistent["nees"] for each in results(tmp_path).spreads)
    low, high = stats.chi2.ppf([0.025, 0.975], 48) / 48
    for each, values in ((good, NEES[100]), (bad, NEES[200])):
        assert each == pytest.approx((sum(values) / 48, low, high), rel=1e-10)
    assert good.low < good.mean < good.high < bad.mean


def test_runs_without_figures_are_counted_but_not_averaged(tmp_path):
    found = results(tmp_path, status=lambda labels: "diverged" if labels["simulation.seed"] == 4 else "finished")
    first = found.spreads[0]
    assert (first.runs, first.used) == (4, 3)
    assert first.figures["position_error_max_m"].mean == pytest.approx(7e-3 / 3, rel=ROUND_OFF)
    assert "3 of 4" in render(found)


def test_a_single_usable_run_has_no_deviation(tmp_path):
    found = results(tmp_path, status=lambda labels: "finished" if labels["simulation.seed"] == 1 else "diverged")
    assert found.spreads[0].figures["position_error_max_m"].std is None
    assert found.spread.records()[0]["position_error_max_m_std"] is None


@pytest.mark.parametrize(
    ("axes", "label"),
    [
        (SEEDS, "simulation.seed"),
        ("  - {name: run, key: simulation.seed, range: {start: 1, stop: 3, step: 1}}\n" + KP, "run"),
        (KP, None),
        ("  - {key: simulation.seed, values: [1]}\n" + KP, None),
        (
            "  - zip:\n      - {key: simulation.seed, values: [1, 2]}\n      - {key: controller.kd, values: [1, 2]}\n",
            None,
        ),
    ],
)
def test_only_an_axis_of_seeds_alone_is_pooled(tmp_path, axes, label):
    study = load_study(write_study(tmp_path, "axes:\n" + axes))
    assert seed_axis(study.blocks[0]) == label


def test_seeds_have_no_place_in_figures_beside_other_axes(tmp_path):
    (layout,) = layouts(results(tmp_path).study.blocks[0])
    assert (layout.x, layout.line, layout.panels, layout.seeds) == ("controller.kp", None, (), True)
    (alone,) = layouts(results(tmp_path, SEEDS).study.blocks[0])
    assert (alone.x, alone.seeds) == ("simulation.seed", False)


def test_the_page_shows_them(tmp_path):
    page = render(results(tmp_path))
    assert "<h2>Mean and spread over the seeds</h2>" in page
    deviation = 1e3 * statistics.stdev(ERRORS[100])
    assert f"3.5 ± {deviation:.2g}<br><small>" in page
    assert "<strong>3.65</strong>" in page, "175 / 48, outside its band"
    assert "<strong>1.12</strong>" not in page
    assert "Mean and spread" not in render(results_without_seeds(tmp_path))


def results_without_seeds(tmp_path):
    study = load_study(write_study(tmp_path, "axes:\n" + KP))
    rows = {case.id: Outcome(case.id, "finished", "", "", {"samples": 1}) for case in study.cases}
    return Results(study, tmp_path, rows, make_table(study, rows))


def test_a_study_of_an_estimator(tmp_path):
    """The figures of the table are those of the runs, which the functions of the package compute alone."""
    scenario = ROOT / "scenarios" / "encoders_only.yaml"
    (tmp_path / "mc.yaml").write_text(
        "scenario: encoders_only\nchanges: {simulation.duration: 0.05}\naxes:\n"
        "  - {key: estimator.force_noise, values: [0.1, 1.0]}\n  - {key: simulation.seed, values: [3, 5]}\n"
    )
    done = CliRunner().invoke(cli, ["study", str(tmp_path / "mc.yaml"), "--out", str(tmp_path / "out"), "--jobs", "1"])
    assert done.exit_code == 0, done.output
    runs = [
        cdpr.simulate(
            scenario, overrides={"simulation": {"duration": 0.05, "seed": seed}, "estimator.force_noise": 1.0}
        )
        for seed in (3, 5)
    ]
    with (tmp_path / "out" / "spread.csv").open(newline="") as file:
        row = list(csv.DictReader(file))[1]
    errors = [np.linalg.norm(run.position - run["estimated_position"], axis=1).max() for run in runs]
    assert float(row["estimate_position_error_max_m_mean"]) == pytest.approx(statistics.fmean(errors), rel=1e-9)
    assert float(row["estimate_nees_of_runs_mean"]) == pytest.approx(
        sum(run["nees"][-1] for run in runs) / 24, rel=1e-9
    )
    assert float(row["estimate_nis_of_runs_high"]) == pytest.approx(stats.chi2.ppf(0.975, 16) / 16, rel=1e-9)
    assert "mean ± standard deviation over the seeds, and the 95 % band of a consistent estimator" in done.output
    again = CliRunner().invoke(
        cli, ["study", str(tmp_path / "mc.yaml"), "--out", str(tmp_path / "out"), "--json", "--no-report"]
    )
    assert json.loads(again.stdout)["spread"][1]["runs"] == 2
    study = run_study(load_study(tmp_path / "mc.yaml"), tmp_path / "other")
    assert (tmp_path / "other" / "spread.csv").read_bytes() == (tmp_path / "out" / "spread.csv").read_bytes()
    assert not {name for name in study.table.figures if name not in FIGURES}, "no axis may have such a name"
    assert all(isinstance(cell, bool | int | float | None) for cell in figures(runs[0].summary()).values())
