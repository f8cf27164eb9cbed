"""Types of values in the sections of a scenario."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, get_args

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from cdpr.base.colours import COLOURS, coloured
from cdpr.base.errors import CdprError
from cdpr.base.lazy import late
from cdpr.base.needs import Needs
from cdpr.base.problems import shown

MAX_MAGNITUDE = 1e12  # above this, squares and products leave the meaningful range of the simulation
# m; the longest cables have kilometres, and farther out round-off of positions exceeds the tolerance of comparisons:
# the spacing of floats is 1e-10 m here.
MAX_DISTANCE = 1e6
MAX_UNWOUND = 1e9  # m, largest unwound length of a command or an equilibrium
NAME_PATTERN = r"^\w[\w.-]{0,63}$"


DEFERRED = ConfigDict(defer_build=True)  # for types whose validators are built when first used: most runs need few


if TYPE_CHECKING:
    SectionType = type
else:

    class SectionType(type(BaseModel)):  # pydantic's metaclass is not public
        """Type of sections: constructors accept arrays and dicts, and raise CdprError with the argument's name."""

        def __call__(cls, *arguments: Any, **values: Any) -> Any:
            """Return a section of arguments by name; the `type` of a kind of section is known."""
            if arguments:
                raise CdprError(f"{cls.__name__}: expected arguments by name, got {shown(arguments[0])}")
            if issubclass(cls, Kind) and len(kinds := get_args(cls.model_fields["type"].annotation)) == 1:
                values = {"type": kinds[0]} | values
            try:
                return super().__call__(**values)
            except ValidationError:  # not of the exact types: read like a file
                return late("Section")(cls, values)


class Section(BaseModel, metaclass=SectionType):
    """Base class of all sections: frozen, no unknown key, no NaN, no silent conversion.

    Attributes:
        needs: needs of the section as a whole, or of each of its fields by name; see `cdpr.base.needs`.
    """

    needs: ClassVar[Needs | Mapping[str, Needs]] = {}

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False, defer_build=True)

    def to_dict(self) -> dict[str, Any]:
        """Return the given values as plain data, with the keys of a file."""
        return self.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)


class Kind(Section):
    """Base class of sections with several kinds, distinguished by their `type`."""

    type: str

    def to_dict(self) -> dict[str, Any]:
        """Return the given values as plain data, with the keys of a file; `type` also if it is the default."""
        return {"type": self.type} | super().to_dict()

    @classmethod
    def kind(cls) -> str:
        """Return the value of `type` of this kind."""
        name: str = get_args(cls.model_fields["type"].annotation)[0]
        return name


def unit(symbol: str) -> dict[str, Any]:
    """Return the unit of a field, for messages and the JSON Schema."""
    return {"unit": symbol}


TAB = "x-tab"  # key of a JSON Schema: tab of a field, and its rank there
HOME = "x-home"  # key of a JSON Schema: true if the robot's home replaces a field that its class requires


def tab(name: str, rank: int = 0) -> dict[str, Any]:
    """Return the tab of a field in the window and the documentation; fields of a lower rank come first.

    Args:
        name: tab, a key of `cdpr.scenario.sections.TABS`.
        rank: rank in the tab; fields of the same rank are in the order of their class.
    """
    return {TAB: [name, rank]}


def _moderate(value: float) -> float:
    if abs(value) > MAX_MAGNITUDE:
        raise ValueError(f"must lie between -{MAX_MAGNITUDE:g} and {MAX_MAGNITUDE:g}, got {shown(value)}")
    return value


def _highest(value: float) -> float:
    if math.isnan(value):
        raise ValueError("expected a number, got nan")
    return value if value == math.inf else _moderate(value)


def _near(value: float) -> float:
    if abs(value) > MAX_DISTANCE:
        raise ValueError(f"must lie between -{MAX_DISTANCE:g} and {MAX_DISTANCE:g} (m), got {shown(value)}")
    return value


def _named(value: str) -> str:
    if not re.fullmatch(NAME_PATTERN, value):
        text = f"expected a name of at most 64 letters, digits, '_', '-' and '.', got {value[:70]!r}"
        meant = re.sub(r"\s+", "_", value.strip())
        raise ValueError(f"{text}; write {meant}" if re.fullmatch(NAME_PATTERN, meant) else text)
    return value


def _turns(value: str) -> str:
    if not re.fullmatch(r"([xyz]){3}|([XYZ]){3}", value) or value[0] == value[1] or value[1] == value[2]:
        raise ValueError(
            "expected three axes, all upper case (moving axes, such as XYZ) or all lower case (fixed "
            f"axes, such as xyz), no axis twice in a row, got {value[:20]!r}"
        )
    return value


Number = Annotated[float, AfterValidator(_moderate)]
WholeOrNumber = Annotated[int | float, AfterValidator(_moderate)]  # whole numbers stay whole
# Upper limit that may be infinite
Highest = Annotated[float, Field(allow_inf_nan=True), AfterValidator(_highest)]
Positive = Annotated[float, Field(gt=0), AfterValidator(_moderate)]
NonNegative = Annotated[float, Field(ge=0), AfterValidator(_moderate)]
Share = Annotated[float, Field(ge=0, le=1)]
Efficiency = Annotated[float, Field(gt=0, le=1)]
AtLeastOne = Annotated[float, Field(ge=1), AfterValidator(_moderate)]
Vector3 = tuple[Number, Number, Number]
Coordinate = Annotated[float, AfterValidator(_near)]
Position = tuple[Coordinate, Coordinate, Coordinate]  # m
Name = Annotated[str, AfterValidator(_named), Field(json_schema_extra={"pattern": NAME_PATTERN})]
EulerOrder = Annotated[str, AfterValidator(_turns), Field(json_schema_extra={"pattern": "^([xyz]{3}|[XYZ]{3})$"})]

Colour = Annotated[str, AfterValidator(coloured), Field(json_schema_extra={"examples": ["#4878a8", *COLOURS]})]

ZERO: Vector3 = (0.0, 0.0, 0.0)

# Placeholder of an omitted pose until the loader fills in the initial one; never None after loading.
INITIAL: Any = None
