"""Images of cameras in reports: times and pixels, from the file or rendered, within a size, without a renderer."""

from __future__ import annotations

import json
import re
from base64 import b64decode

import numpy as np
import pytest
from conftest import ROOT

import cdpr
from cdpr.log.images import images, png
from cdpr.sensing import rendering
from cdpr.ui.report.pages import cameras
from cdpr.ui.report.pages.run import render

SCENARIO = ROOT / "scenarios" / "camera.yaml"
SHORT = {"simulation.duration": 0.4, "log.step": 0.01}


@pytest.fixture(scope="module", autouse=True)
def usable():
    try:
        rendering.make_renderer("auto", rendering.Lens((100.0, 100.0), (8.0, 8.0), (16, 16))).close()
    except cdpr.CdprError as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return cdpr.simulate(SCENARIO, overrides=SHORT, out=str(tmp_path_factory.mktemp("images") / "run"))


@pytest.fixture(scope="module")
def page(run):
    return render(run)


def embedded(page):
    return json.loads(re.search(r'<script[^>]*id="data"[^>]*>(.*?)</script>', page, re.DOTALL)[1])["images"]


def test_a_report_contains_all_images_with_their_times(run, page):
    found = embedded(page)
    assert [each["name"] for each in found] == ["roof", "tool"]
    for each in found:
        expected = [(time, png(image)) for time, image in images(run, each["name"])]
        assert each["time"] == pytest.approx(np.arange(5) * 0.1)
        assert [b64decode(text) for text in each["images"]] == [data for _, data in expected]
    assert len(set(found[0]["images"])) == 5
    assert "one in" not in page[page.index('id="images"') :][:20000]


def test_images_come_from_the_file_or_else_from_the_rows(run, page, monkeypatch, tmp_path):
    with monkeypatch.context() as patch:
        patch.setattr(rendering, "find_spec", lambda name: None)  # no renderer is needed for stored ones
        assert embedded(render(run)) == embedded(page)
    copy = tmp_path / "run"
    copy.mkdir()
    for name in ("log.mcap", "run.json", "scenario.yaml"):
        (copy / name).write_bytes((ROOT / run.folder / name).read_bytes())
    (copy / "images.mcap").write_bytes((ROOT / run.folder / "images.mcap").read_bytes()[:5000])  # killed
    assert embedded(render(cdpr.load_run(copy))) == embedded(page)


def test_without_a_renderer_the_page_gives_the_reason(monkeypatch):
    run = cdpr.simulate(SCENARIO, overrides=SHORT)
    monkeypatch.setattr(rendering, "find_spec", lambda name: None)
    page = render(run)
    assert embedded(page) == []
    assert "No images: a camera needs mujoco or pybullet" in page


def test_large_images_are_thinned_and_the_page_counts_them(run):
    whole = cameras.shown_images(run)
    total = sum(len(data) for each in whole for data in each.files)
    part = cameras.shown_images(run, total // 2)
    assert sum(len(data) for each in part for data in each.files) <= total // 2
    roof = part[0]
    assert roof.every > 1
    assert roof.files == whole[0].files[:: roof.every]
    assert roof.time == whole[0].time[:: roof.every]
    text = cameras.images_figure(part)
    assert f"Of camera roof, the report contains one in {roof.every} images, {len(roof.files)} of 5," in text
    nothing = cameras.shown_images(run, 2)
    assert [each.files for each in nothing] == [(), ()]
    assert "No images: one image has more than 1 bytes." in cameras.images_figure(nothing)


@pytest.mark.parametrize(("count", "most"), [(1, 10), (7, 35), (7, 12), (1000, 10**9), (1000, 5000)])
def test_thinned_pictures_are_every_nth_and_within_the_size(count, most):
    pictures = [b"x" * (5 + k % 3) for k in range(count)]
    every, found = cameras.thinned(count, pictures.__getitem__, most)
    assert list(found) == list(range(0, count, every))
    assert all(found[k] == pictures[k] for k in found)
    assert sum(map(len, found.values())) <= most
    assert len(found) <= cameras.MOST_IMAGES
    assert every == 1 or 8 * len(found) >= min(most / 5, cameras.MOST_IMAGES)  # no more is left out than needed


def test_reports_without_cameras_have_no_images():
    page = render(cdpr.simulate("caroca", overrides={"simulation.duration": 0.05}))
    assert 'id="images"' not in page
    assert '"images"' not in page.split('id="data"')[1].split("</script>")[0]
