#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A two-joint arm with its dynamics computed in Python, on two axes in lock-step.

In each tick this program takes the angles and speeds of the joints, calculates the torques that the arm
needs (inertia, Coriolis and centrifugal forces, gravity) and applies them to the shafts of the axes as
load (5E00h). In each tick it checks two energy balances against closed forms:

  arm     work of the shafts on the arm  =  change of its kinetic and potential energy
  drives  work of the motors  =  the same, plus the energy of the rotors and the friction losses

    two_joint_arm.py        runs twice, compares every bit, prints the balances

Exit code 0: both balances hold to within 2 % of the energy that moved, and both runs are identical.
"""
import hashlib
import math
import pathlib
import sys
import tempfile

import numpy
import vdrive

GRAVITY = 9.81  # m/s^2
PERIOD = 0.001  # s
UNITS = 4096 / (2 * math.pi)  # user units per radian
GEAR = 100  # motor turns per joint turn
ROTOR = 3.0e-4  # kg.m2
VISCOUS = 2.0e-4  # N.m.s/rad, at the motor
COULOMB = 0.01  # N.m, at the motor
RATED_TORQUE = 3.0  # N.m, motor
TARGET_REACHED = 1 << 10
MOTION = [name for name in vdrive.record_type().names if not name.startswith("owner")]

BENCH = "bench: {name: arm}\naxes:\n" + "".join(f"""\
  - number: {number}
    name: {name}
    model: {{motor_inertia: {ROTOR}, viscous_friction: {VISCOUS}, coulomb_friction: {COULOMB}}}
    parameters: {{gear_ratio_numerator: 1, gear_ratio_denominator: {GEAR},
                 profile_velocity: 600, profile_acceleration: 3000, profile_deceleration: 3000}}
""" for number, name in ((1, "shoulder"), (2, "elbow")))


class Arm:
    """Two uniform rods. Both angles are 0 when the arm hangs; the second is relative to the first rod."""

    def __init__(self, masses=(1.5, 1.0), lengths=(0.4, 0.3)):
        (self.m1, self.m2), (self.l1, self.l2) = masses, lengths
        self.c1, self.c2 = self.l1 / 2, self.l2 / 2  # centres of mass
        self.i1, self.i2 = self.m1 * self.l1**2 / 12, self.m2 * self.l2**2 / 12

    def inertia(self, q):
        """The mass matrix, in kg.m2."""
        coupling = self.m2 * self.l1 * self.c2 * math.cos(q[1])
        second = self.i2 + self.m2 * self.c2**2
        first = self.i1 + self.m1 * self.c1**2 + self.m2 * self.l1**2 + second + 2 * coupling
        return numpy.array([[first, second + coupling], [second + coupling, second]])

    def torque(self, q, speed, acceleration):
        """The torques that the shafts must deliver for this motion, in N.m."""
        bend = self.m2 * self.l1 * self.c2 * math.sin(q[1])
        coriolis = numpy.array([-bend * (2 * speed[0] * speed[1] + speed[1]**2), bend * speed[0]**2])
        outer = self.m2 * self.c2 * math.sin(q[0] + q[1])
        gravity = GRAVITY * numpy.array(
            [(self.m1 * self.c1 + self.m2 * self.l1) * math.sin(q[0]) + outer, outer])
        return self.inertia(q) @ acceleration + coriolis + gravity

    def energy(self, q, speed):
        """Kinetic and potential energy in closed form, in J."""
        height = -(self.m1 * self.c1 + self.m2 * self.l1) * math.cos(q[0]) \
            - self.m2 * self.c2 * math.cos(q[0] + q[1])
        return 0.5 * speed @ self.inertia(q) @ speed + GRAVITY * height


class Balance:
    """The work done so far, and the energies that it must equal."""

    def __init__(self, arm, q, speed):
        self.arm, self.q, self.speed = arm, q, speed
        self.begin = arm.energy(q, speed)
        self.on_arm = self.of_motors = self.friction = 0.0
        self.highest = self.worst_of_arm = self.worst_of_drives = 0.0

    def add(self, q, speed, on_arm, of_motors):
        """Add a tick. on_arm, of_motors: the torques during the tick, at the joints."""
        way, middle = q - self.q, (speed + self.speed) / 2
        self.on_arm += on_arm @ way
        self.of_motors += of_motors @ way
        self.friction += numpy.sum(
            GEAR**2 * VISCOUS * middle**2 + GEAR * COULOMB * abs(middle)) * PERIOD
        self.q, self.speed = q, speed
        gained = self.arm.energy(q, speed) - self.begin
        rotors = 0.5 * ROTOR * GEAR**2 * speed @ speed
        self.highest = max(self.highest, abs(gained) + rotors + self.friction)
        self.worst_of_arm = max(self.worst_of_arm, abs(self.on_arm - gained))
        self.worst_of_drives = max(
            self.worst_of_drives, abs(self.of_motors - gained - rotors - self.friction))


def run():
    """Move the arm out and back; return the balance and every bit of the motion."""
    arm = Arm()
    with tempfile.TemporaryDirectory() as directory:
        config = pathlib.Path(directory) / "arm.yaml"
        config.write_text(BENCH)
        with vdrive.Bench(config=config) as bench, bench.session() as session:
            return swing(arm, session)


def swing(arm, session):
    axes = [session.axis("shoulder"), session.axis("elbow")]
    group = vdrive.AxisGroup(session, axes)
    group.enable_all()
    bits = hashlib.sha256()
    speeds = [numpy.zeros(2)]
    torque = numpy.zeros(2)
    balance = Balance(arm, numpy.zeros(2), numpy.zeros(2))
    for degrees in ((90, 60), (20, -100), (0, 0)):
        group.move_together(numpy.rint(numpy.array(degrees) / 360 * 4096), until="in_force")
        for sample in session.follow(axes):
            frame = sample.array()
            # Without the owner, which is a random session number.
            for name in MOTION:
                bits.update(frame[name].tobytes())
            q = frame["load_position_actual_value"] / UNITS
            speed = frame["load_velocity_actual_value"] / UNITS
            balance.add(q, speed, torque,
                        frame["torque_actual_value"] / 1000 * RATED_TORQUE * GEAR)
            # Speeds are whole user units per second, so the acceleration is the slope over 10 ms.
            speeds = (speeds + [speed])[-11:]
            acceleration = (speed - speeds[0]) / (PERIOD * max(1, len(speeds) - 1))
            torque = arm.torque(q, speed, acceleration)
            for axis, load in zip(axes, torque):
                axis.disturb("load_torque", round(-1000 * load))  # mN.m, against the motion
            if all(frame["ds402_statusword"] & TARGET_REACHED):
                break
    return balance, bits.hexdigest()


def main():
    first, second = run(), run()
    balance = first[0]
    arm, drives = balance.worst_of_arm / balance.highest, balance.worst_of_drives / balance.highest
    print(f"energy that moved      {balance.highest:8.3f} J")
    print(f"balance of the arm     {balance.worst_of_arm:8.3f} J   {100 * arm:.2f} %")
    print(f"balance of the drives  {balance.worst_of_drives:8.3f} J   {100 * drives:.2f} %")
    print(f"bits of the first run  {first[1]}")
    print(f"bits of the second run {second[1]}")
    return 0 if arm < 0.02 and drives < 0.02 and first[1] == second[1] else 1


if __name__ == "__main__":
    sys.exit(main())
