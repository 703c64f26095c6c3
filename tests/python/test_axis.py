# SPDX-License-Identifier: Apache-2.0
"""An axis in Python: commands, objects, errors."""
import math
import os
import pickle
import re
import socket

import pytest
import vdrive

FOLLOWING_ERROR = 0x8611


@pytest.fixture
def axis(vdrive_shared_session):
    return vdrive_shared_session.axis("1.1")


def test_a_move_ends_at_its_target_with_the_given_speed(vdrive_shared_session, axis):
    axis.enable()
    speed_of_the_drive = axis.read("profile_velocity")
    fastest = 0
    motion = axis.start_move(10000, velocity=20000)
    while not motion.has_ended():
        vdrive_shared_session.step()
        fastest = max(fastest, axis.status().velocity_demand_value)
    assert axis.status().position == 10000
    assert fastest == 20000
    axis.move_by(-2500)
    assert axis.status().demand == 7500
    assert axis.read(0x6081) == speed_of_the_drive


@pytest.mark.parametrize(("command", "cause"), [
    (lambda axis: axis.run_at(1000), "profile velocity mode (6060h = 3)"),
    (lambda axis: axis.home(method=37), "homing mode (6060h = 6)"),
    (lambda axis: axis.start_move(-5000), "607Ah = -5000"),
    (lambda axis: axis.write(0x6060, 4), "profile torque mode (6060h = 4)"),
    (lambda axis: axis.quick_stop(), "quick stop (6040h = 0x0002)"),
], ids=["velocity", "homing", "move", "mode", "stop"])
def test_a_motion_ends_by_what_comes_after_it_and_says_by_what(vdrive_shared_session, axis, command, cause):
    axis.enable()
    motion = axis.start_move(50000, velocity=20000)
    vdrive_shared_session.wait(0.1)
    command(axis)
    vdrive_shared_session.wait(1.0)
    with pytest.raises(vdrive.Failed, match=re.escape(cause)):
        motion.has_ended()
    with pytest.raises(vdrive.Failed, match=re.escape(cause)):
        motion.wait()


def test_an_axis_rests_when_it_is_enabled_unless_it_is_to_keep_its_target(vdrive_shared_session, axis):
    group = vdrive.AxisGroup(vdrive_shared_session, ["1.1"])
    for enable in (axis.enable, group.enable_all):
        for keep_target, runs in ((False, False), (True, True)):
            axis.write("op_mode_cmd", 3)
            axis.write("target_velocity", 2048)
            enable(keep_target=keep_target)
            vdrive_shared_session.step(300)
            assert (axis.status().velocity_demand_value == 2048) == runs
            axis.quick_stop()
    axis.write("target_velocity", 0)


def test_an_object_is_named_by_index_pair_name_or_name_of_the_standard(axis):
    # No limits are set, so both objects have the manual's values: the range of INTEGER32.
    assert axis.read((0x607D, 1)) == -2**31
    assert axis.read("user_position_lower_limit") == -2**31
    axis.write("max_position_limit", 5000)
    assert axis.read((0x607D, 2)) == axis.read("0x607D:2") == axis.read("607Dh:2") == 5000
    assert axis.read(0x6041) == axis.status().statusword == axis.status().value(0x6041)


def test_an_invalid_object_is_an_error_before_anything_is_sent(axis):
    with pytest.raises(KeyError, match="no_such_object"):
        axis.read("no_such_object")
    with pytest.raises(ValueError, match="65535"):
        axis.read(0x10000)


def test_a_refusal_has_the_abort_code_of_the_standard_and_a_text(axis):
    with pytest.raises(vdrive.Refused, match="object does not exist") as refusal:
        axis.read(0x5FFF)
    assert refusal.value.code == 0x06020000
    with pytest.raises(vdrive.Error) as refusal:
        axis.write(0x6041, 0)
    assert refusal.value.code == 0x06010002  # a read-only object


def test_several_objects_are_read_in_one_tick_and_a_refused_one_is_an_exception(axis):
    values = axis.read_many([0x6041, 0x5FFF, (0x607D, 1)])
    assert values[0] == axis.status().statusword
    assert isinstance(values[1], vdrive.Refused) and values[1].code == 0x06020000
    assert values[2] == -2**31


def test_a_command_that_the_state_does_not_allow_is_refused_with_its_code(axis):
    with pytest.raises(vdrive.Refused) as refusal:
        axis.move_to(100)
    assert refusal.value.code == 0x08000022


def test_a_blocked_load_ends_a_move_in_a_fault_that_a_reset_ends(axis):
    axis.enable()
    axis.disturb("blocked_load")
    with pytest.raises(vdrive.Failed, match="0x8611"):
        axis.move_to(100000)
    status = axis.wait_until(lambda shown: shown.state == "Fault")
    assert status.has_fault and status.error_code == FOLLOWING_ERROR
    axis.end_disturbances()
    axis.reset_fault()
    assert not axis.status().has_fault


def test_an_unknown_disturbance_is_an_error_that_names_the_known_ones(axis):
    with pytest.raises(ValueError, match="no disturbance .rust.: load_torque, blocked_load"):
        axis.disturb("rust")
    assert "blocked_load" in vdrive.DISTURBANCES


def test_a_time_out_is_also_a_timeout_error_of_python(axis):
    axis.enable()
    with pytest.raises(TimeoutError):
        axis.move_to(100000, timeout=0.05)
    with pytest.raises(vdrive.TimedOut):
        axis.wait_until(lambda status: False, timeout=0.05)


def test_an_exception_of_a_condition_is_raised_by_the_wait(axis):
    with pytest.raises(ZeroDivisionError):
        axis.wait_until(lambda status: 1 // 0)
    with pytest.raises(ZeroDivisionError):
        axis.enable()
        axis.jog(1000, lambda status: 1 // 0)


def test_a_jog_runs_while_it_is_held_and_brakes(axis):
    axis.enable()
    seen = []

    def held(status):
        seen.append(status.velocity_demand_value)
        return status.position < 2000

    axis.jog(4000, held)
    assert max(seen) == 4000
    assert axis.status().velocity_demand_value == 0


def test_the_other_modes_reach_their_targets(axis):
    axis.enable()
    axis.home(method=37)
    assert axis.status().mode == "homing"
    axis.run_at(3000)
    assert axis.status().velocity_demand_value == 3000
    axis.halt()
    axis.apply_torque(20, slope=1000)
    assert axis.status().torque_demand == 20


def test_a_unit_converts_between_user_units_and_degrees(axis):
    # 4096 user units per revolution.
    assert axis.unit.name == "deg"
    assert axis.unit.to_user_units(90.0) == 1024.0
    assert axis.unit.from_user_units(1024.0) == 90.0


@pytest.mark.parametrize("seconds", [-1.0, math.nan, math.inf])
def test_an_invalid_time_is_an_error(axis, seconds):
    with pytest.raises(ValueError, match="seconds"):
        axis.enable(timeout=seconds)


def test_a_word_outside_the_choices_is_an_error(vdrive_shared_session, axis):
    with pytest.raises(ValueError, match="in_force"):
        axis.enable(until="soon")
    with pytest.raises(ValueError, match="observe"):
        vdrive_shared_session.follow(pace="slow")
    with pytest.raises(ValueError, match="dance"):
        vdrive_shared_session.command_each("1.1", "dance")


def test_a_command_to_several_axes_gives_each_its_outcome(vdrive_shared_session):
    assert vdrive_shared_session.command_each(["1.1", "1.2"], "enable") == [None, None]
    vdrive_shared_session.axis("1.2").disturb("over_temperature")
    vdrive_shared_session.axis("1.2").wait_until(lambda status: status.state == "Fault")
    first, second = vdrive_shared_session.command_each(None, "enable")
    assert first is None and isinstance(second, vdrive.Refused)


def test_a_refusal_names_the_program_that_stands_in_the_way(vdrive_bench):
    with vdrive_bench.session(program="a\x07b") as owner, vdrive_bench.session() as other:
        owner.axis("1.1").enable()
        with pytest.raises(vdrive.Refused) as refusal:
            other.axis("1.1").enable()
        session = owner.id
    held = refusal.value.owner
    assert refusal.value.code == 0x08000021
    assert held == vdrive.Owner("1.1", session, "a\\x07b", os.getpid(), socket.gethostname())
    assert str(refusal.value) == (
        f"control of axis 1.1 refused: axis 1.1 is controlled by a\\x07b (process {os.getpid()} on "
        f"{socket.gethostname()}), session 0x{session:016x}")
    assert pickle.loads(pickle.dumps(refusal.value)).owner == held
