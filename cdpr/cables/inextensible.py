"""A cable that does not stretch: its drum goes with it."""

from __future__ import annotations

from cdpr.cables.chain import Span

INEXTENSIBLE = Span()
