"""Options of a peer in scenarios."""

from __future__ import annotations

from typing import Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

REMOTE = "remote"  # type of remote backends and controllers in scenarios and logs


class PeerOptions(BaseModel):
    """Options of peers in all roles; each role declares `program` itself, because only it resolves file names."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False, defer_build=True)

    sha256: str | None = Field(
        None,
        pattern="^[0-9a-f]{64}$",
        description="checksum of the program; given, the file must have it, and is trusted to run",
    )
    address: str | None = Field(
        None, min_length=1, description="address of a running peer: HOST:PORT, or unix:PATH of a socket"
    )
    timeout: float = Field(
        1.0,
        gt=0.0,
        le=3600.0,
        description="longest time for an answer, wall clock; then the run ends",
        json_schema_extra={"unit": "s"},
    )
    start_timeout: float = Field(
        10.0,
        gt=0.0,
        le=3600.0,
        description="time limit until the peer is connected and has answered the greeting",
        json_schema_extra={"unit": "s"},
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        program = getattr(self, "program", None)
        if (program is None) == (self.address is None):
            raise ValueError("set either `program` (command to start) or `address` (host:port to connect to)")
        if program is None and self.sha256 is not None:
            raise ValueError("sha256 requires a program; with an address, you trust the peer that you started")
        return self
