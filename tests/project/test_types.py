"""Public names of `cdpr`: every name has its type after a plain `import cdpr`."""

from __future__ import annotations

import inspect
import subprocess
import sys

import pytest
from conftest import ROOT

import cdpr
from cdpr.base import errors
from cdpr.base.errors import CdprError
from cdpr.base.lazy import lazily

# Reaches every module of the rooms that users call, as attributes of one another.
ATTRIBUTES = """
import pkgutil
import cdpr

for room in cdpr.__all__:
    for module in pkgutil.iter_modules(getattr(getattr(cdpr, room), "__path__", ())):
        getattr(getattr(cdpr, room), module.name)
print(cdpr.model.rotations.from_rpy(0.0, 0.0, 0.0))
"""


@pytest.mark.slow
def test_a_users_file_has_types(tmp_path):
    """As mypy sees it without a cache; with one, CI's step `types` does the same."""
    command = [sys.executable, "-m", "mypy", "--cache-dir", str(tmp_path), "tests/types"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


@pytest.mark.slow
def test_every_module_of_a_room_is_an_attribute():
    done = subprocess.run([sys.executable, "-c", ATTRIBUTES], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("[1. 0. 0. 0.]\n", "")


def test_all_public_names_exist():
    for name in cdpr.__all__:
        assert getattr(cdpr, name) is not None
    assert cdpr.__dir__() == sorted(cdpr.__all__)
    assert inspect.isfunction(cdpr.simulate)


def test_all_errors_are_public():
    found = {name for name, item in vars(errors).items() if inspect.isclass(item) and issubclass(item, CdprError)}
    assert found <= set(cdpr.__all__)


def test_a_name_that_is_nowhere():
    with pytest.raises(AttributeError, match="module 'cdpr' has no attribute 'simulat'"):
        cdpr.simulat  # noqa: B018
    assert not hasattr(cdpr.model, "no_such_module")


def test_missing_requirements_of_a_module_are_reported(tmp_path, monkeypatch):
    """Its own error is not reported as a missing attribute."""
    (tmp_path / "needy").mkdir()
    (tmp_path / "needy" / "__init__.py").touch()
    (tmp_path / "needy" / "part.py").write_text("import no_such_library")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ModuleNotFoundError, match="no_such_library"):
        lazily("needy")("part")
