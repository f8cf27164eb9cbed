"""Check for plants that apply the commanded tensions directly."""

from cdpr.base.errors import PluginError
from cdpr.cables import immediate, model_of, rubs
from cdpr.model import Robot


def require_ideal(robot: Robot, cables: str) -> None:
    """Raise PluginError for a robot on winches; `cables` is the option that does not support them."""
    if not immediate(robot):
        friction = " with friction on pulleys" if rubs(robot) else ""
        raise PluginError(
            f"cables: {cables} does not support winches, and robot '{robot.name}' has cable.model "
            f"{model_of(robot)}{friction}: leave the backend's option cables at ideal (cdpr's own kernel), "
            "or set robot.cable.model to ideal"
        )
