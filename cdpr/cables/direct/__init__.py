"""Motor that holds the commanded tension: T = u, without other effects of a winch."""

from __future__ import annotations

from cdpr.base.needs import EVERYWHERE
from cdpr.cables.chain import Winch

DIRECT = Winch(header="cdpr/cables/direct/direct.hpp", immediate=True, needs=EVERYWHERE)
