"""The page of the window, as text: one script, which alone may run, and no way for a file's text to become HTML."""

import re
from base64 import b64encode
from hashlib import sha256

from cdpr.ui.gui.page import FILES, FOLDER, STYLES, document, hello
from cdpr.ui.report.player.assets import DRAWING
from cdpr.ui.report.player.assets import FOLDER as PLAYER

SPACE = "http://www.w3.org/2000/svg"  # a name, never requested


def test_no_script_but_the_page_s_own_may_run():
    (script,) = re.findall(r"<script>(.*)</script>", document(), re.S)
    digest = b64encode(sha256(script.encode()).digest()).decode()
    assert f"content=\"script-src 'sha256-{digest}'\"" in document()


def test_it_names_no_other_place():
    assert set(re.findall(r"https?://[^\"'\s]+", document())) == {SPACE}
    assert not re.findall(r"\b(?:src|href)=\"(?!data:,\")", document())


def test_every_used_colour_is_described():
    asked, said = (set(re.findall(pattern, document())) for pattern in (r"var\((--\w+)", r"(--\w+):"))
    assert asked <= said | {"--light", "--dark"}


def test_all_scripts_and_styles_are_in_it():
    assert sorted(FILES) == sorted(path.name for path in FOLDER.glob("*.js"))
    assert sorted(STYLES) == sorted(path.name for path in FOLDER.glob("*.css"))


def test_html_is_built_only_from_the_scripts():
    for path in [*FOLDER.glob("*.js"), *(PLAYER / name for name in DRAWING)]:
        text = path.read_text(encoding="utf-8")
        assert not re.findall(r"outerHTML|insertAdjacentHTML|document\.write|\beval\b|new Function", text), path.name
        for made in re.findall(r"innerHTML\s*=\s*([^;]+);", text):
            assert re.fullmatch(r"('[^'$]*'\s*\+?\s*)+", made), path.name  # constant texts, nothing put into them


def test_windows_receive_key_names_and_files():
    told = hello()
    assert {"colours", "axes", "cables", "states", "ramp", "dashes", "examples"} <= told.keys()
    kinds = {(each["kind"], each["label"]): each["name"] for each in told["examples"]}
    assert kinds["scenario", "caroca"] == "caroca"
    assert kinds["robot", "caroca"].endswith("caroca.yaml")  # the name alone finds the scenario
    assert all(kind != "study" for kind, _ in kinds)
