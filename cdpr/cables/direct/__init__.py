"""The motor that holds whatever tension it is told to: T = u. Nothing else of the winch takes part."""

from __future__ import annotations

from cdpr.cables.chain import Winch

DIRECT = Winch(kernels="cdpr.cables.direct.kernels", immediate=True)
