"""Optional hooks that backends, controllers and estimators share."""

from __future__ import annotations

from abc import ABC
from collections.abc import Mapping
from typing import Any

from cdpr.base.errors import PluginError
from cdpr.model.robot import Array


class Plugin(ABC):  # noqa: B024 - interfaces derive from it
    """Base class of the interfaces of backends, controllers and estimators."""

    def log(self, columns: Mapping[str, Array]) -> None:
        """Store the arrays (width,) of its declared columns, by name, to write into.

        It is called once after construction with unused arrays, and again by a simulation with its recorded arrays:
        their values when a call returns, NaN until something is written.

        Args:
            columns: array (width,) of each declared column, by name.

        Raises:
            PluginError: if the plugin does not implement it.
        """
        raise PluginError(f"{type(self).__name__} declares columns but has no method `log` that receives them")

    def snapshot(self) -> object:
        """Return the complete internal state for `restore`, besides the arguments of its methods.

        `cdpr.plugins.SnapshotOfArrays` does this for a state in arrays, or without state. Backends that support
        snapshots declare the property `snapshot: True`.

        Raises:
            PluginError: if the plugin does not implement it.
        """
        raise PluginError(f"{type(self).__name__} cannot take snapshots")

    def restore(self, snapshot: object) -> None:
        """Restore a snapshot; the continuation is identical to the bit.

        Args:
            snapshot: result of `snapshot` of the same object.

        Raises:
            PluginError: if the plugin does not implement it.
        """
        raise PluginError(f"{type(self).__name__} cannot restore snapshots")

    def describe(self) -> dict[str, Any]:
        """Return further facts for the record of a run, beyond the options: plain data for JSON."""
        return {}

    def close(self) -> None:  # noqa: B027 - an optional hook
        """Free resources; the plugin is not used afterwards. May be called again."""
