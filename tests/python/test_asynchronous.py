# SPDX-License-Identifier: Apache-2.0
"""Motions and waits awaited by a task of asyncio."""
import asyncio
import gc
import re
import threading

import pytest

import vdrive

PATIENCE = 60
FAR = 2_000_000_000  # UU: at 20,000 UU/s a move of more than a day
DAY = 86_400  # s: the default of 60 s of drive time takes a tenth of a second in lock-step
THREAD = "vdrive await"  # the name of the thread of a call


@pytest.fixture(params=["lockstep", "realtime"])
def session(request):
    with vdrive.Bench(2, clock=request.param) as bench, bench.session() as opened:
        opened.command_each(None, "enable")
        yield opened


def is_halted(axis):
    return bool(axis.read("ds402_controlword") & 0x0100)  # bit 8 (CiA 402-2)


async def cancel_in_motion(awaited, axis):
    """Cancel the task of `awaited` once the axis moves."""
    task = asyncio.create_task(awaited)
    await axis.wait_until_async(lambda status: status.velocity > 1000, timeout=PATIENCE)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await asyncio.wait_for(task, PATIENCE)


def join_threads():
    """Wait for the threads of the calls: a thread reports its result before it ends."""
    for thread in threading.enumerate():
        if thread.name == THREAD:
            thread.join(PATIENCE)
            assert not thread.is_alive()


def test_a_motion_is_awaited_next_to_other_tasks(session):
    async def run():
        one = session.axis("1.1").start_move(1000, velocity=20000)
        other = session.axis("1.2").start_move(-500, velocity=20000)
        await asyncio.wait_for(asyncio.gather(one, other.wait_async()), PATIENCE)

    asyncio.run(run())
    assert [status.position for status in session.observe().axes] == [1000, -500]


def test_a_hundred_motions_are_awaited_at_once():
    with vdrive.Bench(100) as bench, bench.session() as session:
        session.command_each(None, "enable")

        async def run():
            motions = [axis.start_move(number, velocity=20000) for number, axis in enumerate(session.axes())]
            await asyncio.gather(*(motion.wait_async() for motion in motions))

        asyncio.run(run())
        assert [status.position for status in session.observe().axes] == list(range(100))


def test_a_fault_ends_an_awaited_motion_as_failed(session):
    axis = session.axis("1.1")

    async def run():
        motion = axis.start_move(FAR, velocity=20000)
        axis.disturb("over_temperature")
        await motion

    with pytest.raises(vdrive.Failed):
        asyncio.run(run())


def test_a_cancelled_task_halts_the_axis_that_it_awaits_and_no_other(session):
    axis, other = session.axis("1.1"), session.axis("1.2")
    other.start_move(-FAR, velocity=20000)
    asyncio.run(cancel_in_motion(axis.start_move(FAR, velocity=20000).wait_async(DAY), axis))
    assert is_halted(axis) and not is_halted(other)
    axis.wait_until(lambda status: status.velocity == 0, timeout=PATIENCE)
    assert axis.status().position < FAR


def test_a_time_limit_of_asyncio_halts_the_axis(session):
    axis = session.axis("1.1")

    async def run():
        await asyncio.wait_for(axis.start_move(FAR, velocity=20000).wait_async(DAY), timeout=0.05)

    with pytest.raises(asyncio.TimeoutError):
        asyncio.run(run())
    assert is_halted(axis)


def test_a_cancelled_task_leaves_a_motion_that_has_ended(session):
    axis = session.axis("1.1")

    async def run():
        motion = axis.start_move(1000, velocity=20000)
        motion.wait()
        task = asyncio.create_task(motion.wait_async())
        await asyncio.sleep(0)  # the task waits now
        task.cancel()
        await asyncio.wait([task], timeout=PATIENCE)

    asyncio.run(run())
    assert not is_halted(axis)


def test_a_cancelled_wait_for_a_group_halts_its_axes(session):
    group = vdrive.AxisGroup(session, ["1.1", "1.2"])
    group.queue_move([FAR // 10, -FAR // 10])  # such a move may last 4,294 s
    asyncio.run(cancel_in_motion(group.wait_all_async(timeout=DAY), session.axis("1.1")))
    for axis in session.axes():
        axis.wait_until(lambda status: status.velocity == 0, timeout=PATIENCE)
    assert group.status().state != "moving"


def test_a_cancelled_wait_for_a_condition_stops_no_axis(session):
    axis = session.axis("1.1")
    axis.start_move(FAR, velocity=20000)
    asyncio.run(cancel_in_motion(axis.wait_until_async(lambda status: False, timeout=DAY), axis))
    assert not is_halted(axis) and axis.status().velocity_demand_value > 0


def test_a_condition_is_awaited_and_gives_its_status(session):
    axis = session.axis("1.1")
    axis.start_move(FAR, velocity=20000)
    status = asyncio.run(axis.wait_until_async(lambda status: status.position > 500))
    assert status.position > 500


def test_an_exception_of_a_condition_ends_the_task(session):
    with pytest.raises(ZeroDivisionError):
        asyncio.run(session.axis("1.1").wait_until_async(lambda status: 1 / 0))


def test_a_condition_that_raises_stop_iteration_ends_the_task(session):
    waiting = session.axis("1.1").wait_until_async(lambda status: next(iter(())))
    with pytest.raises(RuntimeError, match="StopIteration"):
        asyncio.run(asyncio.wait_for(waiting, PATIENCE))


class HeldCondition:
    """A condition that blocks its thread until it is released, then fails."""

    def __init__(self):
        self.called, self.let_go = threading.Event(), threading.Event()

    def __call__(self, status):
        self.called.set()
        self.let_go.wait(PATIENCE)
        return 1 / 0


async def leave(axis, condition):
    """Cancel a task whose condition is blocked: the task ends before its call."""
    task = asyncio.create_task(axis.wait_until_async(condition))
    await asyncio.to_thread(condition.called.wait, PATIENCE)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await asyncio.wait_for(task, PATIENCE)


def test_asyncio_does_not_complain_of_a_call_that_fails_after_its_task_was_cancelled(session, monkeypatch):
    monkeypatch.setattr("vdrive._asynchronous._PATIENCE", 0.01)
    condition, complaints = HeldCondition(), []

    async def run():
        asyncio.get_running_loop().set_exception_handler(lambda _, context: complaints.append(context))
        await leave(session.axis("1.1"), condition)
        condition.let_go.set()
        await asyncio.to_thread(join_threads)

    asyncio.run(run())
    gc.collect()
    assert complaints == []


class LateLoop(asyncio.SelectorEventLoop):
    """A loop that is closed just after the thread of a call has asked whether it is."""

    def is_closed(self):
        return threading.current_thread().name != THREAD and super().is_closed()


def test_a_call_that_ends_after_the_loop_was_closed_leaves_no_traceback(session, monkeypatch):
    monkeypatch.setattr("vdrive._asynchronous._PATIENCE", 0.01)
    tracebacks = []
    monkeypatch.setattr("threading.excepthook", tracebacks.append)
    condition, loop = HeldCondition(), LateLoop()
    loop.run_until_complete(leave(session.axis("1.1"), condition))
    loop.close()
    condition.let_go.set()
    join_threads()
    assert tracebacks == []


def test_drive_time_is_awaited_to_the_tick():
    with vdrive.Bench(1) as bench, bench.session() as session:
        begin = session.step()
        # 250.5 periods of 1 ms: the wait ends at the first tick that is not earlier.
        assert asyncio.run(session.wait_async(0.2505)) == begin + 251
        assert asyncio.run(session.wait_async(0.0)) == begin + 251


@pytest.mark.parametrize("duration", [-1, float("inf"), float("nan"), 1e10, "1", True])
def test_a_wrong_duration_is_refused_as_wait_does(duration):
    with vdrive.Bench(1) as bench, bench.session() as session:
        with pytest.raises((TypeError, ValueError), match="duration = ") as refused:
            session.wait(duration)
        with pytest.raises(refused.type, match=f"^{re.escape(str(refused.value))}$"):
            asyncio.run(asyncio.wait_for(session.wait_async(duration), PATIENCE))


def test_a_cancelled_wait_for_drive_time_ends():
    with vdrive.Bench(1, clock="realtime") as bench, bench.session() as session:
        async def run():
            with pytest.raises(asyncio.TimeoutError):
                await asyncio.wait_for(session.wait_async(3600.0), timeout=0.01)

        asyncio.run(run())
        join_threads()


@pytest.mark.parametrize("clock", ["lockstep", "realtime"])
def test_a_cancelled_task_leaves_an_axis_that_another_session_took(clock):
    async def run():
        task = asyncio.create_task(axis.start_move(FAR, velocity=20000).wait_async(DAY))
        await axis.wait_until_async(lambda status: status.velocity > 1000, timeout=PATIENCE)
        other.axis("1.1").take_over()
        task.cancel()
        await asyncio.wait_for(task, PATIENCE)

    with vdrive.Bench(1, clock=clock) as bench, bench.session() as session, bench.session() as other:
        axis = session.axis("1.1")
        axis.enable()
        with pytest.raises(asyncio.CancelledError):
            asyncio.run(run())
        assert not is_halted(axis)


def test_a_cancelled_task_whose_axis_cannot_be_halted_says_so(session, monkeypatch):
    def halt(self, *, until):
        raise vdrive.Lost("the service does not answer")

    async def run():
        task = asyncio.create_task(axis.start_move(FAR, velocity=20000).wait_async(DAY))
        await axis.wait_until_async(lambda status: status.velocity > 1000, timeout=PATIENCE)
        task.cancel()
        await asyncio.wait_for(task, PATIENCE)

    axis = session.axis("1.1")
    monkeypatch.setattr(vdrive.Axis, "halt", halt)
    with pytest.raises(vdrive.Lost, match="does not answer"):
        asyncio.run(run())
    session.interrupt()  # the call still waits for its motion
    join_threads()
