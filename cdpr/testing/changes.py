"""Checks of a plugin's changeable options."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar, get_args

import numpy as np
from pydantic import BaseModel, ValidationError

from cdpr.model.robot import Array
from cdpr.plugins import Controller, TensionSolver
from cdpr.testing.check import expect, expect_same_bits, needs

P = TypeVar("P", Controller, TensionSolver)

SAMPLES = 20


def expect_changes(
    names: Sequence[str], options: Any, make: Callable[[Any], P], compute: Callable[[P, int], Array]
) -> str:
    """Fail unless options change as declared.

    A plugin with changed options must give the same bits as one created with them. Each option must have an effect, and
    the memory of earlier calls must remain.

    Args:
        names: names of the options.
        options: initial options.
        make: function that creates the plugin with given options.
        compute: function that returns the answer of a plugin to sample k.
    """
    needs(names, "it declares no changeable options")
    plain = [compute(part, k) for part in [make(options)] for k in range(SAMPLES)]
    for name in names:
        differs = False
        for other in others(options, name):
            fresh, changed, back = make(other), make(options), make(options)
            changed.change(other)
            for k in range(SAMPLES):
                wanted = compute(fresh, k)
                expect_same_bits(compute(changed, k), wanted, f"answer after a change of {name}")
                differs |= not np.array_equal(wanted, plain[k])
                if k == SAMPLES // 2:
                    back.change(other)
                    back.change(options)
                expect_same_bits(compute(back, k), plain[k], f"answer after a change of {name} and back")
        expect(differs, f"option {name} has no effect, or no other valid value was found")
    return ", ".join(names)


def others(options: BaseModel, name: str) -> Iterator[BaseModel]:
    """Yield options with different values of one option, small and large changes, as far as they are valid."""
    model = type(options)
    key = next(key for key, field in model.model_fields.items() if name in (key, field.alias))
    present = getattr(options, key)
    values: list[Any] = [value for value in get_args(model.model_fields[key].annotation) if isinstance(value, str)]
    if isinstance(present, bool):
        values.append(not present)
    elif isinstance(present, int | float):
        values += [0.0, 0.5 * present, 2.0 * present + 1.0]
    elif isinstance(present, tuple):
        values += [tuple(factor * value for value in present) for factor in (0.0, 0.5, 2.0)]
    elif present is None:
        values += [0.5, 5.0, 50.0]
    for value in values:
        try:
            other = model.model_validate({**options.model_dump(by_alias=True), name: value})
        except ValidationError:
            continue
        if other != options:
            yield other
