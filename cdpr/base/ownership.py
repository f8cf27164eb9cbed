"""Checks of who else may write to a file that cdpr executes, or that decides what is executed.

Such a file is used only if it and all folders on the way to it belong to this user or to root, and nobody else may
write to them. In a folder like /tmp, where the sticky bit is set, others cannot replace what they do not own. A group
whose only member is this user, as many systems create one for each user, counts as this user.

In a user namespace without root (bubblewrap, PrivateUsers of systemd), files of the system's root appear to belong to
the overflow user. Folders above the file's own folder may then belong to that user.
"""

from __future__ import annotations

import grp
import os
import pwd
import stat
from functools import cache
from pathlib import Path

OTHERS = stat.S_IWGRP | stat.S_IWOTH
UID_MAP = Path("/proc/self/uid_map")  # lines: first uid inside the namespace, first uid outside, count
OVERFLOW = Path("/proc/sys/kernel/overflowuid")


def fault(path: str | os.PathLike[str]) -> str:
    """Return the fault of a file or a folder, or of a folder on the way to it; "" if none.

    Raises OSError if it does not exist.
    """
    whole = Path(os.path.abspath(path))
    real = Path(os.path.realpath(whole))
    own = {real, real.parent} if not real.is_dir() else {real}
    for place in (real, *real.parents, *(folder for folder in whole.parents if folder not in real.parents)):
        if found := fault_of(os.stat(place), str(place), on_the_way=place != real, above=place not in own):
            return found
    return ""


def fault_of(about: os.stat_result, name: str, *, on_the_way: bool = False, above: bool = False) -> str:
    """Return the fault of an open file, or of a folder on the way to a file; "" if none.

    Args:
        about: owner and mode.
        name: for the message.
        on_the_way: a folder on the way to the file, which may be sticky.
        above: a folder above the file's own folder, which may belong to a root that is not mapped.
    """
    trusted = {0, os.geteuid()} | ({_unmapped_root()} if above else set())
    if about.st_uid not in trusted:
        return f"{name} belongs to another user"
    others = OTHERS
    if about.st_mode & stat.S_IWGRP and _is_private_group(about.st_gid, os.geteuid()):
        others = stat.S_IWOTH
    if about.st_mode & others and not (on_the_way and about.st_mode & stat.S_ISVTX):
        return f"others may write to {name} (chmod go-w)"
    return ""


def _unmapped_root() -> int | None:
    """Return the uid that root's files appear to have in a user namespace that does not map root; None elsewhere."""
    try:
        rows = [tuple(map(int, line.split())) for line in UID_MAP.read_text().splitlines()]
        if not rows or any(first <= 0 < first + count for first, _, count in rows):
            return None
        return int(OVERFLOW.read_text())
    except (OSError, ValueError):
        return None


@cache
def _is_private_group(gid: int, uid: int) -> bool:
    """Return whether a group is a user's primary group, named like the user, without another known member."""
    try:
        user, group = pwd.getpwuid(uid), grp.getgrgid(gid)
    except (KeyError, OSError):
        return False
    if gid != user.pw_gid or group.gr_name != user.pw_name or not set(group.gr_mem) <= {user.pw_name}:
        return False
    return all(each.pw_uid == uid for each in pwd.getpwall() if each.pw_gid == gid)


def make_private(folder: Path, own: Path) -> None:
    """Create a folder; missing folders on the way are private to this user.

    Existing folders from `own` on that belong to this user lose write access for others.

    Raises:
        OSError: if one cannot be created.
    """
    for place in reversed((folder, *folder.parents)):
        if not place.exists():
            place.mkdir(mode=0o700, exist_ok=True)
        elif place.is_relative_to(own):
            about = place.stat()
            if about.st_uid == os.geteuid() and about.st_mode & OTHERS and not about.st_mode & stat.S_ISVTX:
                place.chmod(stat.S_IMODE(about.st_mode) & ~OTHERS)
    folder.mkdir(exist_ok=True)  # raises an error if something else has its name


def read_private(path: Path) -> bytes:
    """Return the content of a regular file that nobody else may write to; its folders must be checked before.

    Raises:
        FileNotFoundError: if there is none.
        PermissionError: if it must not be used, with the reason.
    """
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK | os.O_NOFOLLOW)) as file:
        about = os.fstat(file.fileno())
        if not stat.S_ISREG(about.st_mode):
            raise PermissionError(f"{path} is not a regular file")
        if found := fault_of(about, str(path)):
            raise PermissionError(found)
        return file.read()
