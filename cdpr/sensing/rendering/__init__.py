"""Rendering of images from primitives, off screen; one module per renderer."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec

from cdpr.base.errors import CdprError, MissingPackageError
from cdpr.sensing.rendering.drawing import Drawing, Lens, Renderer

__all__ = ["Drawing", "Lens", "Renderer", "check_renderer", "make_renderer"]

# Module of each renderer, package that it needs, and extra that installs it; "auto" takes the first that is installed.
RENDERERS = {
    "mujoco": ("cdpr.sensing.rendering.mujoco_egl", "mujoco", "cdpr[mujoco]"),
    "bullet": ("cdpr.sensing.rendering.tiny_renderer", "pybullet", "cdpr[bullet]"),
}


def check_renderer(name: str) -> str:
    """Return the name of an installed renderer; for "auto", the first one.

    Raises:
        MissingPackageError: if it is not installed.
    """
    wanted = list(RENDERERS) if name == "auto" else [name]
    for each in wanted:
        if find_spec(RENDERERS[each][1]) is not None:
            return each
    packages, extra = " or ".join(RENDERERS[each][1] for each in wanted), RENDERERS[wanted[0]][2]
    raise MissingPackageError(f"a camera needs {packages}, which is not installed: pip install '{extra}'")


def make_renderer(name: str, lens: Lens) -> Renderer:
    """Return a renderer for images of a camera.

    Raises:
        CdprError: if it is not installed or does not work on this machine.
    """
    found = check_renderer(name)
    try:
        renderer: Renderer = import_module(RENDERERS[found][0]).make(lens)
    except CdprError as error:
        other = next((each for each in RENDERERS if each != found and find_spec(RENDERERS[each][1])), None)
        if name == "auto" and other is not None:
            return make_renderer(other, lens)
        raise CdprError(f"renderer '{found}' does not work on this machine: {error}") from error
    return renderer
