"""Naming of ROS 2 over Zenoh: keys, liveliness tokens, quality of service and attachments of rmw_zenoh.

Source: rmw_zenoh's docs/design.md (Jazzy and later; Humble has no type hashes and other keys). The functions do not
require Zenoh.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from xxhash import xxh3_128_intdigest

from cdpr.log.ros2 import full_name
from cdpr.ui.live.type_hash import type_hash

NODE, PUBLISHER, SUBSCRIPTION, SERVICE, CLIENT = "NN", "MP", "MS", "SS", "SC"
GID = 16  # bytes of a sender's identifier
_ATTACHMENT = struct.Struct(f"<qqB{GID}s")  # as serialised by zenoh-ext: two int64, array with its length


@dataclass(frozen=True)
class Node:
    """ROS 2 node of a Zenoh session.

    Attributes:
        domain: ROS_DOMAIN_ID.
        session: identifier of the session, as printed by Zenoh.
        name: name of the node, without namespace.
    """

    domain: int
    session: str
    name: str

    def token(self) -> str:
        """Return the key of the node's liveliness token."""
        return self._key("0", NODE)

    def endpoint(self, number: int, entity: str, name: str, kind: str, depth: int = 10) -> str:
        """Return the key of the liveliness token of an endpoint.

        Args:
            number: number that is unique in the session.
            entity: PUBLISHER, SUBSCRIPTION, SERVICE or CLIENT.
            name: topic or service, such as "/tf".
            kind: its type, as in `cdpr.log.ros2.fields`.
            depth: history depth; the endpoint is reliable, volatile and keeps the last messages.
        """
        mangled = name.replace("/", "%")
        return f"{self._key(str(number), entity)}/{mangled}/{dds_name(kind)}/{type_hash(kind)}/::,{depth}:,:,:,,"

    def key(self, name: str, kind: str) -> str:
        """Return the key of a topic's messages or of a service's calls."""
        return f"{self.domain}/{name.strip('/')}/{dds_name(kind)}/{type_hash(kind)}"

    def _key(self, number: str, entity: str) -> str:
        return f"@ros2_lv/{self.domain}/{self.session}/0/{number}/{entity}/%/%/{self.name}"


def dds_name(kind: str) -> str:
    """Return a type's name in keys: "geometry_msgs::msg::dds_::Pose_"."""
    package, group, name = full_name(kind).split("/")
    return f"{package}::{group}::dds_::{name}_"


def gid(token: str) -> bytes:
    """Return the identifier of the owner of a token: its XXH3 hash of 128 bits, little-endian."""
    return xxh3_128_intdigest(token.encode()).to_bytes(GID, "little")


def attachment(sequence: int, stamp: int, sender: bytes) -> bytes:
    """Return the attachment of a message: number from 1, time in ns since 1970, sender (GID bytes)."""
    return _ATTACHMENT.pack(sequence, stamp, GID, sender)


def parse_attachment(data: bytes) -> tuple[int, int, bytes]:
    """Return the number, time and sender of a message.

    Raises:
        ValueError: if the attachment is invalid.
    """
    if len(data) != _ATTACHMENT.size or data[16] != GID:
        raise ValueError(f"expected an attachment of {_ATTACHMENT.size} bytes: number, time and sender")
    sequence, stamp, _, sender = _ATTACHMENT.unpack(data)
    return sequence, stamp, sender
