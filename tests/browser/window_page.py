"""The window of `cdpr gui` in a browser: opening it, and operating it as hands do."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from gui_cases import ROBOT, SCENARIO

DRAWN = "() => window.cdpr !== undefined && cdpr.drawn !== null && cdpr.form.message !== null && cdpr.phase === 'ready'"
PHASE = "(phase) => cdpr.phase === phase"
PATIENCE = 60_000  # ms, on a machine that does other things besides

# Value of a field or of a table's cell in the form that the page received.
VALUE = """(path) => {
  const seek = (fields) => {
    for (const field of fields) {
      if (field.path === path) return field.value;
      for (const row of field.rows || []) {
        for (const [key, cell] of Object.entries(row.cells)) if (`${row.path}.${key}` === path) return cell.value;
      }
      const found = seek(field.fields || []);
      if (found !== undefined) return found;
    }
  };
  return seek(cdpr.form.message.tabs.flatMap((tab) => tab.fields));
}"""
IS = f"([path, value]) => JSON.stringify(({VALUE})(path)) === JSON.stringify(value)"


@pytest.fixture
def files(tmp_path):
    found = SimpleNamespace(robot=tmp_path / "seven.yaml", scenario=tmp_path / "rise.yaml", folder=tmp_path)
    found.robot.write_text(ROBOT)
    found.scenario.write_text(SCENARIO)
    return found


@pytest.fixture
def window(files):
    pytest.importorskip("websockets", reason="websockets is not installed: pip install 'cdpr[gui]'")
    from cdpr.ui.gui.editor import Editor
    from cdpr.ui.gui.window import Window

    told = []
    with Window(Editor(str(files.scenario)), told.append, port=0) as found:
        found.begin()
        yield found
    assert told == []  # nothing that the terminal should have


@pytest.fixture
def visit(window, open_page):
    """Opens pages of the window."""

    def open_one(ready=DRAWN, **options):
        page = open_page(window.address, ready, **{"viewport": {"width": 1500, "height": 900}, **options})
        page.set_default_timeout(PATIENCE)
        return page

    return open_one


@pytest.fixture
def page(visit):
    return visit()


def at(page, path):
    """The inputs of a field, on its tab and unfolded."""
    page.evaluate(
        "(path) => cdpr.form.lead(path, path.startsWith('robot') ? 'robot' : path.startsWith('simulation') ? "
        "'simulation' : path.startsWith('trajectory') ? 'motion' : 'control')",
        path,
    )
    return page.locator(f'[data-path="{path}"]').first.locator("input, select, textarea")


def write(page, path, *values):
    """Write into the fields of a path as hands do, and wait until the program has it."""
    inputs = at(page, path)
    for i, value in enumerate(values):
        inputs.nth(i).fill(str(value))
        if inputs.nth(i).get_attribute("type") != "color":  # where Enter opens a palette
            inputs.nth(i).press("Enter")
    page.wait_for_function(IS, arg=[path, list(values) if len(values) > 1 else values[0]])


def apply(page):
    page.evaluate("cdpr.viewer.films[0].before = true")
    page.get_by_role("button", name="Apply").click()
    page.wait_for_function("() => cdpr.form.message.applied && !cdpr.viewer.films[0].before && cdpr.phase === 'ready'")


def run_to_the_end(page):
    page.get_by_role("button", name="Maximum speed").click()
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function("() => ['done', 'ended', 'failed'].includes(cdpr.phase)")
