"""How ROS 2 over Zenoh names things: rmw_zenoh's keys, liveliness tokens, qualities of service and attachments.

After rmw_zenoh's docs/design.md (Jazzy and later; Humble has no type hashes and other keys). All functions are plain:
nothing here needs Zenoh.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from xxhash import xxh3_128_intdigest

from cdpr.live.type_hash import type_hash
from cdpr.log.ros2 import full_name

NODE, PUBLISHER, SUBSCRIPTION, SERVICE, CLIENT = "NN", "MP", "MS", "SS", "SC"
GID = 16  # bytes of the identifier of who sends
_ATTACHMENT = struct.Struct(f"<qqB{GID}s")  # as zenoh-ext serialises two int64 and an array of bytes with its length


@dataclass(frozen=True)
class Node:
    """A ROS 2 node of a Zenoh session.

    Attributes:
        domain: ROS_DOMAIN_ID.
        session: the session's identifier, as Zenoh prints it.
        name: the node's, without a namespace.
    """

    domain: int
    session: str
    name: str

    def token(self) -> str:
        """Return the key of the liveliness token that tells others of the node."""
        return self._key("0", NODE)

    def endpoint(self, number: int, entity: str, name: str, kind: str, depth: int = 10) -> str:
        """Return the key of the token of what the node has.

        Args:
            number: of its own, unlike any other's of the session.
            entity: PUBLISHER, SUBSCRIPTION, SERVICE or CLIENT.
            name: the topic or service, "/tf".
            kind: its type, as `cdpr.log.ros2.fields` knows it.
            depth: of its history; it is reliable, volatile and keeps the last.
        """
        mangled = name.replace("/", "%")
        return f"{self._key(str(number), entity)}/{mangled}/{dds_name(kind)}/{type_hash(kind)}/::,{depth}:,:,:,,"

    def key(self, name: str, kind: str) -> str:
        """Return the key of a topic's messages, or of a service's calls."""
        return f"{self.domain}/{name.strip('/')}/{dds_name(kind)}/{type_hash(kind)}"

    def _key(self, number: str, entity: str) -> str:
        return f"@ros2_lv/{self.domain}/{self.session}/0/{number}/{entity}/%/%/{self.name}"


def dds_name(kind: str) -> str:
    """Return a type's name in keys: "geometry_msgs::msg::dds_::Pose_"."""
    package, group, name = full_name(kind).split("/")
    return f"{package}::{group}::dds_::{name}_"


def gid(token: str) -> bytes:
    """Return the identifier of who has this token: its XXH3 hash of 128 bits, the lowest byte first."""
    return xxh3_128_intdigest(token.encode()).to_bytes(GID, "little")


def attachment(sequence: int, stamp: int, sender: bytes) -> bytes:
    """Return what goes with a message: its number, from 1; when it was sent, ns since 1970; who sent it (GID bytes)."""
    return _ATTACHMENT.pack(sequence, stamp, GID, sender)


def parse_attachment(data: bytes) -> tuple[int, int, bytes]:
    """Return number, time and sender of a message. Raises ValueError where it is none."""
    if len(data) != _ATTACHMENT.size or data[16] != GID:
        raise ValueError(f"an attachment of {_ATTACHMENT.size} bytes is expected: number, time and sender")
    sequence, stamp, _, sender = _ATTACHMENT.unpack(data)
    return sequence, stamp, sender
