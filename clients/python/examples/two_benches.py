#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A gantry of two benches on one clock.

    two_benches.py [local|dds]

Each beam has its own bench, as each has its own control cabinet. One session finds both, a step clock
lets the same drive time pass on both, and a group moves one axis of each along a straight line: both
arrive in one tick. In lock-step each run prints the same numbers, in this process (local, the default)
and with two services over DDS.
"""
import sys

import vdrive

over = sys.argv[1] if len(sys.argv) > 1 else "local"

with vdrive.Bench(axes=1, over=over) as left, \
        vdrive.Bench(axes=1, over=over, number=2, beside=left), left.session() as session:
    with vdrive.StepClock(session, [1, 2]) as clock:
        print("ticks of the benches after 10 ms:", clock.step_for(0.010))

    gantry = vdrive.AxisGroup(session, ["1.1", "2.1"])
    gantry.enable_all()
    widest = 0.0

    def note(tick, fraction):
        global widest
        first, second = gantry.status().demand
        widest = max(widest, abs(first - second))

    gantry.move_together([8192, 8192], progress=note)
    print("positions:", gantry.status().actual.tolist(), "widest gap of the demands:", widest)

    # A fault of one beam stops the other, because the group monitors both benches.
    session.axis("2.1").disturb("over_current")
    try:
        gantry.move_together([0, 0])
    except vdrive.Failed as failure:
        print("stopped:", failure)
    print("state of the group:", gantry.status().state)
