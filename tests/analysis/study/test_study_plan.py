"""Study files: cases, axes, identities, seeds, and messages about errors."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from conftest import ROOT
from study_cases import write_study

from cdpr.analysis.study import load_study
from cdpr.base.errors import PluginError, ScenarioError
from cdpr.scenario import load_scenario


def places(tmp_path, axes):
    """Return the values of each case on each axis."""
    return [case.labels for case in load_study(write_study(tmp_path, "axes:\n" + axes)).cases]


def column(tmp_path, axis):
    """The places on the only axis."""
    return [next(iter(labels.values())) for labels in places(tmp_path, f"  - {axis}")]


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("values: [5, 2.5]", [5, 2.5]),
        ("range: {start: 1, stop: 7, step: 3}", [1, 4, 7]),
        ("range: {start: 0.1, stop: 0.35, step: 0.1}", [0.1, 0.2, 0.3]),
        ("range: {start: 3, stop: 1, step: -1}", [3, 2, 1]),
        ("linspace: {start: 1, stop: 2, count: 5}", [1, 1.25, 1.5, 1.75, 2]),
        ("logspace: {start: 1, stop: 1000, count: 4}", [1, 10, 100, 1000]),
    ],
)
def test_sources(tmp_path, source, expected):
    assert column(tmp_path, f"{{key: controller.kp, {source}}}") == expected


def test_steps_equal_the_written_values(tmp_path):
    """0.1 + 2 * 0.1 is not 0.3 in floating point."""
    found = column(tmp_path, "{key: controller.kp, range: {start: 0.1, stop: 1.0, step: 0.1}}")
    assert found == [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]


@pytest.mark.parametrize(
    ("kind", "distribution"),
    [
        ("uniform: [2, 6]", lambda x: (x - 2) / 4),
        ("log_uniform: [1, 100]", lambda x: math.log10(x) / 2),
        ("normal: [100, 3]", lambda x: 0.5 * math.erfc(-(x - 100) / 3 / math.sqrt(2))),
    ],
)
def test_random_values_have_their_distribution(tmp_path, kind, distribution):
    """Kolmogorov and Smirnov: 100 sound values stay below 1.95 / sqrt(100) but once in a thousand seeds."""
    found = column(tmp_path, f"{{key: controller.kp, random: {{{kind}, count: 100}}}}")
    shares = np.sort([distribution(x) for x in found])
    assert np.abs(shares - (np.arange(100) + 0.5) / 100).max() < 1.95 / 10


def test_random_values_follow_the_seed_and_the_axis(tmp_path):
    axis = "{{key: {}, random: {{uniform: [1, 2], count: {}}}}}"
    four = column(tmp_path, axis.format("controller.kp", 4))
    assert column(tmp_path, axis.format("controller.kp", 6))[:4] == four
    assert not set(column(tmp_path, axis.format("controller.kd", 4))) & set(four)
    other = load_study(write_study(tmp_path, f"seed: 1\naxes:\n  - {axis.format('controller.kp', 4)}"))
    assert not {case.labels["controller.kp"] for case in other.cases} & set(four)
    own = axis.format("controller.kp", 4).replace("count", "seed: 3, count")
    again = load_study(write_study(tmp_path, f"seed: 1\naxes:\n  - {own}"))
    assert [case.labels["controller.kp"] for case in again.cases] == column(tmp_path, own)


def test_the_grid_has_the_last_axis_fastest(tmp_path):
    axes = "  - {key: controller.kp, values: [1, 2]}\n  - {key: controller.kd, values: [3, 4]}"
    assert [tuple(labels.values()) for labels in places(tmp_path, axes)] == [(1, 3), (1, 4), (2, 3), (2, 4)]


def test_zip_names_and_several_keys(tmp_path):
    axes = """
  - zip:
      - {key: controller.kp, values: [1, 2]}
      - {name: same, key: "initial.position[0]", values: [0.1, 0.1]}  # may stand still
      - {name: load, keys: [robot.platform.mass, controller.kd], values: [30, 40]}
  - name: place
    points:
      low: {"initial.position[2]": 1.0}
      high: {"initial.position[2]": 1.5, solver.type: lp}
"""
    cases = load_study(write_study(tmp_path, "axes:" + axes)).cases
    zipped = [(1, 0.1, 30), (2, 0.1, 40)]
    expected = [(*values, place) for values in zipped for place in ("low", "high")]
    assert [tuple(case.labels.values()) for case in cases] == expected
    last = load_scenario(cases[-1].scenario, text=cases[-1].text)
    assert last.robot.platform.mass == 40.0
    assert last.controller_options.kd == 40.0
    assert last.initial.position == (0.1, 0.0, 1.5)
    assert last.solver.type == "lp"
    assert last.simulation.duration == 0.1


def test_blocks_share_axes_and_change_more(tmp_path):
    (tmp_path / "thesis.yaml").write_text((ROOT / "scenarios" / "thesis.yaml").read_text())
    (tmp_path / "robots").symlink_to(ROOT / "scenarios" / "robots")
    text = """
axes:
  - {key: simulation.backend, values: [reference, mujoco]}
blocks:
  - name: gains
    axes: [{key: controller.kp, values: [10, 20]}]
  - name: other
    scenario: thesis.yaml
    changes: {simulation.duration: 0.2}
"""
    study = load_study(write_study(tmp_path, text))
    found = [(case.block, tuple(case.labels.values())) for case in study.cases]
    gains = [("gains", (backend, kp)) for backend in ("reference", "mujoco") for kp in (10, 20)]
    assert found == [*gains, ("other", ("reference",)), ("other", ("mujoco",))]
    durations = [load_scenario(case.scenario, text=case.text).simulation.duration for case in study.cases]
    assert durations == [0.1] * 4 + [0.2] * 2


def test_a_type_is_set_before_its_options(tmp_path):
    """Choosing a plugin takes the options of another one out; those of the case must stay."""
    axes = "  - {key: controller.kp, values: [7]}\n  - {key: controller.type, values: [pid, static]}"
    for case in load_study(write_study(tmp_path, "axes:\n" + axes)).cases:
        assert load_scenario(case.scenario, text=case.text).controller_options.kp == 7.0


def test_identities_are_stable_and_distinguish_cases(tmp_path):
    two = "axes:\n  - {key: controller.kp, values: [1, 2]}"
    first = load_study(write_study(tmp_path, two))
    more = load_study(write_study(tmp_path, two.replace("[1, 2]", "[2, 3, 1]")))
    ids = {case.labels["controller.kp"]: case.id for case in more.cases}
    assert len(set(ids.values())) == 3
    assert {case.labels["controller.kp"]: case.id for case in first.cases} == {key: ids[key] for key in (1, 2)}
    assert first.digest != more.digest
    heavier = write_study(tmp_path, two)
    heavier.write_text(heavier.read_text().replace("changes: {", "changes: {robot.platform.mass: 1, "))
    assert not {case.id for case in load_study(heavier).cases} & set(ids.values())


def test_names_are_not_part_of_an_identity(tmp_path):
    """Else another heading would change every seed, and so every result."""

    def ids(text):
        return [case.id for case in load_study(write_study(tmp_path, text)).cases]

    plain = ids("axes:\n  - {key: controller.kp, values: [1, 2]}")
    assert ids("axes:\n  - {name: gain, key: controller.kp, values: [1, 2]}") == plain
    assert ids("axes:\n  - {name: gain, points: {low: {controller.kp: 1}, high: {controller.kp: 2}}}") == plain
    axes = "axes: [{key: controller.kp, values: [1, 2]}]"
    twice = ids(f"blocks:\n  - {{name: a, {axes}}}\n  - {{name: b, {axes}}}")
    assert twice[:2] == plain
    assert len(set(twice)) == 4


def test_every_case_has_a_seed_of_its_own(tmp_path):
    def seeds(text):
        cases = load_study(write_study(tmp_path, text)).cases
        return [load_scenario(case.scenario, text=case.text).simulation.seed for case in cases]

    axes = "axes:\n  - {key: controller.kp, values: [1, 2, 3]}"
    found = seeds(axes)
    assert len(set(found)) == 3
    assert seeds(axes) == found
    assert not set(seeds("seed: 1\n" + axes)) & set(found)
    assert seeds(axes + "\n  - {key: simulation.seed, values: [5]}") == [5, 5, 5]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("axes: [{key: controller.kp, values: [1], range: {start: 1, stop: 2, step: 1}}]", "got values and range"),
        ("axes: [{key: controller.kp}]", "got none"),
        ("axes: [{values: [1]}]", "expected one of key and keys"),
        ("axes: [{name: a, points: {b: 3}}]", "axes[0].points.b: expected a mapping, got 3"),
        ("axes: [{points: {b: {c: 3}}}]", "an axis of points needs a name"),
        ("axes: [{key: controller.kp, values: []}]", "axes[0].values: expected 1 or more items, got 0"),
        ("axes: [{key: controller.kp, values: [1, 2, 1]}]", ":3:44: axes[0].values[2]: the axis contains 1 twice"),
        ("axes: [{key: controller.kp, valeus: [1]}]", "unknown key 'valeus': did you mean 'values'?"),
        ("axes: [{key: controller.kp, linspace: {start: 1, stop: 2, count: 1}}]", "count: must be at least 2, got 1"),
        ("axes: [{key: controller.kp, logspace: {start: 0, stop: 2, count: 3}}]", "greater than 0, got 0"),
        ("axes: [{key: controller.kp, range: {start: 1, stop: 2, step: -1}}]", "do not lead from 1 to 2"),
        ("axes: [{key: controller.kp, random: {normal: [0, 0], count: 3}}]", "deviation must be greater than 0"),
        ("axes: [{key: controller.kp, random: {uniform: [2, 1], count: 3}}]", "must be below the highest, 1"),
        ("axes: [{key: controller.kp, values: [.nan]}]", "controller.kp: expected a finite number"),
        ("axes: [{key: controller.kp, values: [null]}]", "axes[0].values[0]: no value is given"),
        ("axes: [{key: 'a[', values: [1]}]", "expected a key such as simulation.duration"),
        ("axes: [{key: controller.kp, values: [1]}, {key: controller.kp, values: [2]}]", "two axes set controller.kp"),
        ("axes: [{name: status, key: controller.kp, values: [1]}]", "cannot be named status"),
        ("axes: [{name: samples, key: simulation.duration, values: [1]}]", "cannot be named samples"),
        ("axes: [{key: controller.kp, range: {start: 0.0, stop: 1.0, step: 1.0e-320}}]", "at most 100000"),
        ("axes: [{key: controller.kp, range: {start: 1, stop: 1" + 100 * "0" + ", step: 1}}]", "range.stop: must lie"),
        ("axes: [{key: controller.kp, logspace: {start: 1.0e-320, stop: 1, count: 3}}]", "too far apart"),
        ("axes: [{key: controller.kp, random: {log_uniform: [1.0e-320, 1], count: 3}}]", "too far apart"),
        (
            "axes: [{zip: [{key: a, values: [1]}, {key: b, values: [1, 2]}]}]",
            "expected axes of equal length, got 1, 2 values",
        ),
        (
            "axes: [{zip: [{key: a, values: [1, 1]}, {key: b, values: [2, 2]}]}]",
            "zip: the axis contains 1, 2 twice",
        ),
        ("blocks: [{name: a}, {name: a}]", "blocks[1].name: another block has this name"),
        ("blocks: [{name: a, scenario: nowhere.yaml}]", "study.yaml:3:30: blocks[0].scenario: there is no file"),
        ("axes: [{key: controller.kp, range: {start: 1, stop: 1000000, step: 1}}]", "at most 100000"),
        (
            "axes: [{key: controller.kp, range: {start: 1, stop: 1000, step: 1}}, "
            "{key: controller.kd, range: {start: 1, stop: 1000, step: 1}}]",
            "1000000 cases; at most 100000",
        ),
    ],
)
def test_mistakes_in_the_file(tmp_path, text, said):
    path = write_study(tmp_path, text)
    with pytest.raises(ScenarioError) as error:
        load_study(path)
    assert said in str(error.value)
    assert str(tmp_path) in str(error.value)


def test_mistakes_in_cases_are_reported_once_with_the_first_case(tmp_path):
    text = """axes:
  - {key: controller.kd, values: [1, 2, 3]}
  - {key: controller.kp, values: [1, -1]}
  - {key: simulation.durtion, values: [1]}
"""
    path = write_study(tmp_path, text)
    with pytest.raises(ScenarioError) as error:
        load_study(path)
    negative, unknown = sorted(error.value.problems)
    assert negative.startswith(f"{path}:5:38: controller.kp: ")
    assert negative.endswith("(case 2 and 2 more: controller.kd 1, controller.kp -1, simulation.durtion 1)")
    assert "did you mean 'duration'?" in unknown
    assert "(case 1 and 5 more: " in unknown


def test_a_missing_plugin_is_reported_before_anything_runs(tmp_path):
    path = write_study(tmp_path, "axes: [{key: simulation.backend, values: [reference, mujocco]}]")
    with pytest.raises(PluginError, match=r"did you mean 'mujoco'.*\(case 2: simulation.backend 'mujocco'\)"):
        load_study(path)


def test_other_kinds_of_files(tmp_path):
    with pytest.raises(ScenarioError, match="this is a scenario file; use it in a study by 'scenario: FILE'"):
        load_study(ROOT / "scenarios" / "caroca.yaml")
    path = write_study(tmp_path, "axes: [{key: controller.kp, values: [1]}]")
    with pytest.raises(ScenarioError, match="this is a study file; cdpr study runs it"):
        load_scenario(path)


# Those of the thesis, of 640 cases, are loaded by the tests of its page.
SHIPPED = [
    path
    for path in sorted((ROOT / "scenarios" / "studies").glob("*.yaml"))
    if not path.stem.startswith(("thesis", "design_"))
]


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_studies_are_valid(path):
    assert len(load_study(path).cases) > 1


def test_the_example_of_the_reference_page_is_valid(tmp_path):
    (text,) = re.findall(
        r"^```yaml\n(.*?)^```$", (ROOT / "docs" / "study_files.md").read_text(), re.DOTALL | re.MULTILINE
    )
    (tmp_path / "scenarios").symlink_to(ROOT / "scenarios")
    path = tmp_path / "study.yaml"
    path.write_text(text.replace("../caroca.yaml", "scenarios/caroca.yaml"))
    assert len(load_study(path).cases) == 2 * 2 * 2 * (4 + 3)
