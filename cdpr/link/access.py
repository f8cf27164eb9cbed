"""Access control of every server that cdpr opens: token, Host and Origin.

Clients of a server act with its user's permissions, and every web page in the user's browser can reach the ports of
this machine. Therefore each request needs:

- a Host that names this machine. A foreign name can be made to point here (DNS rebinding).
- the token of the address that cdpr printed. No foreign page knows it.
- no Origin, or an allowed one. Browsers send the true Origin of the page with each WebSocket.
"""

from __future__ import annotations

import hmac
import re
import secrets
import socket
from collections.abc import Sequence
from dataclasses import dataclass, field
from http import HTTPStatus
from ipaddress import ip_address
from urllib.parse import parse_qs, urlsplit

LOCAL = ("localhost", "127.0.0.1", "::1")
EVERYWHERE = ("", "0.0.0.0", "::")
HOST = re.compile(r"(?:(?P<name>[A-Za-z0-9._-]+)|\[(?P<six>[0-9A-Fa-f:.]+)\])(?::[0-9]{1,5})?")  # RFC 9110, 7.2
MOST_FIELDS = 100  # parameters of a query


class RefusedError(Exception):
    """Refused request with its HTTP status."""

    def __init__(self, status: HTTPStatus, text: str) -> None:
        super().__init__(text)
        self.status = status


@dataclass(frozen=True)
class Access:
    """Rules by which a server admits requests.

    Attributes:
        host: the address or name on which the server listens.
        token: what each address must contain as `?token=`.
        pages: whether pages of any origin are admitted if they know the token; otherwise only the server's own page.
        programs: whether requests without an Origin need no token. Browsers always send an Origin with a WebSocket.
    """

    host: str
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))
    pages: bool = False
    programs: bool = False

    def check(self, target: str, hosts: Sequence[str], origins: Sequence[str]) -> str:
        """Return the path of an admitted request.

        Args:
            target: request target, as in the request line.
            hosts: values of all its Host headers.
            origins: values of all its Origin headers.

        Raises:
            RefusedError: with the reason.
        """
        try:
            url = urlsplit(target)
            tokens = parse_qs(url.query, max_num_fields=MOST_FIELDS).get("token", [])
            target.encode("ascii")
        except ValueError:
            raise RefusedError(HTTPStatus.BAD_REQUEST, "the requested address is malformed") from None
        if len(hosts) != 1 or not self._names_us(hosts[0]):
            raise RefusedError(HTTPStatus.MISDIRECTED_REQUEST, "the Host header does not name this server")
        if not self._knows_token(tokens) and (tokens or origins or not self.programs):
            raise RefusedError(HTTPStatus.FORBIDDEN, "use the complete address that cdpr printed, with its token")
        if not self.pages and any(origin != f"http://{hosts[0]}" for origin in origins):
            raise RefusedError(HTTPStatus.FORBIDDEN, "pages of another origin are not admitted")
        return url.path

    def address(self, scheme: str, port: int) -> str:
        """Return the address for users, with the token."""
        host = socket.gethostname() if self.host in EVERYWHERE else self.host
        return f"{scheme}://{f'[{host}]' if ':' in host else host}:{port}/?token={self.token}"

    def _knows_token(self, tokens: Sequence[str]) -> bool:
        return len(tokens) == 1 and hmac.compare_digest(tokens[0].encode(), self.token.encode())

    def _names_us(self, host: str) -> bool:
        """Return True if a Host header is an address of this machine or a name that the user chose for it."""
        found = HOST.fullmatch(host)
        if found is None:
            return False
        name = (found["name"] or found["six"]).lower()
        if name in LOCAL or name == self.host.lower():
            return True
        if self.host in LOCAL:
            return False
        try:
            ip_address(name)
        except ValueError:
            return name == socket.gethostname().lower()
        return True
