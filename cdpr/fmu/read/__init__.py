"""FMUs as files; their native code is never loaded here.

`archive` opens a file after checking all of it, `description` reads its metadata into `model`, `trust` decides whether
its code may run, and `mapping` connects its variables with the signals of cdpr.
"""
