"""Import and export in a browser: dialogs that stay until they are answered, and lose nothing of what was chosen."""

from __future__ import annotations

import io
import zipfile

import pytest
from browser_pages import PHONE
from plugin_cases import SUCCESSOR, TRAJECTORY

import cdpr
from cdpr.formats.write.export_model import Options, begin, export

pytestmark = pytest.mark.browser

EVIL = "<img src=x onerror=alert(1)>.yaml"
# Names of all controls in dialogs for screen readers.
NAMES = """() => [...document.querySelectorAll("dialog :is(button, input, select, textarea)")]
  .map((node) => node.getAttribute("aria-label") || [...(node.labels || [])].map((label) => label.textContent).join()
    || node.textContent)"""


def payload(name, text):
    return {"name": name, "mimeType": "text/plain", "buffer": text.encode()}


@pytest.fixture
def theirs(files):
    """The files of others, in a folder."""
    folder = files.folder / "theirs"
    folder.mkdir()
    (folder / "crane.yaml").write_text(SUCCESSOR)
    (folder / "way.yaml").write_text(TRAJECTORY)
    return folder


def opened(page, name):
    """A dialog that its button has opened."""
    page.get_by_role("button", name=name).click()
    return page.locator("dialog[open]")


def problem(dialog):
    told = dialog.get_by_role("alert")
    told.filter(has_text=":").wait_for()
    return told.inner_text()


def test_a_robot_is_imported_by_hand_and_keyboard(page, theirs):
    dialog = opened(page, "Import…")
    dialog.get_by_label("Choose files").set_input_files([theirs / "crane.yaml", theirs / "way.yaml"])
    assert dialog.locator("datalist option").evaluate_all("(all) => all.map(({ value }) => value)") == [
        "crane.yaml",
        "way.yaml",
    ]
    dialog.get_by_label("Trajectory (Gazebo)").fill("way.yaml")
    page.keyboard.press("Enter")
    page.get_by_role("heading", name="Result").wait_for()
    dialog = page.locator("dialog[open]")
    assert page.evaluate("document.activeElement.className") == "brought"  # so that arrows scroll it
    said = dialog.inner_text()
    assert "sim_cables: whether Gazebo simulates cables as legs" in said
    assert "way.yaml:2: imported as the straight line of the plug-in" in said
    dialog.get_by_text("crane.yaml, ").click()
    assert "mass: 15.0  # kg, platform.mass, line 7" in dialog.locator("pre").first.inner_text()
    assert dialog.get_by_label("File to open").input_value() == "crane_way.yaml"
    assert list(theirs.parent.glob("crane*")) == []  # nothing is written yet
    dialog.get_by_label("Folder").fill(str(theirs))
    page.keyboard.press("Enter")
    assert "crane.yaml' already exists and is not overwritten" in problem(dialog)
    dialog.get_by_label("Folder").fill(str(theirs.parent / "mine"))
    page.keyboard.press("Enter")
    page.wait_for_function("() => cdpr.form.message.file.endsWith('/mine/crane_way.yaml') && cdpr.phase === 'ready'")
    page.wait_for_function("() => cdpr.viewer.films[0].cables.length === 4 && !document.querySelector('dialog[open]')")
    assert page.locator("#form [role=tab][aria-selected=true]").evaluate("(tab) => tab === document.activeElement")
    assert cdpr.load_scenario(theirs.parent / "mine" / "crane_way.yaml").robot.m == 4
    page.get_by_role("button", name="Undo").click()
    page.wait_for_function("() => cdpr.form.message.file.endsWith('rise.yaml')")


def test_unreadable_files_are_reported_and_the_selection_is_kept(page, theirs):
    dialog = opened(page, "Import…")
    dialog.get_by_label("Choose files").set_input_files([payload("a.xml", "<bodies_system><links>")])
    dialog.get_by_label("Cable set (CASPR)").fill("all")
    dialog.get_by_role("button", name="Read").click()
    assert problem(dialog).startswith("a.xml:1: invalid XML")
    assert dialog.get_by_label("Cable set (CASPR)").input_value() == "all"
    assert dialog.get_by_label("Choose files").evaluate("(node) => node.files[0].name") == "a.xml"
    page.evaluate("cdpr.exchange.most = 10")
    dialog.get_by_role("button", name="Read").click()
    assert "MiB in total: enter their path instead" in problem(dialog)
    dialog.get_by_label("Or enter a path").fill(str(theirs))  # the last entry applies
    assert dialog.get_by_label("Choose files").evaluate("(node) => node.files.length") == 0
    dialog.get_by_label("Cable set (CASPR)").fill("")
    dialog.get_by_role("button", name="Read").click()
    page.get_by_role("heading", name="Result").wait_for()
    page.keyboard.press("Escape")
    assert page.locator("dialog[open]").count() == 0
    page.evaluate("() => { cdpr.link.open = () => {}; cdpr.link.socket.close(); }")
    page.locator("#lost").wait_for(state="visible")
    dialog = opened(page, "Import…")
    dialog.get_by_role("button", name="Read").click()
    assert problem(dialog) == "Not connected: nothing was sent."


def test_an_import_that_hangs_is_given_up_with_its_dialog(page, theirs, monkeypatch):
    stuck = theirs / "stuck"
    stuck.write_text("#!/bin/sh\nexec sleep 600\n")
    stuck.chmod(0o755)
    with monkeypatch.context() as patch:
        patch.setattr("cdpr.ui.gui.incoming.sys.executable", str(stuck))
        dialog = opened(page, "Import…")
        dialog.get_by_label("Or enter a path").fill(str(theirs / "crane.yaml"))
        dialog.get_by_role("button", name="Read").click()
        assert dialog.get_by_role("button", name="Reading …").is_disabled()
        page.wait_for_timeout(300)  # ms: it is being read
        page.keyboard.press("Escape")
        page.locator(".messages li", has_text="reading it was stopped").wait_for(state="attached")
    opened(page, "Import…").get_by_role("button", name="Read").click()
    page.get_by_role("heading", name="Result").wait_for()


def test_exports_are_downloaded(page, files):
    subject = begin(cdpr.load_scenario(files.scenario))
    dialog = opened(page, "Export…")
    style = dialog.get_by_label("Style (SDF)")
    assert style.is_disabled()
    dialog.get_by_label("Format").select_option("sdf")
    style.select_option("legs")
    with page.expect_download() as download:
        dialog.get_by_role("button", name="Download").click()
    assert download.value.suggested_filename == "seven.sdf"
    assert download.value.path().read_text() == export(subject, "sdf", Options(style="legs"))
    assert page.locator("dialog[open]").count() == 0
    dialog = opened(page, "Export…")
    assert style.input_value() == "legs"  # what was chosen stays
    dialog.get_by_label("Format").select_option("ros2")
    with page.expect_download() as download:
        dialog.get_by_role("button", name="Download").click()
    assert download.value.suggested_filename == "rise_ros2.zip"
    with zipfile.ZipFile(io.BytesIO(download.value.path().read_bytes())) as archive:
        assert "rise_ros2/cdpr_seven/package.xml" in archive.namelist()


def test_the_dialog_reports_unsupported_exports(page):
    page.evaluate("cdpr.send({ do: 'edit', path: 'robot.platform.mass', value: -1 })")
    page.wait_for_function("() => cdpr.form.message.problems.length > 0")
    dialog = opened(page, "Export…")
    dialog.get_by_role("button", name="Download").click()
    assert problem(dialog).startswith("not exported: ")
    assert "mass" in problem(dialog)


def test_names_and_texts_of_others_are_texts(page):
    dialog = opened(page, "Import…")
    dialog.get_by_label("Choose files").set_input_files([payload(EVIL, SUCCESSOR.replace("Turquoise", "<b>x</b>"))])
    dialog.get_by_role("button", name="Read").click()
    page.get_by_role("heading", name="Result").wait_for()
    said = page.locator("dialog[open]").inner_text()
    assert EVIL in said
    assert "'<b>x</b>' is unknown" in said
    assert page.locator("img, .brought b").count() == 0


def test_every_control_of_a_dialog_has_a_name(page):
    names = page.evaluate(NAMES)
    assert len(names) > 30
    assert all(name.strip() for name in names)


def test_on_a_phone_dialogs_fit(visit, theirs):
    page = visit(**PHONE)
    page.get_by_role("button", name="Form", exact=True).tap()
    dialog = opened(page, "Import…")
    dialog.get_by_label("Or enter a path").fill(str(theirs / "crane.yaml"))
    for _ in range(2):
        box = page.locator("dialog[open]").bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= PHONE["viewport"]["width"]
        assert page.locator("dialog[open]").evaluate("(node) => node.scrollWidth <= node.clientWidth")
        if dialog.get_by_role("button", name="Read").is_visible():
            dialog.get_by_role("button", name="Read").tap()
            page.get_by_role("heading", name="Result").wait_for()
