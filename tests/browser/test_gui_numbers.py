"""The numbers of the window: all of eight cables are seen at once, and what has become of each."""

from __future__ import annotations

import pytest
from chromium import browser, executable
from conftest import ROOT

pytestmark = pytest.mark.browser
pytest.importorskip("playwright", reason="playwright is not installed: pip install 'cdpr[test]'")
pytest.importorskip("websockets", reason="websockets is not installed: pip install 'cdpr[gui]'")
if executable() is None:
    pytest.skip("there is no Chromium on this machine", allow_module_level=True)

READY = "() => window.cdpr !== undefined && cdpr.drawn !== null && cdpr.form.message !== null && cdpr.phase === 'ready'"
PATIENCE = 60_000  # ms, on a machine that does other things besides
# Ends of the numbers and of their visible container, px, and the hidden part.
SEEN = """() => {
  const side = document.querySelector("#side");
  const tables = [...document.querySelectorAll(".numbers")];
  return {
    bottom: Math.max(...tables.map((table) => table.getBoundingClientRect().bottom)),
    right: Math.max(...tables.map((table) => table.getBoundingClientRect().right)),
    end: side.getBoundingClientRect().bottom, edge: side.getBoundingClientRect().right,
    cut: [...document.querySelectorAll(".numbers td")].filter((cell) => cell.scrollWidth > cell.clientWidth)
      .map((cell) => cell.textContent),
    beyond: side.scrollHeight - side.clientHeight,
  };
}"""
CELLS = "() => [...document.querySelectorAll('[aria-label=Tensions] td')].map((cell) => cell.textContent)"
WORDS = "(words) => words.every((word) => document.querySelector('[aria-label=Tensions]').textContent.includes(word))"
JAM = "() => { cdpr.send({do: 'step', n: 5}); cdpr.send({do: 'jam', cable: 2}); cdpr.send({do: 'step', n: 20}); }"


@pytest.fixture(scope="module")
def chromium():
    with browser() as found:
        yield found


def test_eight_cables_are_complete_and_their_states_reported(chromium):
    from cdpr.ui.gui.editor import Editor
    from cdpr.ui.gui.window import Window

    told = []
    with Window(Editor(str(ROOT / "scenarios" / "caroca.yaml")), told.append, port=0) as window:
        window.begin()
        for width, height in ((1200, 800), (1500, 900)):
            page = chromium.new_page(viewport={"width": width, "height": height})
            page.set_default_timeout(PATIENCE)
            page.goto(window.address)
            page.wait_for_function(READY if width == 1200 else READY.replace("=== 'ready'", "=== 'paused'"))
            if width == 1200:
                page.evaluate(JAM)
            page.wait_for_function(WORDS, arg=["jammed"])
            if width == 1500:
                page.evaluate("() => { cdpr.send({do: 'cut', cable: 5}); cdpr.send({do: 'step', n: 5}); }")
                page.wait_for_function(WORDS, arg=["jammed", "broken"])
            seen = page.evaluate(SEEN)
            assert seen["cut"] == [], width
            assert seen["beyond"] == 0, (width, seen)
            assert seen["bottom"] <= seen["end"], (width, seen)
            assert seen["right"] <= seen["edge"], (width, seen)
            if width == 1500:
                cells = page.evaluate(CELLS)
            page.close()
    assert told == []
    numbers, words = cells[::2], cells[1::2]
    assert len(numbers) == 8
    assert words[1] == "jammed"
    assert float(numbers[1]) > 0.0  # it is reported beside its tension
    assert (numbers[4], words[4]) == ("broken", "")
    assert set(words) <= {"N", "jammed", "slack", ""}
