"""Configurations of printer firmware for tests."""

from __future__ import annotations

# Anchors, spools and advantages as calibration programs write them.
RRF = """\
; Configuration file
M550 P"Hang; M669 K1"
M669 K6                         ; Hangprinter
M584 A40.0 B41.0 C42.0 D43.0 P4
M669 P2000.0 (M666 S1)
M669 S430 T0.1
M669 A0.0:-1610.98:-131.53 B1314.22:1268.14:-121.28 C-1415.73:707.61:-121.82 D-0.00:0.01:2299.83
M666 Q0.128181 R75.546:75.659:76.128:75.192
M666 U2:2:2:4
M666 L20:20:20:20 H255:255:255:255 J25:25:25:25 O1:1:1:1
M666 W1.5 S21000 I5:5:5:0 X80:80:80:120
M203 X36000 Y36000
M98 P"homeall.g"
T0
"""
KLIPPER = """\
[stepper_a]
step_pin: PF0
microsteps: 16
rotation_distance: 40
anchor_x: 0
anchor_y: -2000
anchor_z: -100   # low
[stepper_b]
rotation_distance = 40
anchor_x: 2000
anchor_y: 1000
anchor_z: -100
[stepper_c]
rotation_distance: 50
anchor_x: -2000
anchor_y: 1000
anchor_z: -100 ; low
[stepper_d]
rotation_distance: 40
anchor_x: 0
anchor_y: 0
anchor_z: 3000
[include mainsail.cfg]
[printer]
kinematics: winch
max_velocity: 100
[gcode_macro X]
gcode:
    G28
    M117 a: b
#*# <---------------------- SAVE_CONFIG ---------------------->
#*# DO NOT EDIT THIS BLOCK OR BELOW. The contents are auto-generated.
#*#
#*# [stepper_d]
#*# anchor_z = 2900
"""
