"""Checks of an estimator."""

from __future__ import annotations

import numpy as np

from cdpr.base.errors import CdprError, PluginError
from cdpr.model import rotations
from cdpr.testing import samples
from cdpr.testing.check import Check, Failed, expect, expect_same_bits, needs
from cdpr.testing.columns import expect_written
from cdpr.testing.estimator_subject import (
    BREAKS,
    KNOWN,
    NOISE,
    STEP,
    STEPS,
    EstimatorSubject,
    Measuring,
    errors,
    follow,
    motion,
)

SETTLED = 0.2  # largest share of an initial error after 0.6 s
AT_START = 0.02  # m and rad, error of the start
EXACT = 1e-3, 1e-3, 0.03, 0.03  # m, rad, m/s, rad/s: largest errors without noise, with velocities by differences
NEAR = 0.02  # m: ten times the way of the platform in a period of slow sensors
PERIOD = 0.005  # s, of slow sensors
UNIT = 1e-6  # of the norm of a quaternion
ASYMMETRY = 1e-9  # of a covariance, as a share of the standard deviations: round-off
INDEFINITE = 1e-9  # of the eigenvalues of the correlations: round-off
TINY = 1e-300  # divisor of the correlations of held directions
NIS = 0.5, 2.0  # of the normalised innovation squared, per value: the model of the estimator is nearly right


def estimate_is_complete(subject: EstimatorSubject) -> None:
    """The estimator writes finite numbers and a unit quaternion into every entry, from the first sample on.

    The measurements have noise.
    """
    found = subject.run(Measuring(motion(breaks=False), subject.sensors(noise=NOISE)))
    norms = np.linalg.norm(found[:, 3:7], axis=1)
    expect(np.abs(norms - 1.0).max() < UNIT, f"a quaternion has the norm {norms[np.argmax(np.abs(norms - 1.0))]:.9g}")


def missing_sensors_are_reported(subject: EstimatorSubject) -> str:
    """Without the sensors that it declares, the constructor raises a `CdprError`.

    Skipped if the estimator declares that it needs none (`sensors: ()`).
    """
    needs(subject.sensors(), "it declares that it needs no sensors")
    try:
        subject.make(Measuring(motion(breaks=False), []))
    except CdprError as error:
        return str(error)
    raise Failed("was created without its sensors, and raised no CdprError: call `self.first` in `__init__`")


def exact_measurements_are_followed(subject: EstimatorSubject) -> str:
    """The estimate starts at the true state, without noise. It must stay at the true state."""
    of = motion(breaks=False)
    worst = errors(subject.run(Measuring(of, subject.sensors())), of).max(axis=0)
    text = f"errors up to {worst[0]:.2g} m, {worst[1]:.2g} rad, {worst[2]:.2g} m/s, {worst[3]:.2g} rad/s"
    expect((worst <= EXACT).all(), f"{text}; allowed are {', '.join(map(str, EXACT))}")
    return text


def wrong_start_is_forgotten(subject: EstimatorSubject) -> str:
    """The estimate starts 0.02 m and 0.02 rad off, without noise. Within 0.6 s, both errors fall to a fifth."""
    of = motion(breaks=False)
    start = of.states[0].copy()
    start[:3] += AT_START * np.array([0.6, 0.0, -0.8])
    start[3:7] = rotations.multiply(start[3:7], rotations.from_axis_angle(np.array([0.0, 0.6, 0.8]), AT_START))
    last = errors(subject.run(Measuring(of, subject.sensors(), start=start)), of)[-1]
    text = f"errors {last[0]:.2g} m and {last[1]:.2g} rad after 0.6 s"
    expect((last[:2] <= SETTLED * AT_START).all(), text)
    return text


def late_measurements_are_used(subject: EstimatorSubject) -> str:
    """The sensors have 200 Hz and a delay of one period. The estimate stays within 2 cm of the true position."""
    of = motion(breaks=False)
    late = subject.sensors(noise=NOISE, period=PERIOD, delay=PERIOD)
    worst = float(errors(subject.run(Measuring(of, late)), of)[:, 0].max())
    expect(worst <= NEAR, f"error up to {worst:.3g} m")
    return f"error up to {worst:.2g} m"


def cable_breaks(subject: EstimatorSubject) -> str:
    """If a cable breaks, the estimate stays within 2 cm of the true position.

    The tension of the broken cable is 0 at once. Its command and its tension limits become 0 only 50 ms after the
    break.
    """
    of = motion(breaks=True)
    found = subject.run(Measuring(of, subject.sensors(), known_from=KNOWN))
    worst = float(errors(found, of)[BREAKS:, 0].max())
    expect(worst <= NEAR, f"error up to {worst:.3g} m after the break")
    return f"error up to {worst:.2g} m after the break"


def reset_forgets(subject: EstimatorSubject) -> None:
    """After `reset`, the estimates are identical to the first ones, and to those of a new object."""
    measuring = Measuring(motion(breaks=False), subject.sensors(noise=NOISE))
    estimator = subject.make(measuring)
    first = follow(estimator, measuring, range(100))
    estimator.reset()
    expect_same_bits(follow(estimator, measuring, range(100)), first, "estimate after reset")
    expect_same_bits(subject.run(measuring, 100), first, "estimate of another object")


def snapshot_restores(subject: EstimatorSubject) -> None:
    """After `restore`, the estimator repeats the estimates that followed the snapshot.

    Skipped if `snapshot` raises a `PluginError`.
    """
    measuring, out = Measuring(motion(breaks=False), subject.sensors(noise=NOISE)), np.full(13, np.nan)
    estimator = subject.make(measuring)
    follow(estimator, measuring, range(100), out)
    try:
        snapshot, kept = estimator.snapshot(), out.copy()
    except PluginError:
        needs(False, "it does not support snapshots")
    first = follow(estimator, measuring, range(100, 200), out)
    follow(estimator, measuring, range(200, 300), out)  # in between, continue elsewhere
    estimator.restore(snapshot)
    expect_same_bits(follow(estimator, measuring, range(100, 200), kept), first, "estimate after the snapshot")


def compiled_operations_agree(subject: EstimatorSubject) -> None:
    """The compiled operations and the method `estimate` compute identical estimates.

    Skipped if the estimator has no compiled operations.
    """
    measuring, out = Measuring(motion(breaks=False), subject.sensors(noise=NOISE)), np.full(13, np.nan)
    estimator = subject.make(measuring)
    operations = estimator.compiled(out)
    needs(operations is not None, "it has no compiled operations")
    wanted = subject.run(measuring, 100)
    for k in range(100):
        measuring.take(k)
        for operation in operations or ():
            expect(operation(k * STEP) == 0, "a compiled operation does not return 0")
        expect_same_bits(out, wanted[k], f"compiled estimate at step {k}")


def covariance_is_valid(subject: EstimatorSubject) -> str:
    """The covariance stays symmetric and positive semidefinite. `covariance` remains the same array during the run.

    Skipped if the estimator provides none.
    """
    measuring, out = Measuring(motion(breaks=False), subject.sensors(noise=NOISE)), np.full(13, np.nan)
    estimator = subject.make(measuring)
    given = estimator.covariance
    needs(given is not None, "it provides no covariance")
    assert given is not None
    expect(given.shape == (12, 12), f"covariance of the shape {given.shape}, expected (12, 12)")
    for k in range(0, STEPS):
        follow(estimator, measuring, range(k, k + 1), out)
        scale = np.sqrt(np.outer(np.diag(given), np.diag(given))) + TINY
        expect(estimator.covariance is given, "another array holds the covariance now")
        expect(np.isfinite(given).all() and (np.diag(given) >= 0.0).all(), f"variances {np.diag(given).tolist()}")
        expect((np.abs(given - given.T) <= ASYMMETRY * scale).all(), f"covariance not symmetric at step {k}")
        least = np.linalg.eigvalsh(given / scale).min()
        expect(least >= -INDEFINITE, f"eigenvalue {least:.3g} of the correlations at step {k}")
    return f"standard deviation of x {np.sqrt(given[0, 0]):.2g} m at the end"


def innovation_is_consistent(subject: EstimatorSubject) -> str:
    """If sensors have their declared noise, the mean normalised innovation squared per value is between 0.5 and 2.

    The attribute `nis` contains the normalised innovation squared of a sample, and `nis_size` the number of measured
    values in it. The mean per value is the sum of `nis` divided by the sum of `nis_size`. At samples without
    measurements, `nis` is NaN and `nis_size` is 0. Skipped if the estimator does not provide these attributes.
    """
    measuring = Measuring(motion(breaks=False), subject.sensors(noise=NOISE, period=2 * STEP))
    estimator, out = subject.make(measuring), np.full(13, np.nan)
    nis, size = estimator.nis, estimator.nis_size
    needs(nis is not None and size is not None, "it provides none")
    assert nis is not None
    assert size is not None
    total, values = 0.0, 0.0
    for k in range(STEPS):
        follow(estimator, measuring, range(k, k + 1), out)
        arrived = k % 2 == 0
        expect(arrived or (np.isnan(nis[0]) and size[0] == 0), f"nis {nis[0]:.3g} without a measurement")
        if size[0] > 0:
            expect(np.isfinite(nis[0]) and nis[0] >= 0.0, f"nis {nis[0]:.3g} of {size[0]:g} values")
            total, values = total + float(nis[0]), values + float(size[0])
    expect(values > 0.0, "no measurement was used")
    mean = total / values
    expect(NIS[0] <= mean <= NIS[1], f"mean {mean:.3g} per value")
    return f"mean {mean:.3g} per value"


def columns_are_written(subject: EstimatorSubject) -> str:
    """In each sample, the estimator writes finite numbers into all columns of the log that it declares.

    It writes nothing outside these columns. Skipped if it declares no columns.
    """
    measuring, out = Measuring(motion(breaks=False), subject.sensors(noise=NOISE)), np.full(13, np.nan)
    estimator = subject.make(measuring)

    def work(k: int) -> None:
        follow(estimator, measuring, range(k, k + 1), out)

    return expect_written(subject.columns, samples.braced(), estimator, estimator.reset, work)


CHECKS = [
    Check(function)
    for function in (
        estimate_is_complete,
        missing_sensors_are_reported,
        exact_measurements_are_followed,
        wrong_start_is_forgotten,
        late_measurements_are_used,
        cable_breaks,
        reset_forgets,
        snapshot_restores,
        compiled_operations_agree,
        covariance_is_valid,
        innovation_is_consistent,
        columns_are_written,
    )
]
