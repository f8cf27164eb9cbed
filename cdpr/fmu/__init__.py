"""Functional mock-up units (FMI 2.0 and 3.0, co-simulation).

`read` opens one without running anything of it, `run` starts one whose code may run, and `export` writes our robots as
FMUs.
"""
