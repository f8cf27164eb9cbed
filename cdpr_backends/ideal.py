"""Plants that pull with the commanded tensions themselves."""

from cdpr.errors import PluginError
from cdpr.model import Robot


def require_ideal(robot: Robot, cables: str) -> None:
    """Refuse a robot on winches; `cables` is the option that cannot move one."""
    if robot.cable_model != "ideal":
        raise PluginError(
            f"cables: {cables} knows no winches, and robot '{robot.name}' has cable.model {robot.cable_model}: leave "
            "the backend's option cables at ideal (cdpr's own kernel), or set robot.cable.model to ideal"
        )
