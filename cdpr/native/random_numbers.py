"""Random streams: uniform and normal numbers that compiled operations draw, with the state in an array.

The generator is MRG32k3a (L'Ecuyer 1999); `random_numbers.hpp` contains the formulas. Its state is six whole numbers in
float64, so it is part of the memory of its owner, and batches draw eight streams side by side. The numbers are the same
on every processor.
"""

from __future__ import annotations

from hashlib import sha256
from operator import index
from typing import SupportsIndex

import numpy as np
from numpy.typing import NDArray

from cdpr.base.errors import CdprError
from cdpr.native.bind import bind

Array = NDArray[np.float64]

MAX_COUNT = 100_000_000  # in one call: 0.8 GB
MODULI = np.array([4294967087] * 3 + [4294944443] * 3, dtype=np.uint64)  # as in random_numbers.hpp


class Stream:
    """Random stream of a named owner.

    Streams of different names or seeds are independent. `state` is live: the operations `uniform_numbers` and
    `normal_numbers` advance it.

    Attributes:
        seed: seed of the simulation.
        name: unique name of the owner, such as the name of a sensor.
        state: (6,), whole numbers.

    Example:
        >>> import numpy as np
        >>> from cdpr.native.bind import bind
        >>> stream, noise = Stream(0, "encoder"), np.empty(3)
        >>> draw = bind("normal_numbers", state=stream.state, numbers=noise)
        >>> draw()
        0
        >>> noise.round(3)
        array([ 1.303, -0.908,  0.199])
        >>> stream.restart()
        >>> normal_numbers(stream.state, 2).round(3)
        array([ 1.303, -0.908])
    """

    def __init__(self, seed: SupportsIndex, name: str) -> None:
        """Create the stream at its beginning.

        Args:
            seed: whole number of at least 0.
            name: any text.

        Raises:
            CdprError: if the seed is negative.
        """
        self.seed, self.name = index(seed), name
        if self.seed < 0:
            raise CdprError(f"seed: expected a whole number of at least 0, got {self.seed}")
        # Python's own hash of a text differs from process to process.
        owner = int.from_bytes(sha256(name.encode(errors="surrogatepass")).digest()[:16], "little")
        words = np.random.SeedSequence((self.seed, owner)).generate_state(6, np.uint64)
        self._initial = (1 + words % (MODULI - 1)).astype(np.float64)  # from 1, for a state of zeros is invalid
        self.state = self._initial.copy()

    def restart(self) -> None:
        """Return to the beginning."""
        self.state[:] = self._initial


def uniform_numbers(state: Array, count: SupportsIndex) -> Array:
    """Draw uniform numbers in the open interval (0, 1), multiples of 1 / 4294967088.

    Args:
        state: (6,), state of a stream; the call advances it.
        count: number of values.

    Returns:
        (count,).

    Raises:
        CdprError: if the state is no float64 array (6,) of a stream, or the count negative or above 1e8.

    Example:
        >>> import numpy as np
        >>> uniform_numbers(np.full(6, 12345.0), 3)  # as published by L'Ecuyer
        array([0.12701112, 0.31852757, 0.30918602])
    """
    return _draw("uniform_numbers", state, count)


def normal_numbers(state: Array, count: SupportsIndex) -> Array:
    """Draw standard normal numbers: the quantiles (Wichura 1988, AS 241) of the next uniform numbers.

    Args:
        state: (6,), state of a stream; the call advances it.
        count: number of values.

    Returns:
        (count,), mean 0, standard deviation 1, at most 6.3 in size.

    Raises:
        CdprError: if the state is no float64 array (6,) of a stream, or the count negative or above 1e8.

    Example:
        >>> import numpy as np
        >>> normal_numbers(np.full(6, 12345.0), 3).round(6)
        array([-1.140634, -0.47182 , -0.498159])
    """
    return _draw("normal_numbers", state, count)


def _draw(name: str, state: Array, count: SupportsIndex) -> Array:
    n = index(count)
    if not 0 <= n <= MAX_COUNT:
        raise CdprError(f"count: expected a whole number from 0 to {MAX_COUNT}, got {n}: draw more in several calls")
    numbers = np.empty(n)
    if np.ma.isMaskedArray(state):
        raise CdprError("state: expected that of a `Stream`, got a masked array")
    try:
        draw = bind(name, state=state, numbers=numbers)
    except (TypeError, ValueError) as error:
        raise CdprError(f"state: expected that of a `Stream`: {error}") from None
    if draw():
        limits = f"{MODULI[0]} and {MODULI[3]}"
        raise CdprError(f"state: expected whole numbers from 0 to below {limits}, not all 0, got {state.tolist()}")
    return numbers
