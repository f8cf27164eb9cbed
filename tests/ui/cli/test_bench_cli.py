"""`cdpr bench solvers`: what it prints and writes."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from unittest import mock

import bench_cases as cases
import pytest
from bench_cases import plugin, plugins
from click.testing import CliRunner
from conftest import ROOT
from html_page import NAMESPACES, Page

from cdpr.analysis import bench
from cdpr.analysis.bench import adversaries, benchmark, measures
from cdpr.base.errors import OutputError, PluginError, ScenarioError
from cdpr.plugins import PluginInfo
from cdpr.scenario.examples import resolve
from cdpr.ui.cli import bench as command_module
from cdpr.ui.cli.bench import ROBOTS, command
from cdpr.ui.report.pages.bench import write_bench
from cdpr.ui.report.text.bench import COLUMNS, digits, percent, power

FOLDER = ROOT / "scenarios" / "robots"
POINT = str(FOLDER / "planar_point_mass.yaml")
ODD = 'a<b> & "c"'


def solvers(*arguments, code=0):
    few = [] if "--adversaries" in arguments else ["--adversaries", "0"]
    result = CliRunner().invoke(command, ["solvers", *map(str, arguments), *few], catch_exceptions=False)
    assert result.exit_code == code, result.output
    return result


def printed(figures):
    with CliRunner().isolation() as (out, *_):
        command_module._print(figures)
        return out.getvalue().decode()


@pytest.fixture(scope="module", autouse=True)
def _short_paths():
    """Enough answers of a path to show that it is used; test_bench_measures.py tests the result."""
    with mock.patch.object(measures, "STEPS", 30):
        yield


@pytest.fixture(scope="module")
def zoo(_short_paths):
    """Figures with every kind of row, under names that HTML could take amiss."""
    rows = [
        plugin(cases.MinimumNorm, ODD, objective="min_norm"),
        plugin(cases.Jumping, "jumping"),
        plugin(cases.Raising, "raising"),
        plugin(cases.Unsupporting, "unsupporting"),
        PluginInfo("absent", "absent:Absent", "", requires=("no_such_package",), extra="cdpr[none]"),
    ]
    return bench.run([cases.wall(), cases.carriage()], None, 60, plugins=plugins(*rows))


def test_table():
    lines = solvers(POINT, "--poses", "30", "--solvers", "qp,pseudo_inverse").stdout.splitlines()
    assert re.match(r"planar_point_mass: 3 cables, 2 degrees of freedom, redundancy 1; \d+ feasible", lines[0])
    (qp,) = (line.split() for line in lines if line.startswith("qp "))
    (pinv,) = (line.split() for line in lines if line.startswith("pseudo_inverse "))
    assert qp[1:5] == ["100", "%", "0", "0"]
    assert pinv[-1] == "30"
    assert max(map(len, lines)) <= 120
    assert not any("failed" in line or "skipped" in line for line in lines)


@pytest.mark.slow
def test_problems_made_to_mislead_have_tables_of_their_own(tmp_path):
    """Also on the page, which states the band; a message comes before the work."""
    result = solvers(POINT, "--poses", "5", "--solvers", "qp", "--adversaries", "9", "--out", tmp_path)
    assert result.stdout.count("adversaries, ") == len(adversaries.SIZES)
    assert "0%" in result.stderr
    words = Page((tmp_path / "bench.html").read_text()).words
    assert "The band: a feasible problem counts where all limits could be narrowed by 1e-09" in words
    assert max(map(len, result.stdout.splitlines()[:-1])) <= 120


def test_names_and_columns_fit_into_the_table():
    """The longest figures there may be, and the longest name of a solver of ours."""
    row = bench.run([cases.wall()], ["qp"], 50)
    result = row["robots"][0]["results"][0]
    result["solver"] = "improved_closed_form"
    result |= {"coverage": 0.999, "misclassified": 1000, "invalid_ok": 1000, "worst_residual": 1e-16, "gap": 1e-12}
    result |= {"worst_violation_N": 123456.0, "jumps": {"paths": 40, "with_jump": 28, "largest_N": 1234.0}}
    result["time"] |= {"median_us": 1234.0, "p99_us": 12345.0, "median_pinv": 0.123}
    lines = printed(row).splitlines()
    assert any(line.startswith("improved_closed_form ") and "28/40 (1234 N)" in line for line in lines)
    assert max(map(len, lines)) <= 120


@pytest.mark.slow
def test_json_holds_what_run_returns():
    said = json.loads(solvers(POINT, "--poses", "20", "--seed", "5", "--solvers", "qp", "--json").stdout)
    (row,) = said["robots"][0]["results"]
    (same,) = bench.run([cases_robot()], ["qp"], 20, 5)["robots"][0]["results"]
    assert set(row.pop("time")) == set(same.pop("time"))
    assert row == same
    assert (said["poses"], said["seed"], said["interrupted"]) == (20, 5, False)
    assert {"cdpr", "python", "numpy", "daqp"} <= set(said["versions"])


def cases_robot():
    from cdpr.scenario import load_robot

    return load_robot(POINT)


def test_files(tmp_path):
    out = tmp_path / "new" / "folder"
    result = solvers(POINT, FOLDER / "carriage.yaml", "--poses", "20", "--solvers", "qp", "--out", out)
    assert result.stdout.splitlines()[-1] == str(out / "bench.html")
    names = {"bench.json", "bench.html", "1_planar_point_mass.svg", "2_carriage.svg"}
    assert {path.name for path in out.iterdir()} == names
    assert json.loads((out / "bench.json").read_text())["robots"][1]["name"] == "carriage"
    assert str(ROOT) not in (out / "bench.json").read_text() + (out / "bench.html").read_text()


@pytest.mark.slow
def test_page(zoo, tmp_path):
    write_bench(zoo, tmp_path)
    text = (tmp_path / "bench.html").read_text()
    page = Page(text)
    assert not {"script", "link", "iframe", "img"} & set(page.tags)
    assert all(link.startswith("#") for link in page.links)
    assert {link[1:] for link in page.links if not link.startswith("#m")} <= set(page.ids)
    assert len(page.ids) == len(set(page.ids))
    assert set(re.findall(r"https?://[^\s\"'<)]+", text)) <= set(NAMESPACES)
    assert "url(http" not in text
    assert ODD in page.words
    assert "ZeroDivisionError: division by zero at problem 5" in page.words
    assert "absent was not tested: solver 'absent' needs no_such_package" in page.words
    assert all(title in page.words for title in COLUMNS)


@pytest.mark.slow
def test_figures_are_pictures_of_their_own(zoo, tmp_path):
    write_bench(zoo, tmp_path)
    for name in ("1_wall.svg", "2_carriage.svg"):
        words = "".join(ElementTree.parse(tmp_path / name).getroot().itertext())
        assert all(word in words for word in (ODD, "jumping", "failed", "unsupported", "coverage", "microseconds"))


def test_rows_with_a_reason(zoo):
    text = printed(zoo)
    assert "raising failed: raised ZeroDivisionError: division by zero at problem 5" in text
    assert "skipped: solver 'absent' needs no_such_package, which is not installed: pip install 'cdpr[none]'" in text
    assert re.search(r"^unsupporting +-( +-)+", text, re.MULTILINE)
    assert ODD in text


def test_interrupted_runs_are_written_and_reported(monkeypatch, tmp_path):
    found = plugins(plugin(cases.MinimumNorm, "a"), plugin(cases.Interrupted, "b"))
    monkeypatch.setattr(benchmark, "registry", lambda: found)
    result = solvers(POINT, "--poses", "20", "--out", tmp_path, code=130)
    assert re.search(r"^a +100 %", result.stdout, re.MULTILINE)
    assert "interrupted: incomplete measurement" in result.stderr
    assert "Interrupted" in Page((tmp_path / "bench.html").read_text()).words


def test_wrong_arguments(tmp_path, monkeypatch):
    with pytest.raises(PluginError, match="did you mean 'qp'"):
        solvers(POINT, "--solvers", "qpp")
    with pytest.raises(ScenarioError, match="there is no file"):
        solvers(tmp_path / "nothing.yaml")
    assert "--poses" in solvers(POINT, "--poses", "0", code=2).stderr
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        solvers(POINT, "--poses", "2", "--solvers", "qp", "--out", tmp_path / "file")


def test_default_robots_are_there():
    assert all((FOLDER / f"{name}.yaml").is_file() for name in ROBOTS)
    assert [resolve(name, "robot") for name in ROBOTS] == [str(FOLDER / f"{name}.yaml") for name in ROBOTS]


@pytest.mark.slow
def test_missing_libraries_have_a_remedy():
    program = "import sys; sys.modules['daqp'] = None; import cdpr.ui.cli; cdpr.ui.cli.main()"
    done = subprocess.run(
        [sys.executable, "-c", program, "bench", "solvers", POINT], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 3
    assert done.stderr.count("\n") == 1
    assert "pip install 'cdpr[solvers]'" in done.stderr


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (percent(1.0), "100 %"),
        (percent(0.99999), "99.9 %"),
        (percent(1e-6), "0.1 %"),
        (percent(0.0), "0 %"),
        (percent(None), "-"),
        (digits(1234.4), "1234"),
        (digits(864.0, 2), "864"),
        (digits(0.07123), "0.0712"),
        (digits(2e-14, 2), "2e-14"),
        (power(3.2e-15), "3e-15"),
        (power(0.0), "0"),
        (power(None), "-"),
    ],
)
def test_numbers(text, wanted):
    assert text == wanted
