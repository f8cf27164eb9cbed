"""Detection of plugin methods that have a compiled equivalent."""

from __future__ import annotations

from collections.abc import Callable


def speaks_for(says: Callable[..., object], does: Callable[..., object]) -> bool:
    """Return True if a plugin's method `says`, such as `compiled`, is valid for its method `does`.

    It is not valid if a derived class overrides only `does`, or if the instance has its own `does`.
    """
    part = getattr(says, "__self__", None)
    if part is None or getattr(does, "__self__", None) is not part or does.__name__ in vars(part):
        return False
    for each in type(part).__mro__:
        if says.__name__ in vars(each):
            return True
        if does.__name__ in vars(each):
            break
    return False
