"""Images of cameras are written during a run: a killed run keeps them, and only the others are rendered again."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from study_cases import wait_until

import cdpr
from cdpr.base.errors import CdprError
from cdpr.link.waiting import report_waits
from cdpr.log import image_writer
from cdpr.log.image_file import complete_images
from cdpr.log.image_writer import ImageWriter
from cdpr.log.images import BEGINS, CameraImages, cameras_of, images, png
from cdpr.log.repair import repair

SCENARIO = ROOT / "scenarios" / "camera.yaml"
SMALL = {"sensors.0.size": [160, 120], "sensors.1.size": [160, 120]}
RUN = """
import sys, cdpr
changes = {"simulation.duration": 600.0, "sensors.0.size": [160, 120], "sensors.1.size": [160, 120]}
cdpr.simulate(sys.argv[1], overrides=changes, out=sys.argv[2], real_time=True)
"""
IMAGES = 65536  # bytes of the file at the kill: one chunk or more


@pytest.fixture(autouse=True)
def _renderer():
    try:
        camera = cameras_of(cdpr.simulate(SCENARIO, overrides={"simulation.duration": 0.01}).header)[0]
        _ = camera.renderer
        camera.close()
    except CdprError as error:
        pytest.skip(str(error))


def content(path):
    """The messages of a file, also of an incomplete one."""
    found = []
    with path.open("rb") as file:
        try:
            for _, channel, each in NonSeekingReader(file).iter_messages(log_time_order=False):
                found.append((channel.topic, each.log_time, each.data))
        except (McapError, ValueError):
            pass
    return found


@pytest.mark.slow
def test_a_killed_run_keeps_its_images(tmp_path, monkeypatch):
    folder = tmp_path / "run"
    process = subprocess.Popen([sys.executable, "-c", RUN, SCENARIO, folder])
    path = folder / "images.mcap"
    wait_until(lambda: process.poll() is not None or (path.exists() and path.stat().st_size > IMAGES))
    assert process.poll() is None, "it ended by itself"
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    kept = content(path)
    assert len(kept) > 10
    repair(folder)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = cdpr.load_run(folder)
    rendered, image = [], CameraImages.image
    monkeypatch.setattr(CameraImages, "image", lambda self, row: rendered.append(row[0]) or image(self, row))
    assert complete_images(run) == path
    whole = content(path)
    assert whole[: len(kept)] == kept
    assert len(rendered) == len(whole) - len(kept)
    times = np.array([time for topic, time, _ in whole if "roof" in topic]) / 1e9
    np.testing.assert_allclose(times, np.arange(len(times)) * 0.1)
    assert run.time[-1] - times[-1] < 0.1
    with path.open("rb") as file:
        assert make_reader(file).get_summary() is not None
    assert not list(folder.glob("*.part"))
    monkeypatch.undo()
    again = cdpr.simulate(SCENARIO, overrides={"simulation.duration": 0.3, **SMALL}, out=tmp_path / "whole")
    assert again.status == "finished"
    first = content(tmp_path / "whole" / "images.mcap")
    assert whole[: len(first)] == first, "the same images as without a kill"


def test_the_run_waits_for_images_that_are_far_behind(tmp_path, monkeypatch):
    """With room for one row, all images come, in order."""
    monkeypatch.setattr(image_writer, "QUEUE", 1)
    run = cdpr.simulate(SCENARIO, overrides={"simulation.duration": 1.0, **SMALL}, out=tmp_path / "run")
    assert run.status == "finished"
    assert [time for topic, time, _ in content(tmp_path / "run" / "images.mcap") if "roof" in topic] == [
        10**8 * k for k in range(11)
    ]


@pytest.mark.slow
def test_a_branch_has_the_images_from_the_start(tmp_path):
    with cdpr.Simulation(SCENARIO, overrides={"simulation.duration": 0.4, **SMALL}, out=tmp_path / "run") as simulation:
        simulation.step(120)
        before = simulation.snapshot()
        simulation.step(60)
        simulation.restore(before)
        simulation.step(simulation.steps + 1 - simulation.samples)
        run = simulation.run()
    whole = cdpr.simulate(SCENARIO, overrides={"simulation.duration": 0.4, **SMALL}, out=tmp_path / "whole")
    assert np.array_equal(run.rows, whole.rows)
    files = [tmp_path / name / "images.mcap" for name in ("run-2", "whole")]
    assert files[0].read_bytes() == files[1].read_bytes()
    assert len(content(tmp_path / "run" / "images.mcap")) == 2 * 4, "until 0.36 s"


def test_a_cable_that_is_cut_live_is_missing_from_then_on(tmp_path):
    with cdpr.Simulation(SCENARIO, overrides={"simulation.duration": 0.4, **SMALL}, out=tmp_path / "run") as simulation:
        simulation.step(75)  # of 2 ms: between the second image and the third
        simulation.cut(1)
        simulation.step(simulation.steps + 1 - simulation.samples)
        run = simulation.run()
    stored = [
        data[data.index(BEGINS) :] for topic, _, data in content(tmp_path / "run" / "images.mcap") if "roof" in topic
    ]
    assert stored == [png(image) for _, image in images(run, "roof")]
    whole = replace(run, header=replace(run.header, broken=()))
    differ = [one != png(image) for one, (_, image) in zip(stored, images(whole, "roof"), strict=True)]
    assert differ == [False, False, True, True, True]


def test_a_renderer_that_fails_ends_the_run_with_its_log(tmp_path, monkeypatch):
    calls = []

    def fails(self, row):
        calls.append(row)
        raise RuntimeError("no context")

    monkeypatch.setattr(CameraImages, "image", fails)
    done = []  # samples at the warnings

    def wait(count, total):
        samples.append(count)
        if count and not done:
            wait_until(lambda: calls)
            time.sleep(0.1)  # until the thread has ended

    samples = []
    changes = {"simulation.duration": 20.0, **SMALL}
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        monkeypatch.setattr(warnings, "showwarning", lambda text, *_: done.append((str(text), samples[-1])))
        with pytest.raises(CdprError, match="the images cannot be rendered: no context") as caught:
            cdpr.simulate(SCENARIO, overrides=changes, out=tmp_path / "run", progress=wait)
    ((text, at),) = done
    assert text == "the images cannot be rendered: no context; the run continues, without further images"
    assert at < samples[-1], "at once, not at the end"
    assert len(calls) == 1
    run = caught.value.run
    assert len(run.rows) == 10001
    assert [event.text for event in run.events if event.kind == "warning"] == [
        "the images cannot be rendered: no context"
    ]
    assert len(cdpr.load_run(tmp_path / "run").rows) == 10001


def test_interrupts_skip_images_that_repair_renders(tmp_path, monkeypatch):
    """The first one ends the run, which then waits for its images and reports that; the second one skips them."""
    image, lines, released = CameraImages.image, [], threading.Event()

    def waits(self, row):
        released.wait()
        return image(self, row)

    def interrupt(done, total):
        if done > 500:
            raise KeyboardInterrupt

    def second(text):
        lines.append(text)
        released.set()
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(CameraImages, "image", waits)
    with report_waits(second), pytest.raises(KeyboardInterrupt) as caught:
        cdpr.simulate(SCENARIO, overrides=SMALL, out=tmp_path / "run", progress=interrupt)
    run = caught.value.run
    assert run.status == "interrupted"
    (line,) = lines
    total = 2 * (1 + (len(run.rows) - 1) // 50)  # of two cameras at 10 Hz, with rows at 500 Hz
    assert line == (
        f"writing {total - 2} images; Ctrl-C again skips them, and `cdpr repair {tmp_path / 'run'}` renders them later"
    )
    (warning,) = (event.text for event in run.events if event.kind == "warning")
    assert warning == f"{total - 2} images not rendered: `cdpr repair {tmp_path / 'run'}` renders them"
    assert len(content(tmp_path / "run" / "images.mcap")) <= 2
    assert complete_images(cdpr.load_run(tmp_path / "run"))
    assert len(content(tmp_path / "run" / "images.mcap")) == total


@pytest.mark.slow
def test_an_interrupt_ends_the_wait_for_images_that_are_far_behind(tmp_path, monkeypatch):
    """No row is lost or taken twice."""
    image, released = CameraImages.image, threading.Event()

    def waits(self, row):
        released.wait()
        return image(self, row)

    monkeypatch.setattr(image_writer, "QUEUE", 2)
    monkeypatch.setattr(CameraImages, "image", waits)
    timers = [threading.Timer(1.0, signal.raise_signal, [signal.SIGINT]), threading.Timer(2.0, released.set)]
    for timer in timers:
        timer.start()
    with pytest.raises(KeyboardInterrupt) as caught:
        cdpr.simulate(SCENARIO, overrides=SMALL, out=tmp_path / "run")
    for timer in timers:
        timer.join()
    run = caught.value.run
    assert run.status == "interrupted"
    times = [time for topic, time, _ in content(tmp_path / "run" / "images.mcap") if "roof" in topic]
    assert times == [10**8 * k for k in range(1 + (len(run.rows) - 1) // 50)]


def test_a_writer_without_rows_leaves_a_complete_file(tmp_path):
    header = cdpr.simulate(SCENARIO, overrides={"simulation.duration": 0.01, **SMALL}).header
    ImageWriter(tmp_path / "images.mcap", header).close()
    with (tmp_path / "images.mcap").open("rb") as file:
        assert make_reader(file).get_summary() is not None
