"""Definition of the columns of a run, from which layout, log, exports, `cdpr.Run` and docs/columns.md follow.

A new quantity is one line in `LATER`, and one place that writes it; `run["name"]` reads it. The columns in `FIRST` are
in every log, and their order and places are part of the log's format. The header of a log lists all other columns, so
that readers use the table of the log, not their own.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

from cdpr.base.column import ARRAY, CABLES, WORLD, Column
from cdpr.base.problems import short_repr

# Topics of a log with their messages, in the order of a chunk; any other topic is an ARRAY and follows.
TOPICS = {
    "/clock": "rosgraph_msgs/Clock",
    "/cdpr/cable_states": "sensor_msgs/JointState",
    "/cdpr/cable_commands": "sensor_msgs/JointState",
    "/cdpr/platform/pose": "geometry_msgs/PoseStamped",
    "/cdpr/platform/pose_desired": "geometry_msgs/PoseStamped",
    "/cdpr/platform/twist": "geometry_msgs/TwistStamped",
    "/cdpr/platform/twist_desired": "geometry_msgs/TwistStamped",
    "/cdpr/platform/acceleration_desired": "geometry_msgs/AccelStamped",
    "/cdpr/platform/wrench": "geometry_msgs/WrenchStamped",
    "/cdpr/solver": ARRAY,
    "/cdpr/platform/external_wrench": "geometry_msgs/WrenchStamped",
    "/cdpr/energy": ARRAY,
    "/cdpr/winch_states": "sensor_msgs/JointState",
}

# further names in exports
_TAKEN = ("header", "cables", "message", "solver_status")

# Places in messages: topic and field.
_POSE, _POSE_DESIRED = "/cdpr/platform/pose/pose", "/cdpr/platform/pose_desired/pose"
_TWIST, _TWIST_DESIRED = "/cdpr/platform/twist/twist", "/cdpr/platform/twist_desired/twist"
_ACCEL = "/cdpr/platform/acceleration_desired/accel"
_WRENCH, _EXTERNAL = ("/cdpr/platform/wrench/wrench",), ("/cdpr/platform/external_wrench/wrench",)
COMMANDS, _STATES = "/cdpr/cable_commands", "/cdpr/cable_states"
WINCHES = "/cdpr/winch_states"  # only with unwound lengths
_SOLVER, _ENERGY = ("/cdpr/solver/data",), ("/cdpr/energy/data",)
_BY_LENGTH = "moments divided by the characteristic length"
_HELD = "from this sample to the next"

# State, desired state and the report of the tension stage are contiguous: the loop uses one view of each.
FIRST: tuple[Column, ...] = (
    Column("time", 1, "s", "Time of each sample", places=("/clock/clock",)),
    Column("position", 3, "m", "Platform origin", WORLD, (_POSE + ".position",)),
    Column("orientation", 4, "", "Attitude quaternion w, x, y, z", WORLD, (_POSE + ".orientation",)),
    Column("velocity", 3, "m/s", "Velocity of the origin", WORLD, (_TWIST + ".linear",)),
    Column("angular_velocity", 3, "rad/s", "Angular velocity", WORLD, (_TWIST + ".angular",)),
    Column("desired_position", 3, "m", "Desired platform origin", WORLD, (_POSE_DESIRED + ".position",)),
    Column("desired_orientation", 4, "", "Desired attitude quaternion", WORLD, (_POSE_DESIRED + ".orientation",)),
    Column("desired_velocity", 3, "m/s", "Desired velocity of the origin", WORLD, (_TWIST_DESIRED + ".linear",)),
    Column("desired_angular_velocity", 3, "rad/s", "Desired angular velocity", WORLD, (_TWIST_DESIRED + ".angular",)),
    Column("desired_acceleration", 3, "m/s^2", "Desired acceleration", WORLD, (_ACCEL + ".linear",)),
    Column("desired_angular_acceleration", 3, "rad/s^2", "Desired angular acceleration", WORLD, (_ACCEL + ".angular",)),
    Column("wrench", 6, "N, N m", "Wrench required by the controller, about the origin", WORLD, _WRENCH),
    # For ideal cables the command is the tension, unless an event broke or jammed the cable.
    Column("tension", CABLES, "N", f"Tension command {_HELD}", places=(COMMANDS + "/effort", _STATES + "/effort")),
    Column("length", CABLES, "m", "Cable lengths", places=(_STATES + "/position",)),
    Column("rate", CABLES, "m/s", "Rates of the cable lengths", places=(_STATES + "/velocity",)),
    Column("status", 1, "", "Result of the solver, a `cdpr.tension.Status`; 0 is OK", places=_SOLVER),
    Column(
        "residual",
        1,
        "N",
        "Error of the wrench: norm of W t - `wrench`, with t = `tension`. Only controlled directions count; "
        f"{_BY_LENGTH}",
        places=_SOLVER,
    ),
    Column(
        "margin",
        1,
        "N",
        "Smallest distance of a tension from its limits; negative if a tension is outside",
        places=_SOLVER,
    ),
    Column("at_limit", 1, "", "Number of cables at a limit", places=_SOLVER),
    Column("external", 6, "N, N m", f"External wrench on the platform {_HELD}, about the origin", WORLD, _EXTERNAL),
    Column("kinetic", 1, "J", "Kinetic energy of the platform", places=_ENERGY),
    Column("potential", 1, "J", "Potential energy; 0 if the centre of mass is at the world's origin", places=_ENERGY),
    Column("cable_work", 1, "J", "Work of the cables on the platform since the first sample", places=_ENERGY),
    Column("external_work", 1, "J", "Work of the external wrench since the first sample", places=_ENERGY),
)
# Cables that are not ideal, whose tension differs from the command.
WINCHED: tuple[Column, ...] = (
    Column("cable_tension", CABLES, "N", "Tension in each cable", places=(_STATES + "/effort", WINCHES + "/effort")),
)
# Pulleys with friction: the tensions on both sides differ.
FRICTION: tuple[Column, ...] = (
    Column("winch_tension", CABLES, "N", "Tension of each cable at its winch: `cable_tension` beyond the pulley"),
)
# Cables that sag: their force on the platform is not along the chord.
UNSTRETCHED: tuple[Column, ...] = (
    Column(
        "unstretched_length",
        CABLES,
        "m",
        "Unstretched length between winch and platform",
        places=(WINCHES + "/position",),
    ),
)
SAGGING: tuple[Column, ...] = (
    Column(
        "bending_wrench",
        6,
        "N, N m",
        "Wrench of the cables on the platform minus W t, with t = `cable_tension`, about the origin: what sag changes",
        WORLD,
    ),
)
# Controller and solver perceive another robot or state than the true one; W, residual and margin refer to that one.
NOMINAL_COLUMNS: tuple[Column, ...] = (
    Column(
        "true_wrench",
        6,
        "N, N m",
        "Wrench that the cables exert on the real platform, about the origin",
        WORLD,
    ),
    Column(
        "true_margin",
        CABLES,
        "N",
        "Distance of each command from the limits of the real robot; negative outside, NaN for broken or jammed cables",
    ),
)
# Events that change the mass of the platform.
LOADED: tuple[Column, ...] = (
    Column(
        "load_energy",
        1,
        "J",
        "Sum of the energies that payloads added when attached, minus those that they removed when released",
    ),
)
# Winches that take lengths or rates.
DRUMS: tuple[Column, ...] = (
    Column("winch_command", CABLES, "", f"Command of each winch: tension, N, length, m, or rate, m/s; {_HELD}"),
    Column("unstretched_rate", CABLES, "m/s", "Rate of `unstretched_length`", places=(WINCHES + "/velocity",)),
)
# Winches that turn.
MOTORS: tuple[Column, ...] = (
    Column("drum_angle", CABLES, "rad", "Angle of the drum, positive after winding in; 0 at the home pose"),
    Column("drum_speed", CABLES, "rad/s", "Speed of the drum, positive when winding in"),
    Column("motor_torque", CABLES, "N m", "Torque of the motor about the drum's axis; NaN for an ideal drive"),
    Column("motor_power", CABLES, "W", "Mechanical power of the motor, `motor_torque` times `drum_speed`"),
)
# Motors whose electrical data are known.
ELECTRICAL: tuple[Column, ...] = (
    Column("motor_current", CABLES, "A", "Current of the motor; NaN for a motor without torque or electrical data"),
    Column("motor_voltage", CABLES, "V", "Voltage of the motor, of its resistance and of its speed; NaN likewise"),
    Column(
        "electrical_power",
        CABLES,
        "W",
        "Electrical power of the motor: `motor_power` and the loss in its winding; negative when it feeds back power",
    ),
)
# Drives that apply the commands of winches imperfectly.
DRIVEN: tuple[Column, ...] = (
    Column(
        "drive_command", CABLES, "", f"Command that each drive applies: tension, N, length, m, or rate, m/s; {_HELD}"
    ),
)
# Stepper motors.
STEPPERS: tuple[Column, ...] = (
    Column("counted_length", CABLES, "m", "Unwound length that the drive of a stepper counts; NaN for other winches"),
    Column(
        "lost_steps",
        CABLES,
        "",
        "Full steps that a stepper has lost, positive if its cable was paid out; NaN for other winches",
    ),
)
# Estimate of the state, which controller and tension stage use; the first four are contiguous.
ESTIMATED: tuple[Column, ...] = (
    Column("estimated_position", 3, "m", "Estimated platform origin", WORLD),
    Column("estimated_orientation", 4, "", "Estimated attitude quaternion w, x, y, z", WORLD),
    Column("estimated_velocity", 3, "m/s", "Estimated velocity of the origin", WORLD),
    Column("estimated_angular_velocity", 3, "rad/s", "Estimated angular velocity", WORLD),
)
UNCERTAINTY: tuple[Column, ...] = (
    Column(
        "estimate_sigma",
        12,
        "m, rad, m/s, rad/s",
        "Standard deviations of the errors of the estimate, as the estimator computes them: position, attitude as "
        "rotation vector in platform axes, velocity, angular velocity; 0 in held directions",
        WORLD,
    ),
    Column(
        "nees",
        1,
        "",
        "Normalised estimation error squared, e^T P^-1 e, of the error e of the estimate with its covariance P",
    ),
)
INNOVATION: tuple[Column, ...] = (
    Column(
        "nis",
        1,
        "",
        "Normalised innovation squared, v^T S^-1 v, of the differences v between the measurements that arrived and "
        "those predicted, with the covariance S; NaN if none arrived",
    ),
    Column("nis_size", 1, "", "Number of values in `nis`"),
)
# Columns that are NaN for cables without limits, and infinite without a limit on one side, such as after a power cut. A
# non-finite value in any other column ends a run as diverged.
NEED_NOT_BE_FINITE = frozenset(
    {"margin", "true_margin", "nis", "nees", *(column.name for column in (*MOTORS, *ELECTRICAL, *STEPPERS))}
)
# Additional columns of this version; a new column is a line here. Its values are NaN until written.
LATER: tuple[Column, ...] = ()


@dataclass(frozen=True)
class ColumnGroup:
    """Additional columns that runs have under one condition.

    Attributes:
        columns: columns of the group.
        condition: the condition, after "recorded only if"; "" for every run.
    """

    columns: tuple[Column, ...]
    condition: str

    def within(self, columns: Iterable[Column]) -> bool:
        """Return True if these columns contain the group; names decide, as texts differ between versions."""
        return {column.name for column in self.columns} <= {column.name for column in columns}


# Groups of columns after `FIRST`. `cdpr.simulation.columns.CONDITIONS` decides them for a scenario; those of a part of
# the loop are in each run with that part.
GROUPS: dict[str, ColumnGroup] = {
    "winched": ColumnGroup(WINCHED, "cables or drives are not ideal, or cables lose tension on a pulley"),
    "friction": ColumnGroup(FRICTION, "a pulley has friction"),
    "drums": ColumnGroup(DRUMS, "a winch takes a length or a rate"),
    "motors": ColumnGroup(MOTORS, "a cable has a winch with a drum"),
    "electrical": ColumnGroup(ELECTRICAL, "a cable has a winch with a drum and a motor with a `torque_constant`"),
    "steppers": ColumnGroup(STEPPERS, "a winch is a stepper"),
    "unstretched": ColumnGroup(UNSTRETCHED, "a cable sags, or a winch takes a length or a rate"),
    "sagging": ColumnGroup(SAGGING, "a cable sags (`cable.model: catenary`)"),
    "later": ColumnGroup(LATER, ""),
    "perceived": ColumnGroup(NOMINAL_COLUMNS, "the scenario has `believed`, an estimator or sensors of pose and twist"),
    "driven": ColumnGroup(DRIVEN, "the scenario contains `drives`"),
    "estimated": ColumnGroup(ESTIMATED, "the scenario contains an `estimator`"),
    "uncertainty": ColumnGroup(UNCERTAINTY, "the scenario contains an `estimator` with a covariance"),
    "innovation": ColumnGroup(INNOVATION, "the scenario contains an `estimator` that compares with its predictions"),
    "loaded": ColumnGroup(LOADED, "an event of the scenario changes the mass, without `log_energy: false`"),
}


def known_columns() -> dict[str, tuple[Column, str]]:
    """Return all columns of this version by name, each with its condition; "" for columns of every run."""
    known = {column.name: (column, "") for column in FIRST}
    for group in GROUPS.values():
        known |= {column.name: (column, group.condition) for column in group.columns}
    return known


def check_declared(columns: object) -> None:
    """Raise TypeError or ValueError if a plugin may not declare these columns."""
    if not isinstance(columns, tuple) or not all(isinstance(column, Column) for column in columns):
        raise TypeError(f"columns must be a tuple of cdpr.plugins.Column, got {short_repr(columns)}")
    ours = {*known_columns(), *_TAKEN}
    for i, column in enumerate(columns):
        if column.places or column.owner:
            raise ValueError(f"column '{column.name}': a plugin cannot set its topic or owner")
        if column.name in ours:
            raise ValueError(f"column '{column.name}': a column of this name already exists; choose another name")
        if column.name in (other.name for other in columns[:i]):
            raise ValueError(f"column '{column.name}' is declared twice")


@lru_cache(maxsize=16)  # the cases of a rollout or a study use the same arguments
def clash(columns: tuple[Column, ...], cables: tuple[str, ...]) -> tuple[Column, Column, str] | None:
    """Return the first two columns with the same heading in a table, and that heading."""
    names: dict[str, int] = {}
    headings: dict[str, int] = {}
    for i, column in enumerate(columns):
        for seen, words in ((names, [column.name]), (headings, column.headings(cables))):
            for word in words:
                other = seen.setdefault(word, i)
                if other != i:
                    return columns[other], column, word
    return None
