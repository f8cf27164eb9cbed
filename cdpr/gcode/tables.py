"""Tables of G and M words in both dialects: modal groups, words without effect and rejected words."""

from __future__ import annotations

from cdpr.gcode.words import COMMAND, LINUXCNC, REPRAPFIRMWARE

METRES = {"mm": 1e-3, "inch": 0.0254, "m": 1.0}
DEFAULT_FEED = 0.05  # m/s, before the first F: RepRapFirmware's 3000 mm/min (its Configuration.h)

AXES = "XYZ"
CENTRE = "IJK"
PLANES = {17.0: (0, 1, 2), 18.0: (2, 0, 1), 19.0: (1, 2, 0)}  # first and second axis, and rotation axis

# G words without effect: compensations and cycles off, first coordinate system, and G94 in one dialect.
IDLE = {
    LINUXCNC: {40.0, 49.0, 50.0, 54.0, 69.0, 80.0, 97.0, 98.0, 99.0},
    REPRAPFIRMWARE: {10.0, 11.0, 40.0, 54.0, 80.0, 94.0},
}
# G words that do not use the line's coordinates. Ignoring any other word also skips the coordinates.
BESIDE = {LINUXCNC: {41.0, 42.0, 43.0, 55.0, 56.0, 57.0, 58.0, 59.0, 59.1, 59.2, 59.3}, REPRAPFIRMWARE: set[float]()}
OFFSETS = {10.0, 11.0}  # retraction, or tool settings including its position
KNOWN = {
    LINUXCNC: {0.0, 1.0, 2.0, 3.0, 4.0, 17.0, 18.0, 19.0, 20.0, 21.0, 53.0, 61.0, 61.1, 64.0, 90.0, 90.1, 91.0, 91.1}
    | {92.0, 92.1, 92.2, 92.3, 93.0, 94.0},
    REPRAPFIRMWARE: {0.0, 1.0, 2.0, 3.0, 4.0, 17.0, 18.0, 19.0, 20.0, 21.0, 53.0, 90.0, 91.0, 92.0},
}
# Modal groups of the accepted G words, of which a line may contain one each, as in the table "G-code modal groups" of
# LinuxCNC's manual. G80 is in none: LinuxCNC ignores it next to another motion, in either order.
MOTIONS = {0.0, 1.0, 2.0, 3.0}
SHARED_GROUPS = (MOTIONS, {17.0, 18.0, 19.0}, {20.0, 21.0}, {90.0, 91.0})
GROUPS = {
    LINUXCNC: (
        *SHARED_GROUPS,
        {4.0, 53.0, 92.0, 92.1, 92.2, 92.3},
        {61.0, 61.1, 64.0},
        {90.1, 91.1},
        {93.0, 94.0},
        {98.0, 99.0},
    ),
    REPRAPFIRMWARE: SHARED_GROUPS,
}
CANCEL = 80.0
# G words that use the coordinates of a line, or its P: two words of a row exclude each other.
USERS = {"coordinates": MOTIONS | {92.0}, "P": {2.0, 3.0, 4.0, 64.0}}
# M words that end the program, that wait, and that would run or change unsupported things.
ENDS = {LINUXCNC: {2.0, 30.0}, REPRAPFIRMWARE: {0.0, 1.0, 2.0, 30.0}}
WAITS = {LINUXCNC: {0.0, 1.0, 60.0}, REPRAPFIRMWARE: {226.0, 400.0}}
REFUSED = {
    LINUXCNC: {70.0, 71.0, 72.0, 73.0, 98.0, 99.0},
    REPRAPFIRMWARE: {24.0, 32.0, 98.0, 99.0, 120.0, 121.0, 206.0, 569.4, 579.0},
}
# Words of 3D printers that move single motors, not the platform: G6 and G95 (torque mode) of Marlin for hangprinters,
# and the mode H of moves in RepRapFirmware, except H0 (https://docs.duet3d.com, G1).
MOTOR_WORDS = {REPRAPFIRMWARE: {6.0, 95.0}, LINUXCNC: set[float]()}
MOTOR_MODE = "H"
SPEED_FACTOR = 220.0
SILENT = {LINUXCNC: "STDHLQ", REPRAPFIRMWARE: "STE"}  # letters without motion

# Words, and commands of other firmware, that `ignore` may contain.
IGNORABLE = rf"[GM][0-9]+(\.[0-9]+)?|[A-EHLOQS-W]|{COMMAND}"


def conflict(codes: set[float], dialect: str, has_p: bool) -> str | None:
    """Return why these G words cannot share a line (with P or without); None if they can."""
    for group in GROUPS[dialect]:
        if len(codes & group) > 1:
            return f"{_listed(codes & group)} exclude each other"
    for letters, users in USERS.items():
        if len(codes & users) > 1 and (has_p or letters != "P"):
            return f"{_listed(codes & users)} exclude each other: both use the {letters} of the line"
    return None


def _listed(codes: set[float]) -> str:
    return " and ".join(f"G{code:g}" for code in sorted(codes))
