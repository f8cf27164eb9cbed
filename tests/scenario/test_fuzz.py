"""Any file content gives a scenario or a CdprError."""

from __future__ import annotations

from conftest import EXAMPLES
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scenario_cases import PLUGINS, TEXTS

from cdpr.base.errors import CdprError
from cdpr.base.problems import dotted
from cdpr.config.problems import Problems
from cdpr.config.yaml_nodes import parse
from cdpr.scenario import Scenario, load_scenario

LINES = {name: text.splitlines(keepends=True) for name, text in TEXTS.items()}
PATHS = [
    (name, dotted(path))
    for name, text in TEXTS.items()
    for path in parse(text, "", Problems()).values
    if path and len(path) < 6
]

CHARACTERS = "[]{}:,-#&*!|>'\"%@`~?0 \t\n\r\0\ufeff\u2028\U0001f916é"
WORDS = [
    "<<",
    "---",
    "...",
    "null",
    "true",
    ".nan",
    "-.inf",
    "1e999",
    "010",
    "1e-3",
    "type: hold",
    "robot:",
    "!!map ",
]
PIECES = st.sampled_from([*CHARACTERS, *WORDS])
VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=5)
    | st.sampled_from(["quintic", "hold", "tuned", "gains", "XYZ", 1e300, -1e300, 5e-324, 10**400, 0, -0.0]),
    lambda inner: (
        st.lists(inner, max_size=6)
        | st.dictionaries(
            st.sampled_from(["type", "min", "max", "rpy", "position", "kp", "x", "from"]), inner, max_size=3
        )
    ),
    max_leaves=8,
)

many = settings(max_examples=3 * EXAMPLES, suppress_health_check=[HealthCheck.too_slow])


def outcome(text: str, overrides=()) -> None:
    try:
        scenario = load_scenario("a.yaml", text=text, overrides=overrides, plugins=PLUGINS)
    except CdprError as error:
        lines = str(error).splitlines()
        assert lines
        assert all(line.startswith(("a.yaml:", "--set", "overrides: ", "and ")) for line in lines), lines
    else:
        assert isinstance(scenario, Scenario)
        assert load_scenario("b.yaml", text=scenario.resolved_yaml(), plugins=PLUGINS) == scenario


@many
@given(st.sampled_from(sorted(TEXTS)), st.integers(0, 2000), st.integers(0, 12), PIECES)
def test_characters_are_replaced(name, start, length, piece):
    text = TEXTS[name]
    outcome(text[:start] + piece + text[start + length :])


@many
@given(st.sampled_from(sorted(LINES)), st.data())
def test_lines_are_dropped_doubled_moved_and_indented(name, data):
    lines = list(LINES[name])
    for _ in range(data.draw(st.integers(1, 3))):
        i = data.draw(st.integers(0, len(lines) - 1))
        j = data.draw(st.integers(0, len(lines) - 1))
        action = data.draw(st.sampled_from(["drop", "double", "swap", "indent"]))
        if action == "drop" and len(lines) > 1:
            del lines[i]
        elif action == "double":
            lines.insert(j, lines[i])
        elif action == "swap":
            lines[i], lines[j] = lines[j], lines[i]
        else:
            lines[i] = "  " + lines[i]
    outcome("".join(lines))


@settings(suppress_health_check=[HealthCheck.too_slow])
@given(st.dictionaries(st.sampled_from(PATHS), VALUES, min_size=1, max_size=3))
def test_values_are_replaced_by_any_others(changes):
    name = next(iter(changes))[0]
    outcome(TEXTS[name], {path: value for (_, path), value in changes.items()})


@given(st.text(max_size=60) | st.binary(max_size=60).map(lambda data: data.decode("latin-1")))
def test_any_text(text):
    outcome(text)


@given(
    st.lists(
        st.text(max_size=30) | st.builds("{}={}".format, st.sampled_from([p for _, p in PATHS]), st.text(max_size=9)),
        max_size=3,
    )
)
def test_any_overrides(overrides):
    outcome(TEXTS["hold"], overrides)
