"""A running simulation seen and steered by others' tools: what goes out, what comes in, and the loop between.

`cdpr.live.drive.drive` takes a simulation step by step, as fast as a clock says, and between two slices looks at what
was asked for. What it shows is the newest complete sample: a thread of its own encodes and sends it, so that no client,
however slow, holds the simulation up. What is done to the simulation is an event of its scenario from then on.
"""

SPEEDS = 0.001, 1e6  # times real time
RATES = 0.1, 1000.0  # Hz, at which samples are shown
