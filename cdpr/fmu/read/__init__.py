"""FMUs without their native code, of which nothing is loaded here.

`archive` opens a file after checking all of it, `description` reads what it says of itself, `model` holds that, `trust`
decides whether its code may run, and `mapping` ties its variables to the signals of cdpr.
"""
