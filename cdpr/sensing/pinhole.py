"""Limits of the pinhole model of cameras."""

from __future__ import annotations

MOST = 1000  # times the size of the image, and its inverse: renderers and drawings fail with narrower and wider views


def check_lens(focal: tuple[float, float], center: tuple[float, float] | None, size: tuple[int, int]) -> None:
    """Check that an image shows a part of the space that can be drawn.

    Args:
        focal: focal lengths fx and fy, px.
        center: principal point cx, cy, px; None for the middle of the image.
        size: width and height of the image, px.

    Raises:
        ValueError: if it does not.

    Example:
        >>> check_lens((800.0, 800.0), None, (640, 480))
    """
    given = f"got {focal[0]:g} and {focal[1]:g}"
    least, largest = [each / MOST for each in size], [float(each * MOST) for each in size]
    if any(length > limit for length, limit in zip(focal, largest, strict=True)):
        raise ValueError(
            f"focal: expected at most {largest[0]:g} px and {largest[1]:g} px, {MOST} times the size of the image, "
            f"{given}: the image would show less than 0.06 degrees"
        )
    if any(length < limit for length, limit in zip(focal, least, strict=True)):
        raise ValueError(
            f"focal: expected at least {least[0]:g} px and {least[1]:g} px, the size of the image / {MOST}, {given}: "
            "the image would show more than 179.7 degrees"
        )
    if center is not None and any(abs(place) > limit for place, limit in zip(center, largest, strict=True)):
        raise ValueError(
            f"center: expected at most {largest[0]:g} px and {largest[1]:g} px in size, {MOST} times the size of the "
            f"image, got {center[0]:g} and {center[1]:g}"
        )
