"""`cdpr view`: pages of runs, robots and motions."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from command_line import cdpr_here
from conftest import ROOT

import cdpr
from cdpr.ui.report.pages.page import is_page

SCENARIOS = ROOT / "scenarios"


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    for name, gain in (("one", 100.0), ("other", 50.0)):
        cdpr.simulate("caroca", out=folder / name, overrides={"simulation.duration": 0.1, "controller.kp": gain})
    return folder


def shown(tmp_path, *arguments):
    """Return the content of the page of these arguments, and its text."""
    page = tmp_path / "page.html"
    done = cdpr_here("view", *arguments, "--no-open", "--out", page, "--force")
    assert done.stdout.strip() == str(page)
    text = page.read_text()
    block = re.search(r'<script type="application/json" id="data">(.*?)</script>', text)
    assert block
    return json.loads(block[1]), text


def stills(text):
    """Printed content in place of the player."""
    return re.findall(r'<div class="scroll static">(<svg.*?</svg>)\s*</div>', text, re.DOTALL)


def test_a_run(runs, tmp_path):
    data, text = shown(tmp_path, runs / "one")
    assert len(data["scenes"]) == 1
    assert {"tensions", "errors", "pose", "energy"} <= set(data["figures"])
    assert "in 0.1 s the platform of caroca" in text


def test_several_runs_over_one_another_with_their_differences(runs, tmp_path):
    data, text = shown(tmp_path, runs / "one", runs / "other")
    assert [scene["label"] for scene in data["scenes"]] == ["one", "other"]
    assert {"differences1", "pose1", "tension1"} <= set(data["figures"])
    assert text.index('id="verdict"') < text.index('id="viewer"')
    apart = np.linalg.norm(
        np.subtract(*(cdpr.load_run(runs / name).position for name in ("one", "other"))), axis=1
    ).max()
    told = re.search(r"other is never farther from one than (\S+) m in position", text)  # though nothing can be judged
    assert told
    assert float(told[1].replace("−", "-")) == pytest.approx(apart, rel=1e-3)


def test_a_robot_is_at_rest(tmp_path):
    data, text = shown(tmp_path, SCENARIOS / "robots" / "cogiro.yaml", "--pose", "0,0,2")
    (scene,) = data["scenes"]
    assert scene["time"]["n"] == 1
    assert 'id="slider"' not in text[: text.index("<script")]  # nothing to play
    assert "degrees of freedom" in text
    (still,) = stills(text)  # what is printed, and shown without script
    assert 'aria-label="cogiro"' in still


def test_a_scenario_moves_without_being_simulated(tmp_path):
    data, text = shown(tmp_path, SCENARIOS / "cogiro_pulleys.yaml", "--set", "simulation.duration=1")
    (scene,) = data["scenes"]
    assert data["span"] == [0.0, 1.0]
    assert len(scene["outlines"]["sizes"]) == 8  # pulleys
    assert {"tensions", "lengths", "motion"} <= set(data["figures"])
    assert 'id="slider"' in text[: text.index("<script")]
    assert len(stills(text)) == 4
    assert all("tension (N)" in still or "(m)" in still for still in stills(text)[1:])


def test_infeasible_motions_are_reported_and_shaded(tmp_path):
    cut = "events=[{type: cable_break, time: 1, cable: 1}, {type: cable_break, time: 1, cable: 3}]"
    data, text = shown(tmp_path, SCENARIOS / "planar.yaml", "--set", cut)
    (shade,) = data["shades"]
    ((start, stop),) = shade["intervals"]
    assert shade["name"] == "infeasible"
    assert start == pytest.approx(1.0, abs=0.01)
    assert stop == pytest.approx(data["span"][1])
    assert "<strong>Not feasible</strong>" in text
    colour = shade["colour"][0]
    assert [colour in still for still in stills(text)[1:]] == [True] * 3  # on paper, too
    assert all(">infeasible<" in still for still in stills(text)[1:])
    calm, whole = shown(tmp_path, SCENARIOS / "planar.yaml")
    assert calm["shades"] == []
    assert not any(colour in still for still in stills(whole))
    assert "Not feasible" not in whole


def test_unsupported_displays_are_reported(runs, tmp_path):
    done = cdpr_here("view", runs / "one", "--pose", "0,0,1", "--no-open", code=2)
    assert "finished runs cannot be changed: leave out --pose and --set" in done.stderr
    done = cdpr_here("view", tmp_path / "nothing.yaml", "--no-open", code=2)
    assert "nothing.yaml" in done.stderr


def test_robots_and_scenarios_go_one_at_a_time(runs):
    robots = [SCENARIOS / "robots" / name for name in ("cogiro.yaml", "cogiro_pulleys.yaml")]
    done = cdpr_here("view", *robots, "--no-open", code=2)
    assert "cogiro.yaml" in done.stderr
    assert "give robots and scenarios one at a time" in done.stderr
    done = cdpr_here("view", runs / "one", robots[0], "--no-open", code=2)
    assert done.stderr.count(".yaml: not the folder or log of a run") == 1
    assert str(runs) not in done.stderr


def test_unused_pages_are_removed(runs, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    pages = {cdpr_here("view", runs / name, "--no-open").stdout.strip() for name in ("one", "other")}
    assert pages == {str(tmp_path / "cdpr" / "view.html")}
    assert [path.name for path in tmp_path.rglob("*.html")] == ["view.html"]


def test_only_a_page_is_written_over(tmp_path):
    robot, page = tmp_path / "robot.yaml", tmp_path / "view.html"
    robot.write_text((SCENARIOS / "robots" / "cogiro.yaml").read_text())
    before = robot.read_bytes()
    done = cdpr_here("view", robot, "--no-open", "--out", robot, code=8)
    assert "robot.yaml' already exists and is not a page that cdpr wrote: it is not overwritten" in done.stderr
    assert robot.read_bytes() == before
    for more in (), ("--force",):
        cdpr_here("view", robot, "--no-open", "--out", tmp_path, *more)
    assert is_page(page.read_bytes())


@pytest.mark.parametrize("others", ["begins", "holds one of ours", "names another"])
def test_pages_of_others_stay(tmp_path, others):
    """A page of another author begins like ours, may show one of ours, and may name its author."""
    page = tmp_path / "notes.html"
    cdpr_here("view", SCENARIOS / "robots" / "cogiro.yaml", "--no-open", "--out", page)
    ours = page.read_text()
    mark = '<meta name="generator" content="cdpr">'
    assert ours.count(mark) == 1
    head = "<!DOCTYPE html>\n<html>\n<head>\n"
    page.write_text(
        {
            "begins": f"{head}<title>my notes</title>\n",
            "holds one of ours": f"{head}<title>my notes</title></head><body>{ours}</body>",
            "names another": ours.replace(mark, '<meta name="generator" content="Hugo">'),
        }[others]
    )
    before = page.read_bytes()
    done = cdpr_here("view", SCENARIOS / "robots" / "cogiro.yaml", "--no-open", "--out", page, code=8)
    assert "notes.html' already exists and is not a page that cdpr wrote" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert page.read_bytes() == before


def test_the_command_and_the_python_interface_write_the_same_page(runs, tmp_path):
    for what in (SCENARIOS / "robots" / "planar.yaml", runs / "one"):
        _, text = shown(tmp_path, what)
        assert cdpr.view(str(what), tmp_path / "verb.html", show=False).read_text() == text
