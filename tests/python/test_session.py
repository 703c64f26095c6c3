# SPDX-License-Identifier: Apache-2.0
"""Sessions, clocks, groups and streams."""
import asyncio
import gc
import queue
import threading

import numpy
import pytest
import vdrive


def test_missing_benches_and_axes_are_not_found(vdrive_session):
    with pytest.raises(vdrive.NotFound):
        vdrive_session.axis("1.7")
    with pytest.raises(LookupError):
        vdrive_session.axis("lift")


def test_invalid_options_of_a_session_are_an_error():
    with pytest.raises(vdrive.ConfigurationError, match="233"):
        vdrive.Session(domain=233)
    with pytest.raises(ValueError, match="keep_alive"):
        vdrive.Session(keep_alive="sometimes")


def test_a_closed_session_has_released_its_axes_and_its_handles_fail(vdrive_bench):
    session = vdrive_bench.session()
    axis = session.axis("1.1")
    follower, stream, events = session.follow(), session.stream(), session.events()
    clock = vdrive.StepClock(session, [1])
    axis.enable()
    assert axis.status().owner == session.id
    session.close()
    assert session.is_closed
    for call in (axis.enable, axis.status, session.find_benches, lambda: next(follower), clock.step):
        with pytest.raises(vdrive.Failed, match="closed"):
            call()
    # Samples received earlier can still be taken; then the iterators end.
    assert len(list(stream)) <= 10 and len(list(events)) <= 10
    assert vdrive_bench.session().axis("1.1").status().owner == 0


def test_a_handle_keeps_its_session(vdrive_bench):
    axis = vdrive_bench.session().axis("1.1")
    gc.collect()
    axis.enable()
    assert axis.status().is_enabled


def test_steps_and_waits_take_exactly_the_given_time(vdrive_session):
    begin = vdrive_session.step(5)
    assert vdrive_session.step() == begin + 1
    assert vdrive_session.wait(0.0105) == begin + 12  # 10.5 ms are 11 ticks
    assert vdrive_session.wait_for_tick(begin + 100, bench=1) == begin + 100


def test_a_step_clock_steps_its_benches_together(vdrive_session):
    with vdrive.StepClock(vdrive_session, [1]) as clock:
        begin = clock.step(1)
        assert clock.step_for(0.02) == [begin[0] + 20]
        assert clock.now == pytest.approx(0.021)
    with pytest.raises(vdrive.Failed, match="closed"):
        clock.step()


def test_a_step_clock_waits_for_as_many_steppers_as_it_is_told_to(vdrive_session):
    with vdrive.StepClock(vdrive_session, [1], steppers=2) as clock:
        with pytest.raises(vdrive.TimedOut, match="waits for more steppers: 1 program has joined its clock"):
            clock.step(1, patience=0.3)
    with pytest.raises(vdrive.Refused, match="a clock has at most 64 steppers"):
        vdrive.StepClock(vdrive_session, [1], steppers=65)


def test_a_snapshot_restores_the_axes(vdrive_session):
    axis = vdrive_session.axis("1.1")
    axis.enable()
    axis.move_to(1000)
    number = vdrive_session.take_snapshot()
    axis.move_to(5000)
    vdrive_session.restore_snapshot(number)
    assert axis.status().position == 1000
    assert list(vdrive_session.snapshots()) == [number]
    vdrive_session.drop_snapshot(number)
    assert vdrive_session.snapshots() == {}


def test_a_group_moves_on_a_straight_line_given_as_an_array(vdrive_session):
    group = vdrive.AxisGroup(vdrive_session, ["1.1", "1.2"])
    group.enable_all()
    seen = []
    group.move_together(numpy.array([4000.0, -8000.0]), progress=lambda *step: seen.append(step))
    status = group.status()
    assert isinstance(status.actual, numpy.ndarray)
    assert status.demand.tolist() == [4000.0, -8000.0]
    assert status.actual == pytest.approx([4000.0, -8000.0], abs=1)
    assert [tick for tick, _ in seen] == sorted(tick for tick, _ in seen) and seen[-1][1] == 1.0
    with pytest.raises(ValueError, match="2 axes, not 3"):
        group.move_by([1, 2, 3])


def test_an_exception_of_a_group_observer_is_raised_and_the_group_continues(vdrive_session):
    group = vdrive.AxisGroup(vdrive_session, ["1.1", "1.2"])
    group.enable_all()

    def stumble(tick, fraction):
        if fraction > 0.2:
            raise RuntimeError("stumbled")

    with pytest.raises(RuntimeError, match="stumbled"):
        group.move_together([4000, 4000], progress=stumble)
    vdrive_session.wait(2.0)
    assert group.status().demand.tolist() == [4000.0, 4000.0]


def test_a_group_names_the_session_that_takes_one_of_its_axes(vdrive_bench, vdrive_session):
    group = vdrive.AxisGroup(vdrive_session, ["1.1", "1.2"])
    group.enable_all()
    with vdrive_bench.session(program="another") as other:
        axis, taken = other.axis("1.2"), []

        def take(tick, fraction):
            if fraction > 0.2 and not taken:
                taken.append(tick)
                axis.take_over()

        with pytest.raises(vdrive.Refused, match="another session has taken an axis") as refusal:
            group.move_together([200000, 100000], progress=take)
        owner = refusal.value.owner
        assert (owner.axis, owner.session, owner.program) == ("1.2", other.id, "another")
        assert refusal.value.code == vdrive.Reason.NOT_OWNER
        assert axis.status().is_enabled and not vdrive_session.axis("1.1").status().is_enabled


def test_a_streamed_position_is_the_demand_of_the_tick(vdrive_session):
    group = vdrive.AxisGroup(vdrive_session, ["1.1"])
    group.enable_all()
    group.start_streaming()
    # The axis follows each set-point for one tick: the set-point is the demand of the tick it was
    # sent for.
    demands = [group.stream([position]).demand[0] for position in (1, 2, 3, 4, 5)]
    assert demands == [1, 2, 3, 4, 5]
    group.stop_streaming()


def test_streamed_velocities_and_torques_are_the_demands_of_the_tick(vdrive_session):
    group = vdrive.AxisGroup(vdrive_session, ["1.1"])
    group.enable_all()
    group.start_streaming(what="velocities")
    demands = [group.stream([velocity]).axes[0].velocity_demand_value for velocity in (100, 200, 300)]
    assert demands == [100, 200, 300]
    group.stop_streaming()
    group.start_streaming(what="torques")
    group.stream([8])
    assert group.stream([8]).axes[0].torque_demand == 8
    group.stop_streaming()
    with pytest.raises(ValueError, match="what is \"positions\", \"velocities\" or \"torques\", not 'jerks'"):
        group.start_streaming(what="jerks")


def test_following_in_lockstep_steps_one_tick_for_each_sample(vdrive_session):
    begin = vdrive_session.step()
    samples = list(vdrive_session.follow("1.1", count=10))
    assert [sample.tick for sample in samples] == list(range(begin + 1, begin + 11))
    assert samples[0][0].id == "1.1" and len(samples[0]) == 1


@pytest.mark.parametrize("follow", ["follow", "stream"])
def test_a_follower_has_each_axis_once(vdrive_session, follow):
    with pytest.raises(vdrive.Refused, match="axis 1.1 is named twice"):
        getattr(vdrive_session, follow)(["1.1", "1.2", "1.1"])


def test_a_follower_takes_samples_as_one_array_and_no_more_than_its_count(vdrive_session):
    axis = vdrive_session.axis("1.2")
    axis.enable()
    axis.start_move(3000)
    begin = vdrive_session.step()
    follower = vdrive_session.follow(["1.2", "1.1"], count=5)
    first = next(follower)
    frames = follower.take(3)
    assert first.tick == begin + 1
    assert frames["tick"].tolist() == [[begin + number] * 2 for number in (2, 3, 4)]
    last = follower.take(9)
    assert last.shape == (1, 2)
    status = vdrive_session.axis("1.2").status()
    assert all(last[name][0, 0] == getattr(status, name) for name in last.dtype.names
               if hasattr(status, name))
    with pytest.raises(StopIteration):
        next(follower)


def test_a_recording_has_the_values_of_each_sample(vdrive_session):
    axis = vdrive_session.axis("1.2")
    axis.enable()
    axis.start_move(3000)
    recording = vdrive_session.record(["1.1", "1.2"], ticks=50)
    assert recording["position"].shape == (50, 2)
    assert numpy.diff(recording.ticks).tolist() == [1] * 49
    assert numpy.allclose(recording.time, numpy.arange(50) * vdrive_session.find_bench().period)
    assert recording["demand"][-1, 1] == axis.status().demand > 0
    assert recording.axis("1.2")["owner"].tolist() == [vdrive_session.id] * 50
    assert recording["load_position_actual_value"] is not None and recording.missed == 0


def test_a_stream_gives_every_sample_in_arrays(vdrive_session):
    with vdrive_session.stream() as stream:
        assert stream.next(timeout=0) is None
        begin = vdrive_session.step(20)
        ticks = []
        while not ticks or ticks[-1] < begin:
            frames = stream.take(timeout=10)
            assert frames.shape[1] == 2 and stream.axes == ["1.1", "1.2"]
            ticks += frames["tick"][:, 0].tolist()
        assert ticks == list(range(begin - 19, begin + 1))
        assert stream.dropped == 0


def test_a_stream_without_a_reader_drops_the_oldest_and_counts(vdrive_session):
    with vdrive_session.stream(capacity=5) as stream:
        begin = vdrive_session.step(20)
        newest = stream
        while newest.dropped < 15:
            assert stream.fileno() >= 0
            threading.Event().wait(0.01)
        assert stream.take(timeout=10)["tick"][:, 0].tolist() == list(range(begin - 4, begin + 1))


def test_events_describe_state_changes(vdrive_session):
    with vdrive_session.events() as events:
        axis = vdrive_session.axis("1.1")
        axis.enable()
        axis.disturb("over_current")
        vdrive_session.step(10)
        for event in events:
            if event.kind == "fault":
                break
        assert (event.bench, event.axis) == (1, 1) and event.code == axis.status().error_code != 0


def test_status_arrives_in_an_asyncio_loop_next_to_other_tasks(vdrive_session):
    async def watch(stream):
        seen = []
        async for sample in stream:
            seen.append(sample.tick)
            if len(seen) == 30:
                return seen

    async def run():
        axis = vdrive_session.axis("1.1")
        async with vdrive_session.follow_async("1.1") as stream:
            watching = asyncio.create_task(watch(stream))
            await asyncio.to_thread(axis.enable)
            await asyncio.to_thread(axis.move_to, 2000)
            return await asyncio.wait_for(watching, 60)

    ticks = asyncio.run(run())
    assert ticks == list(range(ticks[0], ticks[0] + 30))


def test_the_end_of_a_stream_ends_its_loop(vdrive_session):
    async def run():
        stream = vdrive_session.follow_async()
        stream.close()
        return [sample async for sample in stream]

    assert asyncio.run(run()) == []


def test_one_task_at_a_time_waits_for_a_stream(vdrive_session):
    async def run():
        async with vdrive_session.events_async() as stream:
            waiting = asyncio.create_task(anext(stream))
            await asyncio.sleep(0)  # the task waits now
            with pytest.raises(RuntimeError, match="another task waits"):
                await anext(stream)
            vdrive_session.axis("1.1").enable()
            return await asyncio.wait_for(waiting, 60)

    assert asyncio.run(run()).axis == 1


def test_an_axis_of_another_session_is_refused(vdrive_session):
    with vdrive.Bench() as other, other.session() as its:
        axis = its.axis("1.1")
        for call in (vdrive_session.observe, vdrive_session.follow, vdrive_session.stream, vdrive_session.acquire,
                     lambda axes: vdrive.AxisGroup(vdrive_session, axes)):
            with pytest.raises(ValueError, match="axis 1.1 belongs to another session"):
                call([axis])


def test_another_thread_runs_while_a_move_waits(vdrive_session):
    axis = vdrive_session.axis("1.1")
    axis.enable()
    ended = []

    def move():
        with pytest.raises(vdrive.Failed, match="interrupt"):
            axis.move_to(10**9, velocity=20000, timeout=1e6)  # 50,000 s of drive time
        ended.append(True)

    thread = threading.Thread(target=move)
    thread.start()
    while axis.status().position == 0:  # the move has released the interpreter lock
        assert thread.is_alive()
    vdrive_session.interrupt()
    thread.join(60)
    vdrive_session.end_interrupt()
    assert ended == [True] and 0 < axis.status().position < 10**9


class Observed:
    """Records the calls of an observer."""

    def __init__(self):
        self.items = []
        self.changed = threading.Condition()

    def __call__(self, item):
        with self.changed:
            self.items.append(item)
            self.changed.notify_all()

    def wait(self, condition):
        """Wait for an item that meets the condition; return False after 30 s."""
        with self.changed:
            return self.changed.wait_for(lambda: any(map(condition, self.items)), timeout=30)


def test_an_observer_receives_the_events(vdrive_session):
    observed = Observed()
    axis = vdrive_session.axis("1.1")
    with vdrive_session.on_event(observed):
        axis.acquire()
        assert observed.wait(lambda event: event.kind == "control_changed" and event.axis == 1)
    count = len(observed.items)
    axis.enable()
    again = Observed()
    with vdrive_session.on_event(again, history=True):
        assert again.wait(lambda event: event.kind == "state_changed")
    assert len(observed.items) == count


def test_an_observer_receives_the_newest_state(vdrive_session):
    observed = Observed()
    with vdrive_session.on_status(observed, ["1.1", "1.2"], period=0.001):
        # The observer starts in its own thread, possibly after 50 steps.
        while not observed.items:
            vdrive_session.step()
        tick = vdrive_session.step(50)
        assert observed.wait(lambda sample: sample.tick >= tick)
    assert [status.id for status in observed.items[0].axes] == ["1.1", "1.2"]
    ticks = [sample.tick for sample in observed.items]
    assert ticks == sorted(set(ticks))
    count = len(observed.items)
    vdrive_session.step(50)
    assert len(observed.items) == count
    with pytest.raises(ValueError, match="period"):
        vdrive_session.on_status(observed, period=0)


def test_an_observer_that_raises_is_called_again(vdrive_session, monkeypatch):
    reported = Observed()
    monkeypatch.setattr("threading.excepthook", lambda item: reported(str(item.exc_value)))

    def fail(event):
        raise RuntimeError(f"no use of {event.kind}")

    axis = vdrive_session.axis("1.1")
    with vdrive_session.on_event(fail):
        axis.acquire()
        axis.enable()
        assert reported.wait(lambda text: text == "no use of control_changed")
        assert reported.wait(lambda text: text == "no use of state_changed")


def test_an_observer_ends_with_its_session_and_may_end_itself(vdrive_bench):
    observed = Observed()
    itself = queue.SimpleQueue()  # the first sample may arrive before on_status returns
    with vdrive_bench.session() as session:
        itself.put(session.on_status(lambda sample: (observed(sample), itself.get().close()), "1.1"))
        while not observed.items:
            session.step()
        forgotten = session.on_event(observed, history=True)
    forgotten.close()
    assert len([item for item in observed.items if isinstance(item, vdrive.Observation)]) == 1


def test_several_axes_are_acquired_together_or_not_at_all(vdrive_bench, vdrive_session):
    with vdrive_bench.session() as other:
        other.axis("1.2").acquire()
        with pytest.raises(vdrive.Refused) as refusal:
            vdrive_session.acquire(["1.1", "1.2"])
        assert refusal.value.code == 0x08000021
        assert vdrive_session.observe().owners == [0, other.id]
        other.release(1)
        vdrive_session.acquire()
        assert vdrive_session.observe().owners == [vdrive_session.id] * 2


def test_set_points_bring_any_objects_to_axes(vdrive_session):
    axis = vdrive_session.axis("x")
    axis.enable()
    vdrive_session.send_set_points({1: {"profile_velocity": 4321, 0x6083: 54321}})
    tick = vdrive_session.step(1)
    assert axis.read("profile_velocity") == 4321
    assert axis.read("profile_acc") == 54321
    vdrive_session.send_set_points({1: {0x6060: 3}}, tick=tick + 2)
    vdrive_session.step(1)
    assert axis.status().mode == "none"
    vdrive_session.step(1)
    assert axis.status().mode == "profile velocity"


def test_set_points_with_a_wrong_value_or_too_many_objects_are_not_sent(vdrive_session):
    with pytest.raises(ValueError, match="6040h.* = 70000: must be from 0 to 65535"):
        vdrive_session.send_set_points({1: {0x6040: 70000}})
    many = dict.fromkeys([0x6081, 0x6083, 0x6084, 0x60C5, 0x60C6, 0x6072, 0x6065, 0x6067, 0x6068], 1)
    with pytest.raises(vdrive.Failed, match="9 objects; at most 8"):
        vdrive_session.send_set_points({1: many})


def test_an_abandoned_session_commands_nothing_and_releases_nothing(vdrive_bench, vdrive_session):
    with vdrive_bench.session() as lost:
        axis = lost.axis("1.1")
        axis.enable()
        lost.abandon()
        with pytest.raises(vdrive.Error):
            axis.disable()
        with pytest.raises(vdrive.Error):
            lost.step(1)
        status = vdrive_session.axis("1.1").status()
        assert status.owner == lost.id and status.is_enabled


def next_news(changes, bench):
    """The next change of this bench."""
    while (change := changes.next(timeout=30)) is not None:
        if change.bench == bench:
            assert f"bench {bench} " in change.text and change.silence >= 0
            return change.news
    raise AssertionError(f"nothing was reported about bench {bench}")


def test_services_that_come_and_go_are_reported(vdrive_benches, pytestconfig):
    over = pytestconfig.getoption("--vdrive-over")
    first, = vdrive_benches(1)
    with first.session() as session, session.service_changes() as changes:
        assert next_news(changes, 1) == "found"
        with vdrive.Bench(axes=1, number=2, over=over, beside=first):
            assert next_news(changes, 2) == "found"
        assert next_news(changes, 2) in ("went_offline", "fell_silent")
        assert changes.dropped == 0
        # The next watch starts over and replaces the stream.
        seen, arrived = [], threading.Event()

        def note(change):
            seen.append((change.bench, change.news))
            arrived.set()

        with session.watch_services(note):
            assert arrived.wait(30) and seen[0] == (1, "found")


@pytest.mark.parametrize("stream", ["service_changes", "events"])
def test_a_stream_takes_the_place_of_the_one_before_which_ends(vdrive_benches, stream):
    first, = vdrive_benches(1)
    with first.session() as session:
        replaced = getattr(session, stream)()
        present = getattr(session, stream)()
        # The replaced stream ends, even for a thread that waits for it, without ending the new one.
        for _ in replaced:
            pass
        replaced.close()
        if stream == "events":
            session.axis("1.1").enable()
            assert present.next(timeout=30) is not None
        else:
            assert next_news(present, 1) == "found"


def test_a_follower_counts_the_samples_that_were_taken_late(vdrive_bench, vdrive_session):
    follower = vdrive_session.follow("1.1", pace="observe")
    with vdrive_bench.session() as stepper:
        first = stepper.step(1)
        for _ in range(4):
            last = stepper.step(1)
        assert vdrive_session.observe("1.1").tick == last
        # A tick is 1 ms. Each step of one tick is published; samples from before lag by more.
        ticks = [next(follower).tick]
        longest = (last - ticks[0]) / 1000
        assert follower.lateness.last == pytest.approx(longest)
        while ticks[-1] < last:
            ticks.append(next(follower).tick)
        assert first in ticks
        lateness = follower.lateness
        assert lateness.samples == len(ticks) and lateness.late == len(ticks) - 1
        assert lateness.last == 0 and lateness.longest == pytest.approx(longest)
        follower.close()
        assert follower.lateness.samples == len(ticks)
        assert repr(lateness).startswith(f"<vdrive.Lateness: {len(ticks) - 1} of {len(ticks)} samples")


@pytest.mark.parametrize("opened", [
    lambda session: session.stream("1.1"),
    lambda session: session.events(),
    lambda session: session.service_changes(),
])
def test_a_closed_stream_ends_a_loop_and_refuses_next(vdrive_session, opened):
    stream = opened(vdrive_session)
    assert not stream.is_closed
    stream.close()
    list(stream)  # the remaining samples; the loop ends
    assert stream.is_closed
    with pytest.raises(vdrive.Error, match="closed"):
        stream.next(timeout=0)


def test_take_refuses_a_closed_stream(vdrive_session):
    stream = vdrive_session.stream("1.1")
    stream.close()
    list(stream)  # the remaining samples
    with pytest.raises(vdrive.Error, match="closed"):
        stream.take(timeout=0)


def test_a_group_without_axes_is_a_wrong_value(vdrive_session):
    with pytest.raises(ValueError, match=r"axes = \[\]: needs at least one axis"):
        vdrive.AxisGroup(vdrive_session, [])


@pytest.mark.parametrize("call", [
    lambda session: session.observe([]),
    lambda session: session.follow([]),
    lambda session: session.stream([]),
    lambda session: session.acquire([]),
    lambda session: session.record([], ticks=1),
])
def test_a_call_that_needs_an_axis_finds_none_in_an_empty_list(vdrive_session, call):
    with pytest.raises(vdrive.NotFound, match="no axis given"):
        call(vdrive_session)


def test_commands_to_no_axis_and_reports_of_none_do_nothing(vdrive_session):
    assert vdrive_session.command_each([], "halt") == []
    with vdrive_session.on_status(print, []) as observer:
        assert observer.error is None


@pytest.mark.parametrize("factor", ["velocity_factor", "acceleration_factor", "deceleration_factor"])
@pytest.mark.parametrize("value", [0, -0.5, 1.001, float("nan"), float("inf")])
def test_a_factor_of_a_group_that_is_out_of_range_is_a_wrong_value(vdrive_session, factor, value):
    group = vdrive.AxisGroup(vdrive_session, ["1.1"])
    for move in (group.move_together, group.move_by, group.queue_move):
        with pytest.raises(ValueError, match=f"{factor} = {value}: must be above 0 and at most 1"):
            move([100], **{factor: value})
