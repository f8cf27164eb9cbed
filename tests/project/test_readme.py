"""README and the index of docs/: short, their tables as the script would write them, links that lead somewhere, Python
that runs, and a picture that moves.
"""

from __future__ import annotations

import posixpath
import re
import xml.etree.ElementTree as ET

import numpy as np
import picture
import pytest
import update_readme
from conftest import ROOT
from docs_cases import PAGES

README = PAGES["README.md"]
LINES = 150  # what a newcomer reads
PYTHON = ("README.md", "docs/python.md", "docs/rollouts.md", "docs/solvers.md", "docs/workspaces.md")
SVG = "{http://www.w3.org/2000/svg}"
PAPERS = ("#ffffff", "#0d1117")  # of light and of dark pages
TOLD_APART = 3.0  # contrast that WCAG 2.1, 1.4.11, requires for graphics
# px; poses of another processor differ by rounding, and numbers are written to a tenth.
SAME = 0.11
SHADE = 2  # of 255, red, green or blue: tensions of another processor differ by rounding, and so do their colours


def test_the_readme_is_short_and_opens_with_the_picture():
    lines = README.splitlines()
    assert len(lines) <= LINES
    assert lines[4].endswith("(docs/caroca.svg)")


@pytest.mark.parametrize("page", update_readme.PAGES)
def test_tables_are_up_to_date(page):
    told = PAGES[posixpath.normpath(f"docs/{page}")]
    assert update_readme.updated(page) == told, "run: python docs/update_readme.py"


CODE = re.compile(r"^```.*?^```$", re.DOTALL | re.MULTILINE)


def test_two_commands_for_ci():
    blocks = re.findall(r"^```bash\n(.*?)^```$", README, re.DOTALL | re.MULTILINE)
    assert len(blocks) == 2
    assert all(len(block.splitlines()) == 1 for block in blocks)


@pytest.mark.parametrize(
    ("page", "target"),
    sorted({(page, to) for page, text in PAGES.items() for to in re.findall(r"\]\(([^)#:]+)\)", CODE.sub("", text))}),
)
def test_links_lead_somewhere(page, target):
    assert ((ROOT / page).parent / target).exists()


def test_the_index_names_every_page():
    named = set(re.findall(r"\]\(([\w]+\.md)\)", PAGES["docs/README.md"]))
    assert {f"docs/{name}" for name in named} == PAGES.keys() - {"README.md", "docs/README.md"}


@pytest.mark.slow
def test_python_examples_run(monkeypatch, tmp_path):
    """One after the other, as a reader would type them."""
    code = [re.findall(r"^```python\n(.*?)^```$", PAGES[page], re.DOTALL | re.MULTILINE) for page in PYTHON]
    assert [len(blocks) for blocks in code] == [1, 7, 3, 1, 1]
    (tmp_path / "scenarios").symlink_to(ROOT / "scenarios")
    monkeypatch.chdir(tmp_path)
    exec("".join(block for blocks in code for block in blocks), {})


def test_the_picture_is_that_of_a_run():
    """Every number of it, but for rounding; colours likewise."""
    kept, drawn = (numbers(text) for text in (picture.PICTURE.read_text(), picture.drawn(picture.simulated())))
    (places, shades), (others, their_shades) = kept, drawn
    assert len(places) == len(others) > 5000
    assert len(shades) == len(their_shades) > 1000
    np.testing.assert_allclose(places, others, atol=SAME, rtol=0.0)
    np.testing.assert_allclose(shades, their_shades, atol=SHADE, rtol=0.0)


def test_another_ramp_is_another_picture():
    """Even where its colours are as bright: red and blue change places."""
    text = picture.PICTURE.read_text()
    (places, shades), (others, wrong) = numbers(text), numbers(re.sub(r"#(..)(..)(..)(?=[\";])", r"#\3\2\1", text))
    assert places == others
    assert np.abs(np.subtract(shades, wrong)).max() > SHADE
    assert np.sum(shades) == np.sum(wrong)


def numbers(text):
    """All numbers (k,) and all colours (n, 3), 0 to 255, in their order."""
    colour = r"#[0-9a-f]{6}"
    shades = [list(bytes.fromhex(found[1:])) for found in re.findall(colour, text)]
    return [float(found) for found in re.findall(r"-?\d+\.?\d*", re.sub(colour, "", text))], shades


def test_the_picture_is_small_sound_and_moves():
    assert picture.PICTURE.stat().st_size < 200_000
    root = ET.parse(picture.PICTURE).getroot()
    assert root.get("aria-label") == picture.LABEL
    moves = root.findall(f".//{SVG}animate")
    assert len(moves) == 8 * 3 + 4 + 8 * 2  # cables: end and colour; shadow and three faces; bars: length and colour
    for move in moves:
        values = move.get("values").split(";")
        assert len(values) == picture.FRAMES + 1
        assert move.get("repeatCount") == "indefinite"
    assert "script" not in picture.PICTURE.read_text()
    assert "http" not in picture.PICTURE.read_text().replace("http://www.w3.org/2000/svg", "")


def test_the_picture_is_seen_on_light_and_dark_pages():
    text = re.sub(r'fill="[^"]*" fill-opacity="[^"]*"', "", picture.PICTURE.read_text())  # ground and shadow
    for colour in set(re.findall(r"#[0-9a-f]{6}", text)) - {picture.FACES["top"]}:  # that has an outline
        assert min(contrast(colour, paper) for paper in PAPERS) >= TOLD_APART, colour


def contrast(a, b):
    """Of two colours, as WCAG 2.1 defines it."""
    high, low = sorted((luminance(a), luminance(b)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def luminance(colour):
    parts = np.frombuffer(bytes.fromhex(colour[1:]), dtype=np.uint8) / 255.0
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])
