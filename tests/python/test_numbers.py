# SPDX-License-Identifier: Apache-2.0
"""Numbers passed by programs, the errors about wrong ones, and values that are compared and
stored."""
import pickle

import numpy
import pytest
import vdrive

HIGHEST_SPEED = 2**32 - 1


@pytest.fixture
def axis(vdrive_session):
    axis = vdrive_session.axis("1.1")
    axis.enable()
    return axis


@pytest.mark.parametrize("position", [90, 90.0, numpy.int16(90), numpy.float64(90), numpy.float32(90)])
def test_a_whole_number_of_any_type_is_taken(axis, position):
    axis.move_to(position)
    assert axis.status().demand == 90


@pytest.mark.parametrize("unit, value, demand", [
    ("deg", 90, 1024), ("deg", 33.3, 379),  # 33.3 * 4096 / 360 = 378.88
    ("rev", 0.5, 2048), ("UU", 7, 7), ("rad", -1, -652),  # 4096 / (2 pi) = 651.9
])
def test_a_number_with_a_unit_is_rounded_to_user_units(axis, unit, value, demand):
    axis.move_to(value, unit=unit)
    assert axis.status().demand == demand
    if unit == "deg":
        axis.move_to(axis.unit.to_user_units(value))
        assert axis.status().demand == demand


def test_speeds_and_ramps_have_the_unit_of_their_call(vdrive_session, axis):
    axis.start_move(360, velocity=90, acceleration=180, deceleration=180.5, unit="deg")
    speed = vdrive_session.record(axis, ticks=1500).frames["velocity_demand_value"][:, 0]
    # 90 deg/s are 1024 UU/s; 180 deg/s^2 are 2.048 UU/s per tick.
    assert speed.max() == 1024
    assert abs(speed[400] - speed[0] - 400 * 2.048) <= 1
    axis.run_at(-45, unit="deg")
    assert axis.read(0x60FF) == -512


@pytest.mark.parametrize("error, message, call", [
    (ValueError, "position = 90.5: must be a whole number from -2147483648 to 2147483647 UU", lambda a: a.move_to(90.5)),
    (ValueError, "position = 1099511627776: must be from -2147483648 to 2147483647 UU", lambda a: a.move_to(2**40)),
    (ValueError, "position = nan: must be from -2147483648 to 2147483647 UU", lambda a: a.move_to(float("nan"))),
    (ValueError, "position = 1e[+]30 rev: must be from -2147483648 to 2147483647 UU",
     lambda a: a.move_to(1e30, unit="rev")),
    (ValueError, f"velocity = -5: must be from 0 to {HIGHEST_SPEED} UU/s", lambda a: a.move_to(1, velocity=-5)),
    (ValueError, f"acceleration = {2**70}: must be from 0 to {HIGHEST_SPEED} UU/s.2",
     lambda a: a.move_by(1, acceleration=2**70)),
    (ValueError, "torque = 40000: must be from -32768 to 32767 per mille", lambda a: a.apply_torque(40000)),
    (TypeError, "position = '1': must be a number$", lambda a: a.move_to("1", unit="deg")),
    (ValueError, "axis 1.1 has no unit 'mm'; it has UU, deg, rad, rev", lambda a: a.move_to(1, unit="mm")),
    (TypeError, "position = True: must be a whole number", lambda a: a.move_to(True)),
    (TypeError, "position = .*True: must be a whole number", lambda a: a.move_to(numpy.bool_(True))),
    (ValueError, "position = 1000.*000 deg: must be from -2147483648 to 2147483647 UU",
     lambda a: a.move_to(10**400, unit="deg")),
    (TypeError, "position = '\u00fc.*: must be a whole number", lambda a: a.move_to("\u00fc" * 100)),
    (TypeError, "position = '1000': must be a whole number", lambda a: a.move_to("1000")),
    (TypeError, "position = None: must be a whole number", lambda a: a.move_to(None)),
    (TypeError, r"position = array\(\[1\]\): must be a whole number", lambda a: a.move_to(numpy.array([1]))),
    (TypeError, "value = 'x': must be a whole number", lambda a: a.write(0x6081, "x")),
    (KeyError, "did you mean 'profile_velocity'", lambda a: a.read("profile_velocty")),
])
def test_a_bad_number_is_named_with_its_limits(axis, error, message, call):
    with pytest.raises(error, match=message):
        call(axis)
    assert axis.status().demand == 0


WHOLE = "must be a whole number from"
SECONDS = "must be a number of seconds$"


def group_of(session):
    return vdrive.AxisGroup(session, ["1.1", "1.2"])


@pytest.mark.parametrize("message, call", [
    (f"timeout = '5': {SECONDS}", lambda s, a: a.enable(timeout="5")),
    (f"timeout = True: {SECONDS}", lambda s, a: a.move_to(1, timeout=True)),
    (f"timeout = .*True.*: {SECONDS}", lambda s, a: a.halt(timeout=numpy.bool_(True))),
    (f"timeout = None: {SECONDS}", lambda s, a: a.wait_until(lambda status: True, None)),
    (f"timeout = \\[1\\]: {SECONDS}", lambda s, a: group_of(s).enable_all(timeout=[1])),
    (f"timeout = True: {SECONDS}", lambda s, a: s.stream().next(True)),
    (f"duration = True: {SECONDS}", lambda s, a: s.wait(True)),
    (f"patience = '1': {SECONDS}", lambda s, a: s.follow(patience="1")),
    (f"period = True: {SECONDS}", lambda s, a: s.on_status(print, period=True)),
    (f"find_timeout = True: {SECONDS}", lambda s, a: vdrive.Session(find_timeout=True)),
    (f"lead = '1': {SECONDS}", lambda s, a: group_of(s).start_streaming(lead="1")),
    ("rate = '2': must be a number$", lambda s, a: s.set_rate("2")),
    ("velocity_factor = True: must be a number$", lambda s, a: group_of(s).move_together([1, 2], velocity_factor=True)),
    ("user_units = '1': must be a number$", lambda s, a: a.unit.from_user_units("1")),
    (f"tick = '7': {WHOLE} 0 to {2**63 - 1}$", lambda s, a: s.wait_for_tick("7")),
    (f"tick = True: {WHOLE} 0 ", lambda s, a: s.send_set_points({}, tick=True)),
    (f"bench = True: {WHOLE} 0 to {2**32 - 1}$", lambda s, a: s.step(1, bench=True)),
    (f"number = '1': {WHOLE} 0 ", lambda s, a: s.find_bench("1")),
    (f"count = '3': {WHOLE} 0 ", lambda s, a: s.follow(count="3")),
    (f"capacity = True: {WHOLE} 1 ", lambda s, a: s.stream(capacity=True)),
    (f"snapshot = 'a': {WHOLE} 0 ", lambda s, a: s.restore_snapshot("a")),
    (f"bits = '1': {WHOLE} 0 to 65535$", lambda s, a: a.status().shows("1")),
    (f"benches\\[0\\] = True: {WHOLE} 0 ", lambda s, a: vdrive.StepClock(s, [True])),
    (f"steppers = '3': {WHOLE} 0 ", lambda s, a: vdrive.StepClock(s, [1], steppers="3")),
    (f"targets\\[1\\] = '2': {WHOLE} -2147483648 to 2147483647 UU$", lambda s, a: group_of(s).move_together([1, "2"])),
    ("targets = 5: must be a sequence$", lambda s, a: group_of(s).queue_move(5)),
    ("set_points\\[0\\] = True: must be a number$", lambda s, a: group_of(s).stream([True, 1])),
    ("unit = 5: must be a string$", lambda s, a: a.move_to(33.3, unit=5)),
    ("until = 5: must be a string$", lambda s, a: a.enable(until=5)),
    ("text = 1: must be a string$", lambda s, a: s.axis(1)),
    ("queue = 'yes': must be True or False$", lambda s, a: a.move_to(1, queue="yes")),
    ("condition = 1: must be a function$", lambda s, a: a.wait_until(1)),
    ("set_points = 5: must be a dict$", lambda s, a: s.send_set_points(5)),
    ("set_points\\[1\\] = 5: must be a dict of objects and their values$", lambda s, a: s.send_set_points({1: 5})),
    ("peers = 'host': must be a list of strings$", lambda s, a: vdrive.Session(peers="host")),
    ("axes = 5: must be an address, a name, an Axis, or a list of these$", lambda s, a: s.observe(5)),
    ("axes = 5: must be an address", lambda s, a: s.record(["1.1", 5], ticks=1)),
    ("object = None: must be an index, .index, subindex., or a name$", lambda s, a: a.read(None)),
    ("session = 5: must be a vdrive.Session$", lambda s, a: vdrive.AxisGroup(5, "1.1")),
    ("Axis.move_to[(][)] missing 1 required positional argument: 'position'$", lambda s, a: a.move_to()),
    ("Axis.move_to[(][)] got an unexpected keyword argument 'veloctiy'", lambda s, a: a.move_to(1, veloctiy=5)),
    ("Axis.move_to[(][)] takes 2 positional arguments but 3 were given$", lambda s, a: a.move_to(1, 2)),
    ("Axis.move_to[(][)] got multiple values for argument 'position'$", lambda s, a: a.move_to(1, position=2)),
    ("Session.__init__[(][)] got an unexpected keyword argument 'domian'", lambda s, a: vdrive.Session(domian=3)),
])
def test_a_wrong_argument_is_named_in_one_line(vdrive_session, axis, message, call):
    with pytest.raises(TypeError, match=f"^{message}") as wrong:
        call(vdrive_session, axis)
    assert "\n" not in str(wrong.value)
    assert axis.status().demand == 0


@pytest.mark.parametrize("message, call", [
    ("timeout = -1: must be from 0 to .* seconds$", lambda s, a: a.enable(timeout=-1)),
    ("tick = -1: must be from 0 to ", lambda s, a: s.wait_for_tick(-1)),
    ("bench = -1: must be from 0 to ", lambda s, a: s.wait(1, bench=-1)),
    ("capacity = 0: must be from 1 to ", lambda s, a: s.events(capacity=0)),
    ("index = 5.5: must be a whole number from 0 to 65535$", lambda s, a: a.read(5.5)),
])
def test_a_number_outside_of_its_range_is_named_in_one_line(vdrive_session, axis, message, call):
    with pytest.raises(ValueError, match=f"^{message}") as wrong:
        call(vdrive_session, axis)
    assert "\n" not in str(wrong.value)


def test_a_type_error_of_the_program_stays_as_it_is(axis):
    def condition(status):
        raise TypeError("of the program:\nin two lines")

    with pytest.raises(TypeError, match="^of the program:\nin two lines$"):
        axis.wait_until(condition)


@pytest.mark.parametrize("name, call", [
    ("targets", lambda group, numbers: group.move_together(numbers)),
    ("targets", lambda group, numbers: group.queue_move(numbers)),
    ("displacements", lambda group, numbers: group.move_by(numbers)),
])
@pytest.mark.parametrize("numbers", [[4, 1.5], (4, 1.5), numpy.array([4, 1.5])])
def test_a_group_refuses_a_fraction_and_does_not_move(vdrive_session, axis, name, call, numbers):
    group = group_of(vdrive_session)
    group.enable_all()
    with pytest.raises(ValueError, match=f"^{name}\\[1\\] = .*1.5.*: {WHOLE} -2147483648 to 2147483647 UU$"):
        call(group, numbers)
    status = group.status()
    assert status.demand.tolist() == [0, 0] and status.queued == 0


def test_a_stream_of_a_group_rounds_its_path(vdrive_session):
    group = vdrive.AxisGroup(vdrive_session, "1.1")
    group.enable_all()
    group.start_streaming()
    assert [group.stream([position]).demand[0] for position in (0.6, 1.4)] == [1, 1]
    group.stop_streaming()


def test_counts_are_checked_before_anything_happens(vdrive_session):
    with pytest.raises(ValueError, match="ticks = -1: must be from 0 to 9223372036854775807"):
        vdrive_session.step(-1)
    with pytest.raises(ValueError, match="ticks = -1: must be from 0 to 9223372036854775807"):
        vdrive_session.record(ticks=-1)
    with pytest.raises(ValueError, match="count = -1: must be from 0 to 9223372036854775807"):
        vdrive_session.follow().take(-1)
    assert vdrive_session.step(0) == 0


def test_handles_of_one_axis_are_equal(vdrive_bench, vdrive_session):
    axis = vdrive_session.axis("1.1")
    assert axis == vdrive_session.axis(axis.name) and hash(axis) == hash(vdrive_session.axis("1.1"))
    assert axis != vdrive_session.axis("1.2") and axis != "1.1"
    with vdrive_bench.session() as other:
        assert axis != other.axis("1.1"), "commands of the other session are of another owner"


def test_a_status_is_compared_by_its_values_and_can_be_stored(axis):
    first = axis.status()
    assert first == axis.status() and hash(first) == hash(axis.status()), "no tick has passed"
    stored = pickle.loads(pickle.dumps(first))
    assert stored == first and stored.owner == first.owner and stored.state == first.state
    axis.move_to(10)
    assert axis.status() != first and first != 1
    state = first.__getstate__()
    for other in (state[:-1], (*state[:-1], state[-1] + b"x")):
        with pytest.raises(ValueError, match="from another version of vdrive"):
            stored.__setstate__(other)


def test_a_wrong_field_of_a_recording_names_the_nearest(vdrive_session):
    recording = vdrive_session.record(ticks=2)
    with pytest.raises(KeyError, match="no field 'positon' .did you mean 'position'"):
        recording["positon"]
    with pytest.raises(KeyError, match="no field 'zzzzzz'\""):
        recording["zzzzzz"]


def test_values_of_one_thing_are_equal(vdrive_bench, vdrive_session):
    axis, other = (vdrive_session.axis(name) for name in ("1.1", "1.2"))
    assert axis.unit == axis.unit and hash(axis.unit) == hash(axis.unit) and axis.unit != "deg"
    first, second = vdrive_session.find_bench().axes
    assert first == vdrive_session.find_bench().axes[0] and first != second
    seen = vdrive_session.observe()
    assert seen == vdrive_session.observe() and hash(seen) == hash(vdrive_session.observe())
    axis.acquire()
    other.acquire()
    assert seen != vdrive_session.observe()


@pytest.mark.parametrize("call", [lambda: vdrive.AxisGroup(None, ["1.1"]), lambda: vdrive.AxisGroup(None, []),
                                  lambda: vdrive.StepClock(None, [1])])
def test_none_is_no_session(call):
    with pytest.raises(TypeError):
        call()


def test_an_observer_is_called(vdrive_session):
    with pytest.raises(TypeError, match="function = None: must be callable"):
        vdrive_session.on_status(None, "1.1")
