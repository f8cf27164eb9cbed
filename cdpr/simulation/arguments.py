"""Function calls with arguments of requests, checked against the signature."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from inspect import Parameter, signature
from typing import Any

from cdpr.base.errors import CdprError
from cdpr.base.nearest import did_you_mean
from cdpr.base.problems import shown


def call(do: str, function: Callable[..., Any], arguments: Mapping[str, Any]) -> Any:
    """Call a function and return its result.

    Args:
        do: name of the request, for messages.
        function: function to call.
        arguments: keyword arguments of the request.

    Raises:
        CdprError: if arguments are unknown or missing.
    """
    wanted = signature(function)
    takes = list(wanted.parameters)
    anything = any(each.kind is Parameter.VAR_KEYWORD for each in wanted.parameters.values())  # it checks them itself
    for name in () if anything else arguments:
        if name not in takes:
            known = ", ".join(takes) or "nothing"
            raise CdprError(f"{do}: unknown argument '{name}'; {did_you_mean(name, takes)}expected {known}")
    try:
        wanted.bind(**arguments)
    except TypeError as error:
        raise CdprError(f"{do}: {error}") from None
    return function(**arguments)


def in_order(tension: Sequence[float], names: Sequence[str], cables: Sequence[str]) -> list[float]:
    """Return tensions, N, given in the order of `names`, in the order of the cables.

    Raises:
        CdprError: if the names are not those of all cables, or the number of tensions differs.
    """
    if sorted(names) != sorted(cables) or len(tension) != len(names):
        raise CdprError(f"expected one for each of {', '.join(cables)}, got {shown(names)}, {len(tension)} tensions")
    return [tension[names.index(cable)] for cable in cables]
