"""Random and adversarial tension distribution problems for the kernel library."""

from __future__ import annotations

import numpy as np
from kernel_cases import HOSTILE

EACH = 64  # of each shape, a multiple of eight
NAMES = ("matrix", "wrench", "tension_min", "tension_max")


def problems(rng, n, m):
    """Half of them sound; of the others each group of eight has one of each fault."""
    W = rng.normal(size=(EACH, n, m))
    if m == n + 1:  # a null vector that tightens all cables
        W[:, :, -1] = -np.einsum("knm,km->kn", W[:, :, :-1], rng.uniform(0.2, 2.0, (EACH, n)))
    low, high = rng.uniform(0.0, 50.0, (EACH, m)), rng.uniform(60.0, 400.0, (EACH, m))
    inside = np.where(
        np.arange(EACH)[:, None] % 3, rng.uniform(low, high), np.where(rng.random((EACH, m)) < 0.5, low, high)
    )
    wrench = np.einsum("knm,km->kn", W, inside)
    for k in range(EACH // 2, EACH):
        i, j = rng.integers(m), rng.integers(n)
        match k % 8:
            case 0:  # lower rank, and a wrench that it can or cannot balance
                W[k, -1] = W[k, 0] * rng.choice([0.0, 1.0, -2.0, 1e-12])
                wrench[k, -1] = W[k, -1] @ inside[k] + rng.choice([0.0, 1.0])
            case 1:  # locked cables, one of them cut
                high[k, : m // 2 + 1] = low[k, : m // 2 + 1]
                low[k, i] = high[k, i] = 0.0
            case 2:
                wrench[k, j] = rng.choice(HOSTILE)
            case 3:
                W[k, j, i] = rng.choice(HOSTILE)
            case 4:
                (low if rng.random() < 0.5 else high)[k, i] = rng.choice(HOSTILE)
            case 5:  # over the whole range of numbers, or too large to be summed
                scale = 10.0 ** rng.uniform(-300.0, 300.0, 2)
                W[k] *= scale[0]
                wrench[k] *= scale[rng.integers(2)]
            case 6:  # on a limit, or a round-off beside it
                inside[k, i] = high[k, i] * (1.0 + rng.choice([0.0, 1e-13, 1e-10, 1e-8]))
                if k % 16 < 8:  # of a balanced row, such as a moment about long arms, for which a share has no meaning
                    W[k, j] -= W[k, j] @ inside[k] / (inside[k] @ inside[k]) * inside[k]
                    W[k, j] *= 10.0 ** rng.uniform(1.0, 4.0)
                wrench[k] = W[k] @ inside[k]
            case 7:  # cables that exert nothing, or all the same
                W[k, :, i] = 0.0
                W[k, :, rng.integers(m)] = W[k, :, rng.integers(m)]
    return dict(zip(NAMES, (W, wrench, low, high), strict=True))
