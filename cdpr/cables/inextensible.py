"""Cable that does not stretch: its drum moves with it."""

from __future__ import annotations

from cdpr.base.needs import EVERYWHERE
from cdpr.cables.chain import Span

INEXTENSIBLE = Span(needs=EVERYWHERE)
