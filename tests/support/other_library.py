"""Plugin of pytest that tests another build of the kernel library, such as one with sanitizers.

CDPR_TEST_LIBRARY=FOLDER/library.abi3.so pytest -p other_library tests/native/test_bind.py
"""

from __future__ import annotations

import os
import sys
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_file_location

NAME = "cdpr.native.library"

path = os.environ["CDPR_TEST_LIBRARY"]
spec = spec_from_file_location(NAME, path, loader=ExtensionFileLoader(NAME, path))
module = module_from_spec(spec)
spec.loader.exec_module(module)
sys.modules[NAME] = module


def pytest_report_header():
    return f"kernel library: {path}"
