# SPDX-License-Identifier: Apache-2.0
"""Masters on CANopenNode, whose blocking SDO client polls the drive.

Modelled on wdfk-prog/canopennode-rtt: profile/cia402/controller/CO_402_controller.c and
CO_402_controller_client.c (each step reads 6041h and 6040h, changes 6040h under a mask and
writes it); and on CORLR/arm_control_V2: user_code/arm_control/arm_control.c
(hechuan_motor_setpos, canopen_init_hechuan: modes, ramps and moves by SDO alone, 10 ms per
access). Nothing of it is copied."""
import pytest
from can_client import SdoAbort, START

# Expected findings of the judge, with our explanation.
FINDINGS = {
    "handshake-1": "arm_control raises bit 4 10 ms after it has dropped it, without a look at bit 12",
    "handshake-5": "after a fault it goes on with 001Fh, whatever 6041h shows",
    "mode-3": "arm_control does not look at 6061h",
    "state-3": "after a fault it sends 000Fh in Switch on disabled",
}

FAULT, POWER_BITS = 0x0008, 0x008F
STATES = [
    ("not ready", 0x4F, 0x00), ("switch on disabled", 0x4F, 0x40), ("ready", 0x6F, 0x21),
    ("switched on", 0x6F, 0x23), ("enabled", 0x6F, 0x27), ("quick stop", 0x6F, 0x07),
    ("fault reaction", 0x4F, 0x0F), ("fault", 0x4F, 0x08)]
TIME_OF_A_TRANSITION = 1.0  # [s]


class Sequencer:
    """Steps of the controller: one transition of the power state machine at a time."""

    COMMANDS = {
        "enabled": {"switch on disabled": 0x06, "ready": 0x07, "switched on": 0x0F},
        "switched on": {"switch on disabled": 0x06, "ready": 0x07, "enabled": 0x07},
        "ready": {"switch on disabled": 0x06, "switched on": 0x06, "enabled": 0x06},
        "switch on disabled": {"ready": 0x00, "switched on": 0x00, "enabled": 0x00, "quick stop": 0x00},
        "quick stop": {"enabled": 0x02},
    }

    def __init__(self, client, clock, node):
        self.client, self.clock, self.node = client, clock, node

    @property
    def state(self):
        word = self.client.read(self.node, 0x6041)
        return next(state for state, mask, bits in STATES if word & mask == bits)

    def command(self, power_bits):
        """Write the power bits; the mode-specific bits belong to the application."""
        word = self.client.read(self.node, 0x6040)
        self.client.write(self.node, 0x6040, 0, word & ~POWER_BITS | power_bits, 2)

    def reach(self, *targets):
        """Step until one of the targets is reached; the first one is the wanted state."""
        commands = self.COMMANDS[targets[0]]
        last, deadline = None, 0.0
        while (state := self.state) not in targets:
            if state != last:
                last, deadline = state, self.clock.deadline(TIME_OF_A_TRANSITION)
            assert self.clock.now < deadline, f"transition timeout in {state}"
            if state in commands:
                self.command(commands[state])
            self.clock.cycle()

    def reset_fault(self):
        """A pulse of bit 7, whose falling edge is written in any case."""
        assert self.state == "fault"
        self.command(0x80)
        self.clock.cycle()
        self.command(0x00)
        self.clock.cycle()


@pytest.fixture
def sequencer(client, clock, node):
    client.nmt(START, node)
    return Sequencer(client, clock, node)


def test_the_sequencer_reaches_each_of_its_targets(sequencer):
    for target in ("enabled", "switched on", "ready", "enabled", "switch on disabled"):
        sequencer.reach(target)
    sequencer.reach("enabled")
    # 605Ah = 2: Quick stop active lasts until the axis is at rest, here less than a step.
    sequencer.reach("quick stop", "switch on disabled")
    sequencer.reach("switch on disabled")


def test_the_sequencer_leaves_the_bits_of_the_mode_alone(sequencer, client, clock, node):
    client.write(node, 0x6040, 0, 0x0020, 2)  # change set immediately
    clock.cycle()
    sequencer.reach("enabled")
    assert client.read(node, 0x6040) == 0x002F


def test_the_sequencer_resets_a_fault_once_it_is_asked_to(sequencer, client, clock, node):
    sequencer.reach("enabled")
    client.write(node, 0x5E03, 0, 1, 1)  # over-temperature
    deadline = clock.deadline(5.0)
    while sequencer.state != "fault":
        assert clock.now < deadline
        clock.cycle()
    client.write(node, 0x5E03, 0, 0, 1)
    sequencer.reset_fault()
    assert sequencer.state == "switch on disabled"
    sequencer.reach("enabled")


class PollingArm:
    """A joint of the arm: SDO only, and the result of a write is not checked."""

    def __init__(self, client, clock, node):
        self.client, self.clock, self.node = client, clock, node
        self.aborts = []

    def write(self, index, value, size):
        try:
            self.client.write(self.node, index, 0, value, size)
        except SdoAbort as abort:
            self.aborts.append(abort.code)
        self.clock.cycle()  # its client waits 10 ms per access

    def read(self, index, signed=False):
        value = self.client.read(self.node, index, signed=signed)
        self.clock.cycle()
        return value

    def init(self):
        for index, value, size in ((0x607F, 3_000_000, 4), (0x6080, 3_000_000, 4), (0x6060, 1, 1),
                                   (0x6083, 3_000_000, 4), (0x6084, 3_000_000, 4), (0x6081, 2_000_000, 4),
                                   (0x6040, 0x06, 2), (0x6040, 0x07, 2), (0x6040, 0x0F, 2)):
            self.write(index, value, size)

    def set_position(self, target):
        status = self.read(0x6041)
        if status & FAULT:
            self.write(0x6040, 0x80, 2)
            return False
        if status & 0x07 != 0x07:
            self.write(0x6040, 0x0F, 2)
        self.write(0x607A, target, 4)
        self.write(0x6040, 0x0F, 2)
        self.write(0x6040, 0x3F, 2)
        return True


@pytest.fixture
def arm(client, clock, node):
    return PollingArm(client, clock, node)


def arrive(arm, target):
    deadline = arm.clock.deadline(5.0)
    while arm.read(0x6064, signed=True) != target:
        assert arm.clock.now < deadline


def test_the_arm_moves_by_sdo_alone_in_pre_operational(arm):
    arm.init()
    assert arm.aborts == []
    for target in (8000, -3000, 0):
        assert arm.set_position(target)
        arrive(arm, target)


def test_the_arm_goes_on_after_a_fault(arm, client, clock, node):
    arm.init()
    client.write(node, 0x5E02, 0, 1, 1)  # over-current
    deadline = clock.deadline(5.0)
    while not arm.read(0x6041) & FAULT:
        assert clock.now < deadline
    client.write(node, 0x5E02, 0, 0, 1)
    # It resets the fault and tries to enable with 000Fh alone, which the drive takes in Switch on
    # disabled.
    while not arm.set_position(2000):
        assert clock.now < deadline
    arrive(arm, 2000)


def test_a_write_of_a_wrong_length_is_answered_and_changes_nothing(arm, client, node):
    # The earlier version of the arm writes 6081h with 3 bytes and 6060h with 2.
    before = client.read(node, 0x6081)
    arm.write(0x6081, 0x0C3500, 3)
    arm.write(0x6060, 1, 2)
    assert arm.aborts == [0x06070013, 0x06070012]
    assert client.read(node, 0x6081) == before and client.read(node, 0x6060) == 0
