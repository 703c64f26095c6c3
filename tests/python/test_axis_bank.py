# SPDX-License-Identifier: Apache-2.0
"""The drive alone: vdrive.AxisBank."""
import gc
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy
import pytest
import vdrive

RANGE = 2**31 - 1  # highest value of 607Ah


def moving(axes, **options):
    """Return a bank whose axes are moving, each to its own target."""
    bank = vdrive.AxisBank(axes, **options)
    bank.write(None, "op_mode_cmd", 1)
    bank.write(None, 0x607A, 10000 + 10 * numpy.arange(axes))
    bank.write(None, "ds402_controlword", 0x0F)
    bank.write(None, "ds402_controlword", 0x3F)
    return bank


def test_axes_move_to_their_targets():
    bank = moving(20)
    # 10,190 UU at 68,267 UU/s with the default ramps take less than a second.
    assert bank.step(1000) == bank.tick == 1000
    assert bank.status["load_position_actual_value"].tolist() == list(range(10000, 10200, 10))
    assert len(bank) == 20 and bank.period == 0.001


def test_the_status_is_read_where_the_bank_has_it():
    bank = moving(3)
    view = bank.status
    address = view.__array_interface__["data"][0]
    assert (view["load_position_actual_value"] == 0).all()
    bank.step(1000)
    assert (view["load_position_actual_value"] == [10000, 10010, 10020]).all()
    bank.restore(bank.snapshot())
    bank.power_cycle(1)
    assert bank.status.__array_interface__["data"][0] == address
    assert not view.flags.owndata and view.strides == (view.dtype.itemsize,)


def test_the_status_has_each_member_as_read_tells_it():
    bank = moving(2, model={"load_inertia": 0.001})
    bank.step(100)
    members = set(bank.status.dtype.names)
    shared = set(vdrive.record_type().names) & members
    assert len(shared) == 22 and members - shared == {"ds402_controlword"}
    counted = {"ignored_set_points", "fault_count"}  # not objects
    for name in members - counted:
        assert bank.read(None, name).tolist() == bank.status[name].tolist(), name
    for name in shared:
        assert bank.status.dtype[name] == vdrive.record_type()[name]


def test_the_status_cannot_be_written():
    view = vdrive.AxisBank(1).status
    with pytest.raises(ValueError, match="read-only"):
        view["error_code"] = 1
    with pytest.raises(ValueError, match="WRITEABLE"):
        view.setflags(write=True)


def test_the_status_keeps_its_bank():
    bank = moving(2)
    bank.step(1000)
    view = bank.status["load_position_actual_value"]
    del bank
    gc.collect()
    others = [vdrive.AxisBank(2) for _ in range(100)]  # would reuse the memory
    assert view.tolist() == [10000, 10010] and len(others) == 100


@pytest.mark.parametrize("row", [[1, -2, 3, 2**31 - 1], numpy.rint([1.2, -2.4, 2.6, 2.0**31 - 1]),
                                 numpy.array([1, 2, 3, 4], dtype=numpy.uint64)])
def test_a_row_of_whole_numbers_may_have_any_type_of_numbers(row):
    bank = vdrive.AxisBank(4)
    bank.write(None, 0x607A, row)
    assert bank.read(None, 0x607A).tolist() == [int(value) for value in row]


def test_the_same_writes_give_the_same_bits():
    first, second = moving(33), moving(33)
    for _ in range(300):
        first.step()
    second.step(300)
    assert first.status.tobytes() == second.status.tobytes()
    assert first.status_hash() == second.status_hash()
    second.write(7, "test_load_torque", 1000)
    first.step(5)
    second.step(5)
    assert first.status_hash() != second.status_hash()


@pytest.mark.parametrize("coupling", ["rigid", "two_inertia"])
def test_a_restored_bank_goes_on_as_the_one_that_was_not_interrupted(coupling):
    bank = moving(17, model={"coupling": coupling})
    bank.step(100)
    snapshot = bank.snapshot()
    hashes = [(bank.step(), bank.status_hash()) for _ in range(400)]
    bank.restore(snapshot)
    assert bank.tick == 100
    assert [(bank.step(), bank.status_hash()) for _ in range(400)] == hashes
    other = vdrive.AxisBank(17, model={"coupling": coupling})
    other.restore(snapshot)
    assert [(other.step(), other.status_hash()) for _ in range(400)] == hashes


def test_noise_of_the_load_is_that_of_its_seed_and_part_of_a_snapshot():
    def positions(seed):
        bank = moving(20)
        bank.set_load_noise(None, 0.2, seed)
        bank.step(200)
        snapshot = bank.snapshot()
        bank.step(200)
        first = bank.status.tobytes()
        bank.restore(snapshot)
        bank.step(200)
        assert bank.status.tobytes() == first
        return bank.status["motor_position_actual_value"].tolist()

    quiet = moving(20)
    quiet.step(400)
    assert positions(1) == positions(1) != positions(2)
    assert positions(1) != quiet.status["motor_position_actual_value"].tolist()
    for rms in (-1.0, float("nan"), 10001.0):
        with pytest.raises(ValueError, match="must be from 0 to 10000 N.m"):
            quiet.set_load_noise([0, 1], rms)


def test_a_snapshot_that_does_not_fit_is_refused_with_the_reason():
    bank = moving(4)
    bank.step(10)
    snapshot, before = bank.snapshot(), bank.status_hash()
    damaged = bytearray(snapshot)
    damaged[-1] ^= 1
    older = bytearray(snapshot)
    older[8] ^= 1  # the layout follows the eight letters of the kind
    for made, content, reason in (
            (bank, b"", "not of AxisBank"),
            (bank, b"anything else", "not of AxisBank"),
            (bank, snapshot[:-1], "damaged"),
            (bank, snapshot + b"x", "damaged"),
            (bank, bytes(damaged), "damaged"),
            (bank, snapshot[:40] + bytes([snapshot[40] ^ 1]) + snapshot[41:], "damaged"),  # the tick
            (bank, bytes(older), "another version"),
            (bank, vdrive.AxisBank(5).snapshot(), "5 axes, the bank has 4"),
            (bank, vdrive.AxisBank(4, period=0.002).snapshot(), "2000 us.* 1000 us"),
            (bank, vdrive.AxisBank(4, model={"load_inertia": 1}).snapshot(), "another model"),
            (bank, vdrive.AxisBank(4, parameters={0x6081: 1}).snapshot(), "other parameters")):
        with pytest.raises(ValueError, match=reason):
            made.restore(content)
    assert bank.status_hash() == before and bank.tick == 10
    with pytest.raises(TypeError):
        bank.restore(None)


def test_each_spelling_of_an_object_means_the_same():
    bank = vdrive.AxisBank(2)
    for place, name in enumerate(("position_user_target_value", 0x607A, (0x607A, 0), "0x607A", "607Ah")):
        bank.write(1, name, place + 1)
        assert bank.read(1, name) == bank.read(1, 0x607A) == place + 1
    assert bank.read(0, 0x607A) == 0
    with pytest.raises(KeyError, match="no object 'nothing'"):
        bank.write(0, "nothing", 1)


def test_a_refusal_names_axis_object_value_and_limit():
    bank = vdrive.AxisBank(4)
    with pytest.raises(vdrive.Refused) as refused:
        bank.write(3, "607Ah", RANGE + 1)
    text = str(refused.value)
    for part in ("2147483648", "position_user_target_value (607Ah)", "axis 3",
                 "must be from -2147483648 to 2147483647"):
        assert part in text
    assert refused.value.code == 0x06090031
    with pytest.raises(vdrive.Refused, match="axis 2 refused: 0x06010002"):
        bank.write(2, "ds402_statusword", 1)
    with pytest.raises(vdrive.Refused, match="axis 0 refused: 0x06020000"):
        bank.read(0, 0x5FFF)


def test_several_axes_are_written_and_read_at_once():
    bank = vdrive.AxisBank(6)
    bank.write(range(1, 4), 0x607A, [10, 20, 30])
    bank.write(numpy.array([5], dtype=numpy.uint8), 0x607A, numpy.int16(50))
    assert bank.read(None, 0x607A).tolist() == [0, 10, 20, 30, 0, 50]
    assert bank.read([3, 1], 0x607A).tolist() == [30, 10]
    bank.write([], 0x607A, [])
    with pytest.raises(vdrive.Refused, match="axis 1"):
        bank.write(None, 0x607A, [1, RANGE + 1, 3, 4, 5, 6])
    assert bank.read(None, 0x607A).tolist() == [1, 10, 20, 30, 0, 50]


def test_bad_arguments_are_refused():
    bank = vdrive.AxisBank(4)
    for axis in (-1, 4, [0, 4]):
        with pytest.raises(IndexError, match="axis = (-1|4): must be from 0 to 3"):
            bank.write(axis, 0x607A, 0)
    with pytest.raises(ValueError, match="3 values for 4 axes"):
        bank.write(None, 0x607A, [1, 2, 3])
    for value in (1.5, "1", None, numpy.full(4, 0.5), numpy.full(4, numpy.nan), numpy.full(4, 2.0**63),
                  numpy.zeros((2, 2), dtype=int), numpy.full(4, 2**63, dtype=numpy.uint64)):
        with pytest.raises(TypeError):
            bank.write(None, 0x607A, value)
    with pytest.raises(TypeError, match="value = .*True.*: must be a whole number or one row"):
        bank.write(None, 0x607A, numpy.full(4, True))
    with pytest.raises(TypeError, match="period = True: must be a number of seconds"):
        vdrive.AxisBank(1, period=True)
    with pytest.raises(TypeError, match="rms = True: must be a number of N.m"):
        bank.set_load_noise(0, True)
    with pytest.raises(TypeError, match="seed = True: must be a whole number"):
        bank.set_load_noise(0, 0.1, True)
    for value in ("1", None, [1], True):
        with pytest.raises(TypeError, match="value = .*: must be a whole number from -9"):
            bank.write(0, 0x607A, value)
    with pytest.raises(ValueError, match="value = 1.5: must be a whole number from -9"):
        bank.write(0, 0x607A, 1.5)
    with pytest.raises(ValueError, match=f"value = {2**63}: must be from -{2**63} to {2**63 - 1}"):
        bank.write(0, 0x607A, 2**63)
    with pytest.raises(TypeError, match="axis = '0': must be a whole number or one row of whole numbers"):
        bank.read("0", 0x607A)
    with pytest.raises(ValueError, match=f"ticks = -1: must be from 0 to {2**63 - 1}"):
        bank.step(-1)
    with pytest.raises(TypeError, match="ticks = '1': must be a whole number"):
        bank.step("1")
    with pytest.raises(IndexError, match="axis = 4: must be from 0 to 3"):
        bank.power_cycle(4)
    with pytest.raises(ValueError, match="index = 65536: must be from 0 to 65535"):
        bank.read(0, 65536)
    assert bank.step(0) == 0


@pytest.mark.parametrize("arguments, options, reason", [
    ((0,), {}, "axes = 0: must be from 1 to 1000000"),
    ((1000001,), {}, "axes = 1000001: must be"),
    ((1,), {"period": 0.02}, "20000 us is out of range: must be from 125 to 10000 us"),
    ((1,), {"model": {"load_inertia": -1.0}}, "load_inertia = -1: must be from 0 to 10000 kg.m2"),
    ((1,), {"model": {"inertia": 1.0}}, "unknown key 'inertia'; known keys: coupling.*backlash"),
    ((1,), {"model": {"coupling": "soft"}}, "coupling = 'soft' must be rigid or two_inertia"),
    ((1,), {"model": {"coupling": 5}}, "coupling = '5' must be rigid or two_inertia"),
    ((1,), {"model": {5: 1.0}}, "unknown key '5'; known keys: coupling"),
    ((2,), {"model": [{}]}, "a sequence of 2 dicts"),
    ((2,), {"model": 3}, "a sequence of 2 dicts"),
    ((1,), {"model": {"backlash": "much"}}, "backlash is a number, in rad"),
    ((1,), {"model": {"backlash": True}}, "backlash is a number, in rad"),
    ((1,), {"parameters": {"607Ah": RANGE + 1}}, "^initial value 2147483648 .*607Ah"),
])
def test_a_bank_that_cannot_be_made_says_what_where_and_the_limit(arguments, options, reason):
    with pytest.raises(vdrive.ConfigurationError, match=reason):
        vdrive.AxisBank(*arguments, **options)


def test_each_axis_has_its_model_and_all_have_the_parameters():
    soft = {"coupling": "two_inertia", "coupling_stiffness": 1.0}
    bank = vdrive.AxisBank(2, model=[{}, soft], parameters={"profile_velocity": 20000})
    assert bank.read(None, 0x6081).tolist() == [20000, 20000]
    bank.write(None, "test_load_torque", 500)
    bank.step(50)
    # At rest, 0.5 N.m twist the soft shaft by 0.5 rad: 326 UU.
    rigid, twisted = abs(bank.status["load_position_actual_value"]
                         - bank.status["motor_position_actual_value"])
    assert rigid == 0 and twisted > 100


def wait_for_a_step(bank):
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        try:
            bank.read(0, 0x6041)
        except RuntimeError:
            return


def test_a_second_thread_is_refused_while_one_steps():
    bank = moving(1000)
    snapshot, refused = bank.snapshot(), []

    def use():
        wait_for_a_step(bank)
        for call in (bank.step, bank.snapshot, bank.status_hash, lambda: bank.restore(snapshot),
                     lambda: bank.write(0, 0x607A, 1), lambda: bank.read(0, 0x607A),
                     lambda: bank.power_cycle(0)):
            try:
                call()
            except RuntimeError as error:
                refused.append(str(error))
        os.kill(os.getpid(), signal.SIGINT)  # ends the step

    thread = threading.Thread(target=use)
    with pytest.raises(KeyboardInterrupt):
        thread.start()
        bank.step(10**15)  # 30,000 years
    thread.join(60)
    assert len(refused) == 7 and all("another thread uses this bank" in text for text in refused)
    tick = bank.tick
    assert bank.step() == tick + 1  # it was interrupted between two ticks and remains usable


def run(program):
    environment = dict(os.environ, PYTHONPATH=str(pathlib.Path(vdrive.__file__).parents[1]))
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True,
                          timeout=120, env=environment)


def test_the_interpreter_ends_while_a_thread_steps():
    done = run("""
import threading, vdrive
bank = vdrive.AxisBank(100)
bank.write(None, 0x6060, 1)
thread = threading.Thread(target=lambda: bank.step(10**15), daemon=True)
thread.start()
while True:
    try:
        bank.read(0, 0x6041)
    except RuntimeError:
        break  # it steps
""")
    assert done.returncode == 0, done.stderr
    assert "Fatal" not in done.stderr and "terminate" not in done.stderr


def test_a_forked_process_goes_on_with_its_own_copy():
    bank = moving(10)
    bank.step(100)
    view = bank.status
    child = os.fork()
    if child == 0:
        code = 1  # also after an exception: the child must not return into pytest
        try:
            bank.step(1000)
            code = 0 if view["load_position_actual_value"][0] == 10000 else 1
        finally:
            os._exit(code)
    assert os.waitpid(child, 0)[1] == 0
    assert bank.tick == 100 and view["load_position_actual_value"][0] != 10000


def test_a_bank_that_was_forked_in_the_middle_of_a_step_is_refused():
    done = run("""
import os, signal, threading, vdrive
bank = vdrive.AxisBank(100)
def fork():
    while True:
        try:
            bank.read(0, 0x6041)
        except RuntimeError:
            break  # it steps
    child = os.fork()
    if child == 0:
        try:
            bank.step()
        except vdrive.Forked as error:
            os.write(1, str(error).encode())
        os._exit(0)
    os.waitpid(child, 0)
    os.kill(os.getpid(), signal.SIGINT)
thread = threading.Thread(target=fork)
thread.start()
try:
    bank.step(10**15)
except KeyboardInterrupt:
    print("interrupted")
thread.join()
""")
    assert "step that is under way" in done.stdout and "interrupted" in done.stdout, done.stderr


def test_no_session_no_thread_and_no_file_are_made():
    def entries():
        return {*os.listdir("/proc/self/task"), *os.listdir("/proc/self/fd")}

    before = entries()  # a thread of an earlier test may still be ending
    bank = moving(64)
    bank.step(10)
    bank.restore(bank.snapshot())
    assert entries() <= before
