"""Process that imports files for a window, which has threads: it forks one for each file, with limits.

It takes one request as JSON on stdin, and answers as JSON on stdout: `taken`, or the `error` for the user, or a `fault`
of ours with its `trace`.
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from typing import Any

from cdpr.errors import CdprError, one_line
from cdpr.processes import end_with

MOST_MADE = 64 * 2**20  # letters of files that are made: a window holds them until they are written


def main(parent: int) -> None:
    """Read what stdin asks for."""
    end_with(parent)
    answer = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what libraries print is no answer
    with answer:
        json.dump(_answer(json.load(sys.stdin)), answer)


def _answer(asked: dict[str, Any]) -> dict[str, Any]:
    try:
        from cdpr.formats.read.bring import import_any

        if "tension" in asked:
            asked["tension"] = tuple(asked["tension"])
        every = import_any(**asked)
        if sum(len(text) for each in every for text in each.files.values()) > MOST_MADE:
            return {"error": f"{asked['path']}: more than {MOST_MADE // 2**20} MiB would be written"}
        return {"taken": [vars(each) for each in every]}
    except CdprError as error:
        return {"error": str(error)}
    except Exception as error:
        return {"fault": one_line(error), "trace": traceback.format_exc()}


if __name__ == "__main__":
    main(int(sys.argv[1]))
