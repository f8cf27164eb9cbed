"""The motor that holds whatever tension it is told to: T = u. Nothing else of the winch takes part."""

from __future__ import annotations

from cdpr.cables.chain import Winch

DIRECT = Winch(header="cdpr/cables/direct/direct.hpp", immediate=True)
