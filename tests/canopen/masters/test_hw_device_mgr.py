# SPDX-License-Identifier: Apache-2.0
"""The drive manager of a LinuxCNC controller, cycle by cycle: goal states, homing and moves on
request.

Modelled on tormach/hw_device_mgr: hw_device_mgr/cia_402/device.py (paths to a goal state, words
that hold a state, requests to home and to move) and mgr/mgr.py (init, start in two steps,
stop). It exchanges 6040h, 6060h and 607Ah against 6041h, 6061h and 6064h in each cycle;
LinuxCNC provides the position. Nothing of it is copied."""
import struct

import pytest
from can_client import RPDO, START, SYNC, TPDO

# Expected findings of the judge, with our explanation.
FINDINGS = {}

DISABLED, READY, SWITCHED_ON, ENABLED = "switch on disabled", "ready", "switched on", "enabled"
QUICK_STOP, FAULT, FAULT_REACTION, NOT_READY = "quick stop", "fault", "fault reaction", "not ready"

STATES = [  # mask and bits of the statusword
    (NOT_READY, 0x4F, 0x00), (DISABLED, 0x4F, 0x40), (READY, 0x6F, 0x21), (SWITCHED_ON, 0x6F, 0x23),
    (ENABLED, 0x6F, 0x27), (FAULT_REACTION, 0x4F, 0x0F), (FAULT, 0x4F, 0x08), (QUICK_STOP, 0x6F, 0x07)]

# The controlword for each state on the way to a goal, and the one that holds the goal.
COMMON = {NOT_READY: 0x00, FAULT_REACTION: 0x00, FAULT: 0x80, QUICK_STOP: 0x00}
PATHS = {
    SWITCHED_ON: {**COMMON, ENABLED: 0x02, DISABLED: 0x06, READY: 0x07, SWITCHED_ON: 0x07},
    ENABLED: {**COMMON, DISABLED: 0x06, READY: 0x07, SWITCHED_ON: 0x0F, ENABLED: 0x0F},
    DISABLED: {**COMMON, ENABLED: 0x02, DISABLED: 0x00, READY: 0x00, SWITCHED_ON: 0x00},
    FAULT: {NOT_READY: 0x00, FAULT_REACTION: 0x00, FAULT: 0x00, QUICK_STOP: 0x02, ENABLED: 0x02,
            DISABLED: 0x00, READY: 0x00, SWITCHED_ON: 0x00},
}
VOLTAGE, REACHED, MODE_SPECIFIC_1, MODE_SPECIFIC_2 = 0x0010, 0x0400, 0x1000, 0x2000
START_BIT = 0x0010  # of homing, and of a new set-point
PP, HM, CSP = 1, 6, 8
TIME_OF_A_GOAL, TIME_OF_A_REQUEST = 10.0, 15.0  # [s]


class Manager:
    def __init__(self, client, clock, node):
        self.client, self.clock, self.node = client, clock, node
        self.goal, self.mode_command = DISABLED, CSP
        self.requests_home, self.requests_move, self.begins_move = False, False, False
        self.target = 0
        self.acknowledged = False
        self.faults = []
        clock.boot()
        client.map_pdo(node, 0x1400, RPDO + node, [(0x6040, 0, 16), (0x6060, 0, 8), (0x607A, 0, 32)],
                       transmission=1)
        client.map_pdo(node, 0x1800, TPDO + node, [(0x6041, 0, 16), (0x6061, 0, 8), (0x6064, 0, 32)],
                       transmission=1)
        client.write(node, 0x60C2, 1, round(clock.period * 1000), 1)
        client.write(node, 0x60C2, 2, -3, 1)
        client.nmt(START, node)
        while not client.received[TPDO + node]:
            clock.cycle()

    @property
    def feedback(self):
        return struct.unpack("<Hbi", self.client.latest[TPDO + self.node])

    @property
    def state(self):
        word = self.feedback[0]
        return next(state for state, mask, bits in STATES if word & mask == bits)

    def cycle(self):
        """Evaluate feedback and faults; determine the next controlword and mode."""
        self.clock.cycle()
        word, mode, position = self.feedback
        state = self.state
        if self.goal in (SWITCHED_ON, ENABLED) and state != self.goal and not word & VOLTAGE:
            self.faults.append("enable command while no voltage at motor")
        if self.goal == ENABLED and not word & 0x0001:
            self.faults.append("enabled drive unexpectedly disabled")
        control = PATHS[self.goal][state]
        if self.requests_home:
            self.mode_command = HM
        if self.mode_command == HM and self.requests_home and mode == HM:
            control |= START_BIT
        if self.mode_command == PP and self.begins_move:
            control |= START_BIT  # for one cycle
            self.begins_move = False
        # LinuxCNC tracks the axis while it does not command it.
        if mode != PP and not (mode == CSP and state == ENABLED):
            self.target = position
        self.acknowledged = self.acknowledged or (mode == PP and bool(word & MODE_SPECIFIC_1))
        self.client.send(RPDO + self.node, struct.pack("<Hbi", control, self.mode_command, self.target))

    def run_until(self, condition, seconds=TIME_OF_A_GOAL):
        deadline = self.clock.deadline(seconds)
        while not condition():
            assert self.clock.now < deadline, f"goal {self.goal}: {self.state}, {self.feedback}"
            self.cycle()

    def reach(self, goal):
        self.goal = goal
        self.run_until(lambda: self.state == goal)

    def start(self):
        """The start command: all drives to Switched on, then to Operation enabled."""
        self.reach(SWITCHED_ON)
        self.reach(ENABLED)

    def stop(self):
        self.reach(DISABLED)

    def home(self):
        self.requests_home = True
        self.run_until(lambda: self.feedback[1] == HM)
        self.run_until(lambda: self.feedback[0] & (MODE_SPECIFIC_1 | MODE_SPECIFIC_2), TIME_OF_A_REQUEST)
        assert not self.feedback[0] & MODE_SPECIFIC_2, "homing error"
        self.run_until(lambda: self.feedback[0] & REACHED, TIME_OF_A_REQUEST)
        self.requests_home, self.mode_command = False, CSP
        self.run_until(lambda: self.feedback[1] == CSP)

    def move(self, target):
        self.mode_command = PP
        self.target = self.feedback[2]
        self.run_until(lambda: self.feedback[1] == PP)
        self.target, self.acknowledged = target, False
        self.requests_move = self.begins_move = True
        self.run_until(lambda: self.acknowledged and self.feedback[0] & REACHED, TIME_OF_A_REQUEST)
        self.requests_move = False


@pytest.fixture
def manager(client, clock, node):
    return Manager(client, clock, node)


def test_it_starts_in_two_steps_and_stops(manager):
    manager.start()
    for _ in range(20):
        manager.cycle()
    assert manager.state == ENABLED and manager.feedback[1] == CSP
    manager.stop()
    assert manager.faults == []


def test_it_homes_on_request_and_returns_to_cyclic_position(manager, client, node):
    client.write(node, 0x6098, 0, 37, 1)
    manager.start()
    manager.home()
    assert manager.state == ENABLED and manager.feedback[2] == 0
    assert manager.faults == []


def test_it_streams_positions_once_it_is_enabled(manager):
    manager.start()
    # 60C2h is 10 ms: steps of 20 UU are 2000 UU/s.
    begin = manager.target
    for step in range(1, 101):
        manager.target = begin + 20 * step
        manager.cycle()
    manager.run_until(lambda: abs(manager.feedback[2] - (begin + 2000)) <= 5)
    assert manager.state == ENABLED and manager.faults == []


def test_it_moves_on_request(manager):
    manager.start()
    manager.move(5000)
    assert manager.feedback[2] == 5000 and manager.state == ENABLED
    manager.move(-100)
    assert manager.feedback[2] == -100
    manager.stop()
    assert manager.faults == []


def test_its_start_resets_a_fault(manager, client, node):
    manager.start()
    client.write(node, 0x5E03, 0, 1, 1)  # over-temperature
    manager.goal = FAULT
    manager.run_until(lambda: manager.state == FAULT)
    client.write(node, 0x5E03, 0, 0, 1)
    manager.faults.clear()
    manager.start()
    assert manager.state == ENABLED


@pytest.mark.parametrize("bus", ["lockstep"], indirect=True)
def test_sync_is_its_only_clock(manager, client):
    seen = client.received[TPDO + manager.node]
    for _ in range(10):
        manager.cycle()
    # One TPDO per SYNC: the node sends nothing else.
    assert client.received[TPDO + manager.node] == seen + 10
    assert client.received[SYNC] == 0, "the own frames come back"
