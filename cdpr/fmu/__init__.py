"""Functional mock-up units (FMI 2.0 and 3.0, co-simulation).

Without their native code: `archive` opens a file after checking all of it, `description` reads what it says of itself,
`model` holds that, `trust` decides whether its code may run, and `mapping` ties its variables to the signals of cdpr.
With it: `running` starts one, in this process or another. `export` writes our robots as FMUs.
"""
