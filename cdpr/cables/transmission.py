"""Transmission between the motor of a winch and its cable: gear, drum with layers, and block and tackle.

The unwound length U (m) is that of the cable between frame and platform, L its path at the home pose. With r_0 the
`drum_radius`, g the `drum_growth` (m^2/m, so m), n the `lines` and k the `reeving`, the drum has the radius r, and w is
its speed, positive when winding in:

    r^2 = r_0^2 + g n k (L - U),   U' = -(r / k) w,   angle = 2 k (L - U) / (r_0 + r).

- **Layers.** Measure r_0, to the middle of the cable, while the platform is at the home pose. A cable of diameter d
  that fills a drum of width b without gaps has g = d^2 / (4 b); if each turn takes a square, g = d^2 / (pi b). `lines`
  wound side by side grow the drum together. RepRapFirmware's `M666` has r_0 = R, g = Q, n = O and k = U, in mm.
- **Block and tackle.** It is an equivalent cable: its tension is the sum of all k falls on the platform, the drum pulls
  with 1 / k of it and winds k times its change of length. Give `axial_stiffness` and `linear_density` of all falls, k
  times those of the line. The part of the line between drum and tackle does not stretch.
- **Losses.** With the `efficiency` e of gear, drum and tackle, the torque that moves the cable with the tension T is

      (r / k) T (1 + e + s) / (1 + e - s),   s = (1 - e) tanh(w / w_c),

  which is r T / (k e) when winding in and r T e / k when the cable drives the drum back; w_c is `coulomb_speed`.
- **Gear.** The motor turns `gear_ratio` times per turn of the drum. Inertia, friction, gains and torques of winches
  refer to the drum's axis; the ratio concerns the steps of steppers, and the figures of the motor's shaft.

If the cable does not stretch, l' = -(r / k) w still holds, so that w' contains the change of r.
"""

from __future__ import annotations

from cdpr.base.fields import AtLeastOne, Efficiency, NonNegative, Positive
from cdpr.cables.chain import Number

COULOMB_SPEED = Number(
    "winch.coulomb_speed",
    Positive,
    "rad/s",
    "drum speed at which Coulomb friction reaches 76 % of its value: it grows as tanh(speed / this)",
    0.1,
)
GEAR_RATIO = Number("winch.gear_ratio", Positive, "", "turns of the motor per turn of the drum", 1.0)
EFFICIENCY = Number("winch.efficiency", Efficiency, "", "efficiency of gear, drum and tackle, from 0 to 1", 1.0)
GROWTH = Number(
    "winch.drum_growth", NonNegative, "m", "growth of the squared drum radius per length wound, m^2 per m", 0.0
)
LINES = Number("winch.lines", AtLeastOne, "", "lines wound side by side on the drum, which let it grow together", 1.0)
REEVING = Number("winch.reeving", AtLeastOne, "", "falls of a block and tackle between frame and platform", 1.0)

KERNEL = (EFFICIENCY, COULOMB_SPEED, GROWTH, LINES, REEVING)  # numbers of transmission.hpp, before the home length
GEOMETRY = (GEAR_RATIO, GROWTH, LINES, REEVING)  # without losses
TRANSMISSION = (*GEOMETRY, EFFICIENCY)  # accepted by winches
