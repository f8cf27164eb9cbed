"""Errors of measured quantities."""

from __future__ import annotations

from pydantic import Field

from cdpr.base.fields import NonNegative, Number, Section

COMPONENTS = "one value, or one for each component"


class AttitudeErrors(Section):
    """Errors of a measured attitude: rotations about the axes of the platform, after the true one.

    Example:
        >>> from cdpr.sensing.errors import AttitudeErrors
        >>> AttitudeErrors(noise=0.001).rows(3)
        [(1.0, 0.0, 0.001, 0.0, 0.0), (1.0, 0.0, 0.001, 0.0, 0.0), (1.0, 0.0, 0.001, 0.0, 0.0)]
    """

    noise: NonNegative = Field(0.0, description="standard deviation of white noise")
    bias: Number | tuple[Number, ...] = Field(0.0, description=f"constant error: {COMPONENTS}")
    drift: NonNegative = Field(
        0.0, description="standard deviation, after one second, of an error that is a random walk, unit/sqrt(s)"
    )

    def rows(self, components: int) -> list[tuple[float, float, float, float, float]]:
        """Return gain, bias, noise, drift and resolution of each component."""
        biases = self.bias if isinstance(self.bias, tuple) else (self.bias,) * components
        gain, resolution = getattr(self, "gain", 1.0), getattr(self, "resolution", 0.0)
        return [(gain, bias, self.noise, self.drift, resolution) for bias in biases]


class Errors(AttitudeErrors):
    """Errors of a measured quantity: value = gain * truth + bias + drift + noise, then rounded to the resolution.

    Noise and bias are in the unit of the quantity. It is the usual model of inertial sensors and load cells: IEEE Std
    952-2020, annex C, without its flicker noise.
    """

    gain: Number = Field(1.0, description="scale factor of the true value")
    resolution: NonNegative = Field(0.0, description="values are rounded to multiples of it; 0: exact")
