"""Functional mock-up units (FMI 2.0 and 3.0, co-simulation).

`read` opens one without loading its native code, `run` starts a trusted one, and `export` writes our robots as FMUs.
"""
