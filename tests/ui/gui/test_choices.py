"""Messages of the window name its fields, where commands have options."""

from __future__ import annotations

import re

import pytest
from test_import_collections import SEEN, model

from cdpr.base.errors import CdprError
from cdpr.formats.read.import_files import import_file
from cdpr.ui.gui.choices import FIELDS, in_window
from cdpr.ui.gui.page import document
from cdpr.ui.gui.server import notice


def test_a_cable_set_is_a_field(tmp_path):
    seen = SEEN["2_DoF_VSD"]
    with pytest.raises(CdprError, match=r"\(--cable-set\)$") as caught:
        import_file(model(tmp_path, "robot", seen.bodies, seen.cables))
    text = notice("error", str(caught.value))["text"]
    assert text.endswith("choose cable set 'basic_linear' (the field Cable set)")


def test_fields_are_on_the_page():
    page = document()
    for _, field in FIELDS:
        if found := re.search(r"the fields? ([^)]*)", field):
            assert f'"{found[1]}' in page


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("remove it (--set), or not", "remove it (in the form), or not"),
        ("ideal (--set robot.cable.model=ideal, of a robot file cable.model=ideal)", "ideal (in the form)"),
        ("to the import (--tension MIN,MAX)", "to the import (the fields Tension limits)"),
        ("increase the limit (--seconds N; in Python seconds=N)", "increase the limit (the field CPU time)"),
        ("a file (--settings)", "a file (--settings)"),
    ],
)
def test_words_of_commands(text, told):
    assert in_window(text) == told
