"""Errors of measured tensions in an extended Kalman filter.

A measured tension acts on the estimate many times: until the next one arrives, it pushes the platform, and the damping
of a cable delays the stretch behind it. So its error is not white noise. With load cells, the filter has two further
error states for each cable, of the stretch and of the tension, as is usual for coloured noise: Bar-Shalom, Li,
Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), section 8.2.

The error of a measured tension is that of the load cell, and independent of those before. While a tension is held, its
variance grows as that of a random walk. In the longest time for which a tension is held, it grows by the mean square
change of the tensions in such a time before, less the noise.
"""

from __future__ import annotations


def numbers_of_errors(cables: int) -> int:
    """Return how many numbers the history has of the errors at each step: `TensionErrors.kept`.

    Args:
        cables: number of cables.
    """
    return cables + 2 * cables * 12 + 4 * cables**2
