"""Shared infrastructure of jobs with many cases: random values, worker processes, clusters and resumption.

A case is one run in its own process (`cases`, `pool`, `worker`). A folder records the outcomes in a ledger that is
valid at any moment (`folder`), and random values depend only on a seed (`draw`). Compiled code runs in parallel threads
(`threads`). All jobs can run on a cluster (`cluster`).
"""
