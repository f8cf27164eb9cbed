"""Live links: a running simulation is visualised and controlled by external tools.

`cdpr.ui.live.drive.drive` advances a simulation in slices, paced by the clock, and processes requests between two
slices. It shows the newest complete sample: a separate thread encodes and sends it, so that slow clients do not delay
the simulation. Actions on the simulation become events of its scenario.
"""

SPEEDS = 0.001, 1e6  # multiples of real time
RATES = 0.1, 1000.0  # Hz, rates of shown samples
