# SPDX-License-Identifier: Apache-2.0
"""The CiA 402 master of ROS 2, frame by frame: homing during initialisation, halt whenever it
idles.

Modelled on ros-industrial/ros2_canopen: canopen_402_driver/src/motor.cpp (Motor402),
command.cpp, state.cpp, default_homing_mode.cpp,
include/canopen_402_driver/profiled_position_mode.hpp; PDOs, parameters and the period of 10 ms
of canopen_tests/config/cia402/bus.yml. Nothing of it is copied."""
import struct

import pytest
from can_client import NOT_VALID, RPDO, START, TPDO

# Expected findings of the judge, with our explanation.
FINDINGS = {
    "mode-1": "Motor402 commands halt whenever it idles, and writes 6060h during that halt: some drives refuse it",
}

SWITCH_ON, ENABLE_VOLTAGE, QUICK_STOP, ENABLE_OPERATION = 0x0001, 0x0002, 0x0004, 0x0008
MODE_BITS, NEW_SET_POINT, IMMEDIATELY, START_HOMING = 0x0070, 0x0010, 0x0020, 0x0010
FAULT_RESET, HALT = 0x0080, 0x0100
REACHED, MODE_SPECIFIC_0, MODE_SPECIFIC_1 = 0x0400, 0x1000, 0x2000

# Statusword with and without bit 5, under the mask 006Fh.
STATES = {
    0x00: "not ready", 0x20: "not ready", 0x40: "switch on disabled", 0x60: "switch on disabled",
    0x21: "ready", 0x23: "switched on", 0x27: "enabled", 0x07: "quick stop",
    0x0F: "fault reaction", 0x2F: "fault reaction", 0x08: "fault", 0x28: "fault"}

# Steps to Operation enabled: the bits of the controlword to set, and those to clear.
SHUTDOWN = (QUICK_STOP | ENABLE_VOLTAGE, FAULT_RESET | SWITCH_ON)
STEPS = {
    "switch on disabled": ("ready", SHUTDOWN),
    "ready": ("switched on", (QUICK_STOP | ENABLE_VOLTAGE | SWITCH_ON, FAULT_RESET | ENABLE_OPERATION)),
    "switched on": ("enabled", (QUICK_STOP | ENABLE_VOLTAGE | SWITCH_ON | ENABLE_OPERATION, FAULT_RESET)),
    "quick stop": ("enabled", (QUICK_STOP | ENABLE_VOLTAGE | SWITCH_ON | ENABLE_OPERATION, FAULT_RESET)),
    "fault": ("switch on disabled", (FAULT_RESET, 0)),
    "fault reaction": ("fault", (0, 0)),
    "not ready": ("switch on disabled", (0, 0)),
}
DISABLE_VOLTAGE = (0, FAULT_RESET | ENABLE_VOLTAGE)
TIME_OF_A_STATE = 5.0  # [s]
TIME_TO_START_HOMING = 1.0
TIME_OF_HOMING = 10.0


class Motor402:
    def __init__(self, client, clock, node):
        self.client, self.clock, self.node = client, clock, node
        self.controlword, self.mode_command, self.selected = 0, 0, None
        self.resets_fault = False
        self.is_homing = False
        self.target, self.sent_target = None, None
        self.sent = []

    # Values of objects; mapped ones arrive by PDO.

    @property
    def statusword(self):
        return struct.unpack("<H", self.client.latest[TPDO + self.node][:2])[0]

    @property
    def mode(self):
        return struct.unpack("<b", self.client.latest[TPDO + self.node][2:])[0]

    @property
    def position(self):
        return struct.unpack("<i", self.client.latest[TPDO + 0x100 + self.node][:4])[0]

    @property
    def state(self):
        return STATES.get(self.statusword & 0x6F, "unknown")

    def configure(self):
        """The writes of the master at boot-up, in the order of the bus file."""
        client, node = self.client, self.node
        self.clock.boot()
        for index, sub, value, size in ((0x60C2, 1, 50, 1), (0x60C2, 2, -3, 1), (0x6081, 0, 1000, 4),
                                        (0x6083, 0, 2000, 4)):
            client.write(node, index, sub, value, size)
        client.map_pdo(node, 0x1800, TPDO + node, [(0x6041, 0, 16), (0x6061, 0, 8)], transmission=1)
        client.map_pdo(node, 0x1801, TPDO + 0x100 + node, [(0x6064, 0, 32), (0x606C, 0, 32)], transmission=1)
        for place in (2, 3):
            client.write(node, 0x1800 + place, 1, NOT_VALID | TPDO + place * 0x100 + node, 4)
        client.map_pdo(node, 0x1400, RPDO + node, [(0x6040, 0, 16), (0x6060, 0, 8)])
        client.map_pdo(node, 0x1401, RPDO + 0x100 + node, [(0x607A, 0, 32), (0x60FF, 0, 32)])
        client.nmt(START, node)
        # The TPDOs of the first SYNC.
        while not client.received[TPDO + node]:
            self.clock.cycle()

    # Its cycle.

    def cycle(self):
        """SYNC and its TPDOs, then the writes of each period."""
        self.clock.cycle()
        self.controlword |= HALT
        if self.state == "enabled":
            if self.selected is None or self.selected != self.mode:
                self.controlword &= ~MODE_BITS
            elif self.write_mode():
                self.controlword &= ~HALT
        word = self.controlword & ~FAULT_RESET if self.resets_fault else self.controlword
        self.resets_fault = False
        self.sent.append(word)
        self.client.send(RPDO + self.node, struct.pack("<Hb", word, self.mode_command))

    def write_mode(self):
        """Set the mode-specific bits. Return whether the axis is to move."""
        if self.selected == 6:
            self.controlword = self.controlword & ~MODE_BITS | (START_HOMING if self.is_homing else 0)
            return self.is_homing
        self.controlword |= IMMEDIATELY
        if self.target is None:
            return False
        if self.statusword & MODE_SPECIFIC_0:  # set-point acknowledge
            self.controlword &= ~NEW_SET_POINT
        elif self.target != self.sent_target and self.controlword & NEW_SET_POINT:
            self.controlword &= ~NEW_SET_POINT
        elif self.target != self.sent_target:
            self.client.send(RPDO + 0x100 + self.node, struct.pack("<ii", self.target, 0))
            self.controlword |= NEW_SET_POINT
            self.sent_target = self.target
        return True

    def wait_until(self, condition, seconds, what):
        deadline = self.clock.deadline(seconds)
        while not condition():
            assert self.clock.now < deadline, f"{what}: 6041h = 0x{self.statusword:04X}, 6061h = {self.mode}"
            self.cycle()

    def switch_state(self, target):
        deadline = self.clock.deadline(TIME_OF_A_STATE)
        while (state := self.state) != target:
            ups, downs = STEPS[state][1] if target == "enabled" else DISABLE_VOLTAGE
            self.controlword = self.controlword & ~downs | ups
            while self.state == state:
                assert self.clock.now < deadline, f"transition from {state} timed out"
                self.cycle()

    def switch_mode(self, mode):
        self.selected = None
        self.mode_command = mode
        if mode == 0:
            return
        assert self.client.read(self.node, 0x6502) >> mode - 1 & 1, "mode is not supported"
        self.switch_state("enabled")
        self.wait_until(lambda: self.mode == mode, 5.0, "mode switch timed out")
        self.selected, self.target, self.sent_target = mode, None, None

    # Services.

    def init(self):
        self.controlword, self.resets_fault = 0, True
        self.switch_state("enabled")
        self.switch_mode(6)
        self.execute_homing()
        self.switch_mode(0)

    def execute_homing(self):
        if self.client.read(self.node, 0x6098, signed=True) == 0:
            return
        begin = self.clock.now
        self.wait_until(lambda: self.statusword & (REACHED | MODE_SPECIFIC_1), TIME_TO_START_HOMING,
                        "could not prepare homing")
        assert not self.statusword & MODE_SPECIFIC_1, "homing error before start"
        self.is_homing = True
        bits = REACHED | MODE_SPECIFIC_0 | MODE_SPECIFIC_1
        self.wait_until(lambda: self.statusword & bits != REACHED,
                        TIME_TO_START_HOMING - (self.clock.now - begin), "homing did not start")
        self.wait_until(lambda: self.statusword & (MODE_SPECIFIC_0 | MODE_SPECIFIC_1), TIME_OF_HOMING,
                        "homing not attained")
        assert not self.statusword & MODE_SPECIFIC_1, "homing error during process"
        self.wait_until(lambda: self.statusword & (REACHED | MODE_SPECIFIC_1), TIME_OF_HOMING,
                        "homing did not stop")
        assert self.statusword & bits == REACHED | MODE_SPECIFIC_0
        self.is_homing = False

    def recover(self):
        self.resets_fault = True
        self.switch_state("enabled")

    def halt(self):
        """The service of this name is a quick stop."""
        self.controlword = self.controlword & ~(FAULT_RESET | QUICK_STOP) | ENABLE_VOLTAGE


@pytest.fixture
def motor(client, clock, node):
    motor = Motor402(client, clock, node)
    motor.configure()
    return motor


def test_it_homes_at_its_initialisation_and_reaches_its_target(motor):
    motor.init()
    # Halt while it idles: bit 8 is set in each word except those that home.
    assert all(word & HALT for word in motor.sent if not word & START_HOMING)
    motor.switch_mode(1)
    motor.target = 300  # at 6083h = 2000 UU/s^2 it takes less than a second
    motor.wait_until(lambda: motor.position == 300 and motor.statusword & REACHED, 5.0, "target")
    motor.target = -200
    motor.wait_until(lambda: motor.position == -200 and motor.statusword & REACHED, 5.0, "second target")
    motor.switch_mode(0)
    motor.switch_state("switch on disabled")


def test_it_homes_by_a_search_of_the_index_pulse(motor, client, node):
    # Method 34: the next index pulse in positive direction, at most a revolution away. First, the
    # axis is moved off the pulse it is on.
    client.write(node, 0x6098, 0, 34, 1)
    motor.init()
    # The demand (6062h) is exactly at home; the servo holds the axis within the window of bit 10.
    assert client.read(node, 0x6062, signed=True) == client.read(node, 0x607C, signed=True) == 0
    assert abs(motor.position) <= client.read(node, 0x6067)
    assert motor.state == "enabled"


def test_it_leaves_homing_out_for_method_0(motor, client, node):
    client.write(node, 0x6098, 0, 0, 1)
    motor.init()
    assert motor.state == "enabled" and not any(word & START_HOMING for word in motor.sent)


def test_it_recovers_from_a_fault(motor, client, node):
    motor.init()
    client.write(node, 0x5E02, 0, 1, 1)  # over-current
    motor.wait_until(lambda: motor.state == "fault", 5.0, "fault")
    client.write(node, 0x5E02, 0, 0, 1)
    motor.recover()
    assert motor.state == "enabled"


def test_its_halt_is_a_quick_stop(motor):
    motor.init()
    motor.switch_mode(1)
    motor.target = 100000
    motor.wait_until(lambda: motor.position > 100, 5.0, "motion")
    motor.halt()
    # 605Ah = 2: at rest, the drive changes from Quick stop active to Switch on disabled on its own.
    motor.wait_until(lambda: motor.state == "switch on disabled", 5.0, "quick stop")
