#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A master of your own that sends positions ahead of time.

    set_points.py [local|dds]

Each position is sent for the tick in which it takes effect (cyclic synchronous position, 6060h = 8).
No call waits for an answer: the status shows the effect of the set-points, events tell why one was
refused. In lock-step each run prints the same numbers.
"""
import math
import sys

import vdrive

TICKS = 2000  # of 1 ms
AHEAD = 100  # set-points sent at a time; a bench keeps 1,024, up to 10 s
DISTANCE = 4096  # UU


def offset_at(tick):
    """Return a point of a smooth path over DISTANCE, which starts and ends at rest."""
    return round(DISTANCE * (1 - math.cos(math.pi * tick / TICKS)) / 2)


def main():
    over = sys.argv[1] if len(sys.argv) > 1 else "local"
    with vdrive.Bench(axes=1, over=over) as bench, bench.session() as session:
        axis = session.axis("1.1")
        axis.enable()
        # The mode changes only while the axis is at rest. The path starts where the axis is then.
        mode = vdrive.OperatingMode.CYCLIC_SYNCHRONOUS_POSITION
        session.send_set_points({1: {"op_mode_cmd": mode}})
        start = axis.wait_until(lambda status: status.op_mode_actual == mode, timeout=1)
        follower = session.follow(axis)
        missed = 0
        for sent in range(0, TICKS, AHEAD):
            for tick in range(sent + 1, sent + AHEAD + 1):
                session.send_set_points({1: {"position_user_target_value": start.demand + offset_at(tick)}},
                                        tick=start.tick + tick)
            demands = follower.take(AHEAD)["position_demand_value"][:, 0]  # steps one tick per sample
            wanted = [start.demand + offset_at(sent + 1 + place) for place in range(AHEAD)]
            missed += int((demands != wanted).sum())
        session.wait(0.2)
        print(f"{TICKS} set-points, {missed} not followed, at {axis.status().position}")
        axis.disable()


if __name__ == "__main__":
    main()
