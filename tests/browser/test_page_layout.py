"""Every kind of page, at the widths of phones, laptops and screens: nothing covers, cuts or overflows anything."""

from __future__ import annotations

import os

import pytest
from page_check import WATCH, WIDTHS, faults, faults_of, screen
from page_kinds import KINDS, PARAMETERS
from window_page import DRAWN

pytestmark = pytest.mark.browser

# Number of widths that are checked where a few suffice; CDPR_WIDTHS=all checks all.
FEW_WIDTHS = (390, 1280)
TAKEN = WIDTHS if os.environ.get("CDPR_WIDTHS") == "all" else FEW_WIDTHS


@pytest.mark.parametrize("kind", PARAMETERS)
def test_a_page_is_sound_at_all_widths(chromium, tmp_path, kind):
    address = KINDS[kind](tmp_path).as_uri()
    found = {width: told for width in TAKEN if (told := faults_of(chromium, address, width))}
    assert found == {}


PAGE = """<!DOCTYPE html><html><head><meta name="viewport" content="width=device-width, initial-scale=1"><style>
body { margin: 0; font: 16px sans-serif; }
section { margin: 10px; padding: 10px; border: 1px solid grey; position: relative; }
MORE</style></head><body><nav><a href="#first">First</a></nav>
<section id="first"><h2>First</h2><p>Some text.</p>BODY</section>
<section><h2>Second</h2><p>More text.</p></section></body></html>"""
TEXTS = '<text x="5" y="20">one</text><text x="80" y="20">two</text>'
SVG = f'<svg width="200" height="60" viewBox="0 0 200 60">{{}}{TEXTS}</svg>'
LINE = '<path d="M0 50h90" style="stroke: {}; fill: none" data-thing="engine:a"/>'

BAD = {
    "a covering card": ("", '<div style="position:absolute;inset:0;background:white"></div>', "covers"),
    "a table that overflows": ("table { width: 3000px; }", "<table><tr><td>cell</td></tr></table>", "overflows"),
    "a page that is too wide": ("", '<div style="width: 2500px">wide</div>', "px wide on"),
    "a text that is cut": (
        "",
        '<p style="overflow: hidden; white-space: nowrap; width: 60px">a text longer than its box</p>',
        "is cut by",
    ),
    "letters over letters": ("", SVG.format('<text x="6" y="21">three</text>'), "lies over"),
    "letters beyond the figure": ("", SVG.format('<text x="170" y="50">outside of it</text>'), "is cut"),
    "two colours of one thing": (
        "",
        SVG.format(LINE.format("red") + LINE.format("blue")),
        "has 2 colours",
    ),
    "a link to what is covered": ("#first { visibility: hidden; }", "", "leads to what is not shown"),
    "letters on a canvas": (
        "",
        '<div class="area"><canvas width="90" height="40"></canvas></div><script>'
        'const c = document.querySelector("canvas").getContext("2d"); c.fillText("far beyond", 70, 20);</script>',
        "is cut",
    ),
    "a choice that is cut": ("", '<select style="width: 50px"><option>a long choice</option></select>', "cuts"),
}


def checked(chromium, tmp_path, style, body, width):
    (tmp_path / "page.html").write_text(PAGE.replace("MORE", style).replace("BODY", body))
    return faults_of(chromium, (tmp_path / "page.html").as_uri(), width)


@pytest.mark.parametrize("width", [390, 1280])
@pytest.mark.parametrize("case", BAD)
def test_errors_are_found(chromium, tmp_path, case, width):
    style, body, said = BAD[case]
    assert any(said in fault for fault in checked(chromium, tmp_path, style, body, width)), case


@pytest.mark.parametrize("width", [390, 1280])
def test_correct_input_is_not_reported(chromium, tmp_path, width):
    body = SVG.format(LINE.format("red")) + "<table><tr><td>cell</td></tr></table>"
    assert checked(chromium, tmp_path, "", body, width) == []


@pytest.mark.parametrize("width", TAKEN)
def test_the_window_is_sound(chromium, window, width):
    context = chromium.new_context(**screen(width))
    try:
        page = context.new_page()
        page.add_init_script(WATCH)
        page.goto(window.address)
        page.wait_for_function(DRAWN, polling=50)
        assert faults(page, width) == []
    finally:
        context.close()
