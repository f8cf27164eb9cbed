"""What all that runs many cases shares: drawing values, worker processes, a cluster, and going on where it stopped.

A case is one run in a process of its own (`cases`, `pool`, `worker`). A folder keeps how each ended in a ledger that is
whole at every moment (`folder`), and random values follow from a seed alone (`draw`). What compiled code
runs side by side is in threads (`threads`); all may be on a cluster (`cluster`).
"""
