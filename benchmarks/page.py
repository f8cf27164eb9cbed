"""Size of a page of a minute, time to write it, and frame rate in a browser without a graphics card."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import cdpr
from cdpr.log import summary
from cdpr.ui.report.pages import run as pages
from cdpr.ui.report.pages.still import still
from cdpr.ui.report.plots import histories

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "browser"))
from chromium import browser, executable

TABLES = ("summary", "provenance", "events", "cables", "scenario")

ROUNDS = 9  # by turns with and without what plays: both take a second, and their difference is a tenth of that
LARGEST, SLOWEST, LATEST, FEWEST = 1.5, 0.3, 2.0, 20.0  # MB, s, s, frames a second

# Drawn frames per second, in this many milliseconds of playing.
FRAMES = """async (span) => {
  cdpr.play(true);
  let count = 0;
  const start = performance.now();
  await new Promise((done) => {
    const next = () => { count++; if (performance.now() - start < span) requestAnimationFrame(next); else done(); };
    requestAnimationFrame(next);
  });
  cdpr.play(false);
  return 1000 * count / (performance.now() - start);
}"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="of simulated time")
    seconds = parser.parse_args().seconds
    run = cdpr.simulate("cable_break", overrides={"simulation.duration": seconds})
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "report.html"
        pages.write_report(run, path)  # fonts and the like are read once
        pairs = [(timed(lambda: pages.write_report(run, path)), timed(lambda: stills(run))) for _ in range(ROUNDS)]
        whole, without = map(min, zip(*pairs, strict=True))
        player = whole - without
        size = path.stat().st_size / 1e6
        print(f"page of {seconds:g} s: {size:.2f} MB (at most {LARGEST:g})")
        print(f"written in {whole:.2f} s of a core, of which for what plays {player:.2f} s (at most {SLOWEST:g})")
        if executable() is None:
            raise SystemExit("there is no Chromium on this machine: how fast it draws is not measured")
        missed = ["size"] * (size > LARGEST) + ["writing"] * (player > SLOWEST)
        with browser() as found:
            for part, name in (("", "as it comes"), ("#gl", "WebGL"), ("#flat", "plain canvas")):
                page = found.new_page(viewport={"width": 1200, "height": 800})
                start = time.perf_counter()
                page.goto(path.as_uri() + part)
                page.wait_for_function("() => window.cdpr && window.cdpr.viewer.pictures && !window.cdpr.waiting")
                first = time.perf_counter() - start
                rate = max(page.evaluate(FRAMES, 3000) for _ in range(3))
                asked = f"at most {LATEST:g} s, at least {FEWEST:g}"
                print(f"{name}: first picture after {first:.2f} s, {rate:.0f} frames/s ({asked})")
                missed += [f"first picture {name}"] * (first > LATEST) + [f"frames/s {name}"] * (rate < FEWEST)
                page.close()
    if missed:
        raise SystemExit(f"missed: {', '.join(missed)}")


def stills(run: cdpr.Run) -> None:
    """Draw what a page would hold that does not play."""
    for drawing in pages.drawings(run):
        still(run, drawing.panels and drawing.panels(run), drawing.title)
    pages.page("", "", pages.tables.ending(run), {}, [getattr(pages.tables, name)(run) for name in TABLES])


def timed(act: Callable[[], None]) -> float:
    """Processor seconds of a call, without cached data of the run."""
    histories._KNOWN.clear()
    summary._COUNTED.clear()
    start = time.process_time()
    act()
    return time.process_time() - start


if __name__ == "__main__":
    main()
