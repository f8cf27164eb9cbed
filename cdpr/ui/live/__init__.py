"""Live links: a running simulation is visualised and controlled by external tools.

`cdpr.ui.live.drive.LiveDriver` is a `cdpr.simulation.driver.Driver` that shows the newest complete samples: a
separate thread encodes and sends it, so that slow clients do not delay the simulation. Clients put requests into the
queue of the driver.
"""

RATES = 0.1, 1000.0  # Hz, rates of shown samples
