# SPDX-License-Identifier: Apache-2.0
"""The function blocks of OpenSML, a motion library for PLCs, in a task of 10 ms.

Modelled on feecat/OpenSML: src/OpenSML_Power.txt, OpenSML_Home.txt,
OpenSML_ProfilePosition.txt, OpenSML_Stop.txt and OpenSML_Axis.txt (the process image). Nothing
of it is copied."""
import struct

import pytest
from can_client import RPDO, START, TPDO

# Expected findings of the judge, with our explanation.
FINDINGS = {}

ERROR = 999  # state of a block


class Timer:
    """TON: true once its input has been true for a time."""

    def __init__(self, clock):
        self._clock, self._since = clock, None

    def __call__(self, is_on, seconds=0.0):
        if not is_on:
            self._since = None
            return False
        if self._since is None:
            self._since = self._clock.now
        return self._clock.now - self._since >= seconds


class Axis:
    """The process image, exchanged once a cycle."""

    def __init__(self, client, clock, node):
        self.client, self.clock, self.node = client, clock, node
        self.controlword, self.mode, self.target, self.velocity = 0, 0, 0, 0
        self.statusword, self.mode_display, self.position = 0, 0, 0
        clock.boot()
        client.map_pdo(node, 0x1400, RPDO + node, [(0x6040, 0, 16), (0x6060, 0, 8), (0x607A, 0, 32)])
        client.map_pdo(node, 0x1401, RPDO + 0x100 + node, [(0x6081, 0, 32)])
        client.map_pdo(node, 0x1800, TPDO + node, [(0x6041, 0, 16), (0x6061, 0, 8), (0x6064, 0, 32)],
                       inhibit=20)
        client.nmt(START, node)

    def bit(self, number):
        return bool(self.statusword >> number & 1)

    def set(self, number, is_up):
        self.controlword = self.controlword & ~(1 << number) | is_up << number

    def exchange(self):
        """Write the outputs of this cycle and read the inputs of the next one."""
        self.client.send(RPDO + 0x100 + self.node, struct.pack("<I", self.velocity))
        self.client.send(RPDO + self.node, struct.pack("<Hbi", self.controlword, self.mode, self.target))
        self.clock.cycle()
        data = self.client.latest.get(TPDO + self.node)
        if data is not None:
            self.statusword, self.mode_display, self.position = struct.unpack("<Hbi", data)


class Block:
    def __init__(self, axis):
        self.axis, self.state, self.is_done, self.has_error = axis, 0, False, False
        self.timer = Timer(axis.clock)

    def go(self, state):
        self.timer(False)
        self.state = state


class Power(Block):
    TIME_OUT = 0.5  # [s]

    def __call__(self, enable, emergency_stop=True):
        axis = self.axis
        axis.set(2, emergency_stop)
        if self.state == 0:
            self.is_done = self.has_error = False
            for number in (0, 1, 3, 7):
                axis.set(number, False)
            if enable:
                self.go(10 if axis.bit(3) else 20)
        elif self.state == 10:
            axis.set(7, True)
            if self.timer(True, self.TIME_OUT):  # always waits for the full time-out
                axis.set(7, axis.bit(3))
                self.go(ERROR if axis.bit(3) else 20)
        elif self.state in (20, 30, 40):
            number = {20: 1, 30: 0, 40: 3}[self.state]
            if self.state == 40:
                axis.target = axis.position
            axis.set(number, True)
            is_late = self.timer(True, self.TIME_OUT)
            if axis.bit({20: 0, 30: 1, 40: 2}[self.state]):
                self.go(self.state + 10)
            elif is_late:
                self.go(ERROR)
        elif self.state == 50:
            self.is_done = True
            if not enable:
                axis.set(3, False)
                self.go(0)
            elif axis.bit(3):
                self.go(ERROR)
        else:
            self.has_error = True
            if not enable:
                self.go(0)


class ModeBlock(Block):
    """The common part of Home and ProfilePosition: changing to their mode."""

    NUMBER = 0

    def enter(self, enable):
        axis = self.axis
        if self.state == 0:
            self.is_done = self.has_error = False
            if not enable:
                return
            if axis.bit(1) and axis.bit(2) and axis.mode_display == self.NUMBER and not axis.bit(3):
                self.go(10)
            elif axis.bit(1) and axis.mode_display != self.NUMBER:
                axis.set(3, False)  # the mode changes in Switched on
                self.go(10)
            else:
                self.go(ERROR)
        elif self.state == 10:
            axis.mode = self.NUMBER
            axis.set(3, axis.mode_display == self.NUMBER)
            if axis.bit(2):
                self.go(20)


class Home(ModeBlock):
    NUMBER = 6
    TIME_WITHOUT_MOTION = 10.0

    def __init__(self, axis):
        super().__init__(axis)
        self.last_position = None

    def __call__(self, enable):
        axis = self.axis
        if self.state == 10:
            axis.set(4, False)
        if self.state in (0, 10):
            self.enter(enable)
        elif self.state == 20:
            axis.set(4, True)
            is_stuck = self.timer(axis.position == self.last_position, self.TIME_WITHOUT_MOTION)
            self.last_position = axis.position
            if axis.bit(12):
                axis.set(4, False)
                axis.target = axis.position
                self.go(30)
            elif is_stuck or not enable or axis.bit(3) or axis.bit(13):
                self.go(ERROR)
        elif self.state == 30:
            self.is_done = True
            if not enable:
                self.go(0)
        else:
            axis.set(4, False)
            self.has_error = True
            if not enable:
                self.go(0)


class ProfilePosition(ModeBlock):
    NUMBER = 1

    def __call__(self, enable, execute, target, velocity, immediately=False, is_relative=False):
        axis = self.axis
        axis.set(5, immediately)
        axis.set(6, is_relative)
        axis.set(4, execute and self.state == 20)
        self.is_busy = self.state == 20 and axis.bit(12) and not axis.bit(10)
        self.is_done = self.state == 20 and axis.bit(10) and not axis.bit(13)
        if self.state in (0, 10):
            self.enter(enable)
        elif self.state == 20:
            axis.velocity, axis.target = velocity, target
            if axis.bit(13) or axis.bit(3):
                self.go(ERROR)
            elif not enable:
                axis.velocity = axis.target = 0
                self.go(0)
        else:
            axis.velocity = axis.target = 0
            self.has_error = True
            if not enable:
                self.go(0)


def run(axis, calls, until, seconds=5.0):
    """Run cycles of the task, each `calls()` and an exchange, until a condition holds."""
    deadline = axis.clock.deadline(seconds)
    while True:
        calls()
        axis.exchange()
        if until():
            return
        assert axis.clock.now < deadline, f"6041h = 0x{axis.statusword:04X}, mode {axis.mode_display}"


@pytest.fixture
def axis(client, clock, node):
    return Axis(client, clock, node)


@pytest.fixture
def power(axis):
    power = Power(axis)
    run(axis, lambda: power(True), lambda: power.is_done or power.has_error)
    assert power.is_done and axis.bit(2)
    return power


def test_power_enables_and_disables(axis, power):
    run(axis, lambda: power(False), lambda: not axis.bit(1))
    assert not power.has_error


def test_home_is_attained(axis, power, client, node):
    client.write(node, 0x6098, 0, 37, 1)
    home = Home(axis)
    run(axis, lambda: (power(True), home(True)), lambda: home.is_done or home.has_error)
    assert home.is_done and axis.position == 0


def test_profile_position_arrives_twice(axis, power):
    move = ProfilePosition(axis)
    run(axis, lambda: (power(True), move(True, False, 0, 20000)), lambda: move.state == 20)
    for target in (3000, -500):
        # A rising edge of xExecute, held until the move is in progress, as a push button would be.
        run(axis, lambda goal=target: (power(True), move(True, True, goal, 20000)), lambda: move.is_busy)
        run(axis, lambda goal=target: (power(True), move(True, False, goal, 20000)),
            lambda goal=target: move.is_done and axis.position == goal)
    assert not move.has_error and not power.has_error


def test_stop_halts_and_power_resets_a_fault(axis, power, client, node):
    move = ProfilePosition(axis)
    run(axis, lambda: (power(True), move(True, False, 0, 20000)), lambda: move.state == 20)
    run(axis, lambda: (power(True), move(True, True, 100000, 20000)), lambda: axis.position > 100)
    axis.set(8, True)
    run(axis, lambda: (power(True), move(True, True, 100000, 20000)), lambda: axis.bit(10))
    assert axis.position < 100000
    axis.set(8, False)
    client.write(node, 0x5E02, 0, 1, 1)  # over-current
    run(axis, lambda: power(True), lambda: power.has_error and axis.statusword & 0x4F == 0x08)
    client.write(node, 0x5E02, 0, 0, 1)
    run(axis, lambda: power(False), lambda: power.state == 0 and not power.has_error)
    axis.set(4, False)
    run(axis, lambda: power(True), lambda: power.is_done or power.has_error)
    assert power.is_done and not axis.bit(3)
