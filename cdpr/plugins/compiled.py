"""Which of a plugin's methods may be replaced by what the plugin says that they do."""

from __future__ import annotations

from collections.abc import Callable


def speaks_for(says: Callable[..., object], does: Callable[..., object]) -> bool:
    """Whether what one method of a plugin says of another, such as which kernel it is, is so.

    Not where a class derived from the one that says so does otherwise, or somebody put another method into the plugin.
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
