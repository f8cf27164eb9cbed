"""A process of its own for files of others: what crashes, hangs or eats the memory there ends nothing here.

It takes one request as JSON on stdin, and answers as JSON on stdout: `taken`, or the `error` for the user, or a `fault`
of ours with its `trace`.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import traceback
from contextlib import suppress
from typing import Any

from cdpr.errors import CdprError, one_line
from cdpr.processes import end_with

# Bytes of addresses that it may have; an import of all that ships needs a sixth of it.
MEMORY = 4 * 2**30
MOST_MADE = 64 * 2**20  # letters of files that are made: a window holds them until they are written


def main(parent: int) -> None:
    """Read what stdin asks for."""
    end_with(parent)
    with suppress(ValueError, OSError):  # a smaller limit is in force
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    answer = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what libraries print is no answer
    with answer:
        json.dump(_answer(json.load(sys.stdin)), answer)


def _answer(asked: dict[str, Any]) -> dict[str, Any]:
    try:
        from cdpr.formats.read.bring import import_any

        every = import_any(**asked)
        if sum(len(text) for each in every for text in each.files.values()) > MOST_MADE:
            return {"error": f"{asked['path']}: more than {MOST_MADE // 2**20} MiB would be written"}
        return {"taken": [vars(each) for each in every]}
    except CdprError as error:
        return {"error": str(error)}
    except MemoryError:
        return {"error": f"{asked['path']}: reading it takes more than {MEMORY // 2**30} GiB of memory"}
    except Exception as error:
        return {"fault": one_line(error), "trace": traceback.format_exc()}


if __name__ == "__main__":
    main(int(sys.argv[1]))
