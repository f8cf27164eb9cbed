"""Attitudes in several representations."""

from __future__ import annotations

from functools import lru_cache
from typing import ClassVar

import numpy as np
from pydantic import Field, model_validator

from cdpr.base import tolerances
from cdpr.base.fields import EulerOrder, Number, Section, Vector3, unit
from cdpr.base.needs import EVERYWHERE, Needs
from cdpr.model import rotations
from cdpr.model.robot import Array


class Euler(Section):
    """Successive rotations about the axes in `order`."""

    angles: Vector3 | None = Field(
        None, description="angles of the three turns, in the sequence of `order`", json_schema_extra=unit("rad")
    )
    angles_deg: Vector3 | None = Field(
        None, description="the same in degrees: expected one of both", json_schema_extra=unit("deg")
    )
    order: EulerOrder = Field(
        description="axes as in scipy: upper case moving axes (XYZ: R = Rx Ry Rz), lower case fixed axes"
    )

    @model_validator(mode="after")
    def _one_unit(self) -> Euler:
        if (self.angles is None) == (self.angles_deg is None):
            raise ValueError("expected exactly one of angles (rad) and angles_deg (deg)")
        return self

    @property
    def radians(self) -> Array:
        """The angles, (3,), rad."""
        return np.array(self.angles) if self.angles is not None else np.radians(np.array(self.angles_deg))


class Orientation(Section):
    """Attitude in the world, in exactly one of these forms."""

    needs: ClassVar[Needs] = EVERYWHERE
    rpy: Vector3 | None = Field(
        None,
        description="roll, pitch, yaw about fixed axes: R = Rz(yaw) Ry(pitch) Rx(roll)",
        json_schema_extra=unit("rad"),
    )
    rpy_deg: Vector3 | None = Field(None, description="the same in degrees", json_schema_extra=unit("deg"))
    wxyz: tuple[Number, Number, Number, Number] | None = Field(
        None, alias="quaternion", description="unit quaternion w, x, y, z, platform to world"
    )
    euler: Euler | None = Field(None, description="Euler angles with their order")

    @model_validator(mode="after")
    def _one_form(self) -> Orientation:
        forms = {"rpy": self.rpy, "rpy_deg": self.rpy_deg, "quaternion": self.wxyz, "euler": self.euler}
        given = [name for name, value in forms.items() if value is not None]
        if len(given) != 1:
            found = f"got {' and '.join(given)}" if given else "got none"
            raise ValueError(f"expected exactly one of rpy, rpy_deg, quaternion, euler, {found}")
        if self.wxyz is not None:
            _check_unit(self.wxyz)
        return self

    def quaternion(self) -> Array:
        """Return the attitude as unit quaternion w, x, y, z, shape (4,)."""
        if self.wxyz is not None:
            q = np.array(self.wxyz)
            return np.asarray(q / np.linalg.norm(q))
        if self.euler is not None:
            return rotations.from_euler(self.euler.radians, self.euler.order)
        if self.rpy_deg is not None:
            return rotations.from_rpy(*np.radians(self.rpy_deg))
        return _from_rpy(np.array(self.rpy).tobytes()).copy()


UPRIGHT = Orientation.model_construct(rpy=(0.0, 0.0, 0.0))


@lru_cache(maxsize=64)  # several checks use the attitudes of a scenario
def _from_rpy(angles: bytes) -> Array:
    return rotations.from_rpy(*np.frombuffer(angles))


def _check_unit(quaternion: tuple[float, ...]) -> None:
    norm = float(np.linalg.norm(quaternion))
    if abs(norm - 1.0) <= tolerances.UNIT:
        return
    if norm == 0.0:
        raise ValueError("the quaternion is zero; upright is [1, 0, 0, 0] (w, x, y, z)")
    hint = ", ".join(f"{value / norm:.6g}" for value in quaternion)
    raise ValueError(f"expected a quaternion of norm 1, got norm {norm:.6g}; normalised, it is [{hint}]")
