"""The command line in this process, and workers that stay: what a new process costs, a second, is paid once a file."""

from __future__ import annotations

import contextlib
import io
import subprocess
import sys
import warnings
from unittest import mock

from cdpr.ui.cli import main


def cdpr_here(*arguments: object, code: int | None = 0, cwd: object = ".") -> subprocess.CompletedProcess[str]:
    """Run `cdpr` with these arguments; what it prints and its exit code, which must be `code` if that is given."""
    texts = [io.TextIOWrapper(io.BytesIO(), "utf-8", newline="") for _ in range(2)]
    with (
        contextlib.chdir(str(cwd)),
        contextlib.redirect_stdout(texts[0]),
        contextlib.redirect_stderr(texts[1]),
        mock.patch.object(sys, "argv", ["cdpr", *map(str, arguments)]),
        warnings.catch_warnings(),
    ):
        try:
            main()
        except SystemExit as end:
            ended = end.code
    for text in texts:
        text.seek(0)
    done = subprocess.CompletedProcess(arguments, int(ended or 0), *(text.read() for text in texts))
    assert code in (None, done.returncode), done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    return done
