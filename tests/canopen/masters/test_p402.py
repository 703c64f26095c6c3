# SPDX-License-Identifier: Apache-2.0
"""The CiA 402 profile of python-canopen, with its time-outs: states, modes, homing, reset of a
fault.

Modelled on canopen-python/canopen (christiansandberg/canopen): canopen/profiles/p402.py
(BaseNode402), canopen/nmt.py (how it tracks the NMT state) and canopen/pdo/base.py (the objects
it uploads, when it considers a PDO periodic, and when it waits for a TPDO). Nothing of it is
copied."""
import pathlib
import struct

import pytest
from can_client import NOT_VALID, PRE_OPERATIONAL, RPDO, START, TPDO, SdoAbort

# Expected findings of the judge, with our explanation.
FINDINGS = {}

GUIDE = pathlib.Path(__file__).parents[3] / "docs" / "guides" / "canopen.md"
EVENT_TIMER = 100  # [ms] below the 0.2 s for which it waits for a TPDO

# Its time-outs [s].
TIME_OF_A_TPDO, TIME_OF_A_STEP, TIME_OF_A_STATE, TIME_OF_A_MODE = 0.2, 0.4, 0.8, 0.5
TIME_OF_A_RESET, TIME_OF_HOMING = 0.4, 30.0

STATES = {
    "NOT READY TO SWITCH ON": (0x4F, 0x00), "SWITCH ON DISABLED": (0x4F, 0x40),
    "READY TO SWITCH ON": (0x6F, 0x21), "SWITCHED ON": (0x6F, 0x23), "OPERATION ENABLED": (0x6F, 0x27),
    "FAULT": (0x4F, 0x08), "FAULT REACTION ACTIVE": (0x4F, 0x0F), "QUICK STOP ACTIVE": (0x6F, 0x07)}
TOWARDS_ENABLED = {
    "FAULT": "SWITCH ON DISABLED", "NOT READY TO SWITCH ON": "SWITCH ON DISABLED",
    "QUICK STOP ACTIVE": "SWITCH ON DISABLED", "SWITCH ON DISABLED": "READY TO SWITCH ON",
    "READY TO SWITCH ON": "SWITCHED ON", "SWITCHED ON": "OPERATION ENABLED",
    "FAULT REACTION ACTIVE": "FAULT"}
WORDS = {
    ("READY TO SWITCH ON", "SWITCH ON DISABLED"): 0x00, ("OPERATION ENABLED", "SWITCH ON DISABLED"): 0x00,
    ("SWITCHED ON", "SWITCH ON DISABLED"): 0x00, ("QUICK STOP ACTIVE", "SWITCH ON DISABLED"): 0x00,
    ("NOT READY TO SWITCH ON", "SWITCH ON DISABLED"): 0x00, ("FAULT REACTION ACTIVE", "FAULT"): 0x00,
    ("SWITCH ON DISABLED", "READY TO SWITCH ON"): 0x06, ("SWITCHED ON", "READY TO SWITCH ON"): 0x06,
    ("OPERATION ENABLED", "READY TO SWITCH ON"): 0x06, ("READY TO SWITCH ON", "SWITCHED ON"): 0x07,
    ("OPERATION ENABLED", "SWITCHED ON"): 0x07, ("SWITCHED ON", "OPERATION ENABLED"): 0x0F,
    ("QUICK STOP ACTIVE", "OPERATION ENABLED"): 0x0F, ("OPERATION ENABLED", "QUICK STOP ACTIVE"): 0x02,
    ("FAULT", "SWITCH ON DISABLED"): 0x80}
MODES = {"NO MODE": 0, "PROFILED POSITION": 1, "PROFILED VELOCITY": 3, "HOMING": 6,
         "CYCLIC SYNCHRONOUS POSITION": 8}
HOMING = {  # bits 13, 12 and 10
    0x0000: "IN PROGRESS", 0x0400: "INTERRUPTED", 0x1000: "ATTAINED", 0x1400: "TARGET REACHED",
    0x2000: "ERROR VELOCITY IS NOT ZERO", 0x2400: "ERROR VELOCITY IS ZERO"}


class Pdo:
    def __init__(self, cob_id, transmission, objects):
        self.cob_id = cob_id & 0x1FFFFFFF
        self.is_enabled = not cob_id & NOT_VALID
        self.transmission = transmission
        self.objects = objects  # (index, bits) each
        self.data = bytearray(sum(bits for _, bits in objects) // 8)

    def place_of(self, index):
        begin = 0
        for mapped, bits in self.objects:
            if mapped == index:
                return begin, bits // 8
            begin += bits // 8
        return None


class Node402:
    def __init__(self, client, clock, node):
        self.client, self.clock, self.node = client, clock, node
        self.before = client.received.copy()  # PDOs are monitored from now on
        assert client.read(node, 0x1000) & 0xFFFF == 0x0192  # CiA 402
        self.tpdos = [self.upload_pdo(0x1800 + place, has_timers=True) for place in range(4)]
        self.rpdos = [self.upload_pdo(0x1400 + place, has_timers=False) for place in range(4)]

    def upload_pdo(self, communication, has_timers):
        client, node = self.client, self.node
        cob_id = client.read(node, communication, 1)
        transmission = client.read(node, communication, 2)
        if transmission >= 254:
            for sub in (3, 5, 6) if has_timers else (5,):
                client.read(node, communication, sub)
        entries = [client.read(node, communication + 0x200, sub)
                   for sub in range(1, client.read(node, communication + 0x200, 0) + 1)]
        return Pdo(cob_id, transmission, [(entry >> 16, entry & 0xFF) for entry in entries])

    def is_periodic(self, pdo):
        """Whether it is driven by SYNC or has been received twice, which gives it a period."""
        return pdo.transmission <= 0xF0 or self.client.received[pdo.cob_id] - self.before[pdo.cob_id] >= 2

    # TPDOs: the first enabled one that contains the object.

    def first_with(self, pdos, index):
        return next((pdo for pdo in pdos if pdo.is_enabled and pdo.place_of(index) is not None), None)

    def latest(self, index, form):
        """The value in the last TPDO that contained it; 0 before the first one."""
        pdo = self.first_with(self.tpdos, index)
        data = self.client.latest.get(pdo.cob_id)
        if data is None:
            return 0
        begin, size = pdo.place_of(index)
        return struct.unpack(form, data[begin:begin + size])[0]

    def wait_for_tpdo(self, pdo):
        before = self.client.received[pdo.cob_id]
        deadline = self.clock.deadline(TIME_OF_A_TPDO)
        while self.client.received[pdo.cob_id] == before:
            assert self.clock.now < deadline, "timeout waiting for a TPDO"
            self.clock.cycle()

    @property
    def statusword(self):
        return self.latest(0x6041, "<H")

    def check_statusword(self):
        pdo = self.first_with(self.tpdos, 0x6041)
        if self.is_periodic(pdo):
            self.wait_for_tpdo(pdo)
            return self.statusword
        self.clock.cycle()  # the duration of an SDO access
        return self.client.read(self.node, 0x6041)

    def transmit(self, index, form, value):
        pdo = self.first_with(self.rpdos, index)
        begin, size = pdo.place_of(index)
        pdo.data[begin:begin + size] = struct.pack(form, value)
        self.client.send(pdo.cob_id, bytes(pdo.data))

    @property
    def state(self):
        return next((state for state, (mask, bits) in STATES.items() if self.statusword & mask == bits),
                    "UNKNOWN")

    def set_state(self, target):
        deadline = self.clock.deadline(TIME_OF_A_STATE)
        while (state := self.state) != target:
            step = target if (state, target) in WORDS else TOWARDS_ENABLED[state]
            if self.change_state(state, step):
                continue
            assert self.clock.now <= deadline, f"timeout when trying to change state to {target}"
            self.check_statusword()

    def change_state(self, state, target):
        self.transmit(0x6040, "<H", WORDS[state, target])
        deadline = self.clock.deadline(TIME_OF_A_STEP)
        while self.state != target:
            if self.clock.now > deadline:
                return False
            self.check_statusword()
        return True

    @property
    def op_mode(self):
        pdo = self.first_with(self.tpdos, 0x6061)
        if self.is_periodic(pdo):
            self.wait_for_tpdo(pdo)
        else:
            self.clock.cycle()
        return self.latest(0x6061, "<b")

    def set_op_mode(self, mode):
        number = MODES[mode]
        assert number == 0 or self.client.read(self.node, 0x6502) >> number - 1 & 1
        self.transmit(0x6060, "<b", number)
        deadline = self.clock.deadline(TIME_OF_A_MODE)
        while self.op_mode != number:
            assert self.clock.now <= deadline, f"timeout setting the mode {mode}"

    def homing(self):
        self.set_op_mode("HOMING")
        self.set_state("OPERATION ENABLED")
        self.transmit(0x6040, "<H", 0x1F)
        self.check_statusword()
        deadline = self.clock.deadline(TIME_OF_HOMING)
        status = "UNKNOWN"
        while status not in ("TARGET REACHED", "ATTAINED"):
            self.check_statusword()
            status = HOMING[self.statusword & 0x3400]
            assert status not in ("INTERRUPTED", "ERROR VELOCITY IS NOT ZERO", "ERROR VELOCITY IS ZERO")
            assert self.clock.now <= deadline, "unable to home, timeout reached"

    def reset_from_fault(self):
        assert self.state == "FAULT"
        self.transmit(0x6040, "<H", 0x00)
        # It always waits for the full time-out: the word above has no rising edge of bit 7.
        end = self.clock.now + TIME_OF_A_RESET
        while self.state == "FAULT" and self.clock.now <= end:
            self.check_statusword()
        self.set_state("OPERATION ENABLED")


@pytest.fixture(params=["event-driven", "SYNC"])
def drive(request, client, clock, node):
    """The profile on a node with the default PDOs, which are event-driven, or with all PDOs driven
    by SYNC."""
    clock.boot()
    if request.param == "event-driven":
        for communication in (0x1800, 0x1801):
            client.write(node, communication, 5, EVENT_TIMER, 2)
    else:
        for communication in (*range(0x1400, 0x1404), *range(0x1800, 0x1804)):
            cob_id = client.read(node, communication, 1)
            client.write(node, communication, 1, NOT_VALID | cob_id, 4)
            client.write(node, communication, 2, 1, 1)
            client.write(node, communication, 1, cob_id, 4)
    drive = Node402(client, clock, node)
    client.nmt(START, node)
    while not client.received[TPDO + node]:
        clock.cycle()
    return drive


def test_it_reads_the_predefined_pdos(drive, node):
    assert [pdo.cob_id for pdo in drive.tpdos] == [TPDO + place * 0x100 + node for place in range(4)]
    assert [pdo.cob_id for pdo in drive.rpdos] == [RPDO + place * 0x100 + node for place in range(4)]
    assert drive.tpdos[2].objects == [(0x6041, 16), (0x6064, 32)]
    assert drive.rpdos[1].objects == [(0x6040, 16), (0x6060, 8)]


def test_it_enables_step_by_step_and_disables(drive):
    drive.set_state("SWITCH ON DISABLED")
    for state in ("READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED", "SWITCHED ON",
                  "READY TO SWITCH ON", "SWITCH ON DISABLED", "OPERATION ENABLED", "SWITCH ON DISABLED"):
        drive.set_state(state)
        assert drive.state == state


def test_it_changes_modes_and_moves(drive, client, node):
    # The PDO that contains the controlword also contains the mode.
    drive.set_op_mode("PROFILED POSITION")
    drive.set_state("OPERATION ENABLED")
    assert drive.op_mode == MODES["PROFILED POSITION"]
    client.write(node, 0x607A, 0, 2000, 4)
    drive.transmit(0x6040, "<H", 0x1F)
    deadline = drive.clock.deadline(5.0)
    while not drive.check_statusword() & 0x1000:
        assert drive.clock.now < deadline
    drive.transmit(0x6040, "<H", 0x0F)
    while not drive.check_statusword() & 0x0400 or client.read(node, 0x6064, signed=True) != 2000:
        assert drive.clock.now < deadline


def test_it_homes(drive, client, node):
    client.write(node, 0x6098, 0, 37, 1)
    drive.homing()
    assert client.read(node, 0x6064, signed=True) == client.read(node, 0x607C, signed=True) == 0


def test_it_resets_a_fault(drive, client, node):
    drive.set_state("OPERATION ENABLED")
    client.write(node, 0x5E02, 0, 1, 1)  # over-current
    deadline = drive.clock.deadline(5.0)
    while drive.state != "FAULT":
        assert drive.clock.now < deadline
        drive.check_statusword()
    client.write(node, 0x5E02, 0, 0, 1)
    drive.reset_from_fault()
    assert drive.state == "OPERATION ENABLED"


def test_a_mode_that_the_drive_does_not_have_is_refused(drive, client, node):
    assert not client.read(node, 0x6502) >> 5 - 1 & 1  # reserved by CiA 402-2
    with pytest.raises(SdoAbort) as refusal:
        client.write(node, 0x6060, 0, 5, 1)
    assert refusal.value.code == 0x06090030


# The guide's example, with the classes above in place of `import canopen`.

class Objects:
    """`node.sdo[index]` and `node.sdo[index][sub]`, whose `raw` is read and written with the
    length of the object."""

    def __init__(self, client, node, index=None, sub=0):
        self.client, self.node, self.index, self.sub = client, node, index, sub

    def __getitem__(self, key):
        return Objects(self.client, self.node, *((key,) if self.index is None else (self.index, key)))

    @property
    def raw(self):
        return self.client.read(self.node, self.index, self.sub)

    @raw.setter
    def raw(self, value):
        size = len(self.client.upload(self.node, self.index, self.sub))
        self.client.write(self.node, self.index, self.sub, value, size)


class Nmt:
    """The last commanded state; initially one in which it does not set up nodes."""

    COMMANDS = {"PRE-OPERATIONAL": PRE_OPERATIONAL, "OPERATIONAL": START}

    def __init__(self, client, node):
        self.client, self.node, self._state = client, node, "INITIALISING"

    @property
    def state(self):
        return self._state

    @state.setter
    def state(self, state):
        self._state = state
        self.client.nmt(self.COMMANDS[state], self.node)


class BaseNode402:
    def __init__(self, node_id, eds):
        assert eds == "vdrive.eds"
        self.id = node_id

    def join(self, client, clock):
        self._client, self._clock = client, clock
        self.sdo, self.nmt = Objects(client, self.id), Nmt(client, self.id)

    def setup_402_state_machine(self):
        assert self.nmt.state in ("PRE-OPERATIONAL", "OPERATIONAL")
        self._drive = Node402(self._client, self._clock, self.id)

    def _set(self, name, *value):
        getattr(self._drive, name)(*value)

    op_mode = property(fset=lambda self, mode: self._set("set_op_mode", mode))
    state = property(fset=lambda self, state: self._set("set_state", state))
    controlword = property(fset=lambda self, word: self._set("transmit", 0x6040, "<H", word))


class Library:
    """Replaces `import canopen` for the example, on the bus of a test."""

    BaseNode402 = BaseNode402

    def __init__(self, client, clock):
        self.client, self.clock = client, clock

    def Network(self):  # noqa: N802: a class of the library
        return self

    def connect(self, interface, channel):
        assert (interface, channel) == ("socketcan", "can0")

    def add_node(self, node):
        node.join(self.client, self.clock)


def test_the_lines_of_the_guide_enable_and_move(client, clock, node):
    lines = GUIDE.read_text(encoding="utf-8").split("### python-canopen")[1].split("```")[1]
    exec(lines.removeprefix("python\n"), {"canopen": Library(client, clock)})
    deadline = clock.deadline(10.0)
    while client.read(node, 0x6064, signed=True) != 10_000:
        assert clock.now < deadline
        clock.cycle()


@pytest.mark.parametrize("bus", ["lockstep"], indirect=True)
def test_without_an_event_timer_it_waits_for_a_tpdo_that_does_not_come(client, clock, node):
    clock.boot()
    drive = Node402(client, clock, node)
    client.nmt(START, node)
    drive.set_op_mode("PROFILED POSITION")  # its TPDO comes for the second time
    with pytest.raises(AssertionError, match="timeout waiting for a TPDO"):
        _ = drive.op_mode
