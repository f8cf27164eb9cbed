"""Process that imports files for a window; it has no threads, so that it can fork a limited process per file.

It reads one request as JSON from stdin and writes the answer as JSON to stdout: `taken`, an `error` for the user, or an
internal `fault` with its `trace`.
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from typing import Any

from cdpr.base.errors import CdprError, one_line
from cdpr.base.processes import end_with

MOST_MADE = 64 * 2**20  # characters of converted files, which a window keeps until they are written


def main(parent: int) -> None:
    """Execute the request from stdin."""
    end_with(parent)
    answer = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # keep output of libraries out of the answer
    with answer:
        json.dump(_answer(json.load(sys.stdin)), answer)


def _answer(request: dict[str, Any]) -> dict[str, Any]:
    try:
        from cdpr.formats.read.import_files import import_any

        if "tension" in request:
            request["tension"] = tuple(request["tension"])
        every = import_any(**request)
        if sum(len(text) for each in every for text in each.files.values()) > MOST_MADE:
            return {"error": f"{request['path']}: more than {MOST_MADE // 2**20} MiB would be written"}
        return {"taken": [vars(each) for each in every]}
    except CdprError as error:
        return {"error": str(error)}
    except Exception as error:
        return {"fault": one_line(error), "trace": traceback.format_exc()}


if __name__ == "__main__":
    main(int(sys.argv[1]))
