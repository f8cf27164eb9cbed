"""Functional mock-up units (FMI 2.0 and 3.0, co-simulation): read and judged here without running what is in them.

`archive` opens a file after checking all of it, `description` reads what it says of itself, `model` holds that,
`trust` decides whether its native code may run, and `mapping` ties its variables to the signals of cdpr.
"""
