"""Controller that damages its process on purpose; a folder on the path counts as installed."""

from typing import Literal

from pydantic import Field

from cdpr.plugins import PluginInfo, hookimpl
from cdpr_controllers import ComputedTorqueOptions

Fault = Literal["none", "raise", "hang", "crash", "exit", "kill", "chatter"]


class FaultyOptions(ComputedTorqueOptions):
    """Kind and time of the damage."""

    fault: Fault = Field("none", description="what happens")
    at: int = Field(20, ge=1, description="in which call")
    once: str = Field("", description="a file: made with the fault, which does not happen while it is there")


@hookimpl
def cdpr_controllers() -> list[PluginInfo]:
    """Return the plugins of this package."""
    return [
        PluginInfo("faulty", "cdpr_faulty.controller:Faulty", "computed torque with a fault", options=FaultyOptions)
    ]
