# SPDX-License-Identifier: Apache-2.0
"""Tests that share a bench, in separate runs of pytest: none affects the next one."""
import pytest

OVER = pytest.mark.parametrize("over", ["local", "dds"])


def run(pytester, over, text, **outcomes):
    """Run a file of tests in its order, with the functions of PRELUDE."""
    pytester.makepyfile(PRELUDE + text)
    result = pytester.runpytest_subprocess("-q", "-p", "no:cacheprovider", "--vdrive-over", over,
                                           timeout=250)
    result.assert_outcomes(**outcomes)
    return result


# The image of an axis is everything that it publishes except values that never return to their
# start: the tick and the epoch of the owners.
PRELUDE = """
import os
import pytest, vdrive

KEPT = []
GOES_ON = ("tick", "missed", "owner_epoch")

def image(session):
    record = session.observe().array()
    return [[axis[name].item() for name in record.dtype.names if name not in GOES_ON]
            for axis in record]

def check_start(session):
    assert session.observe().owners == [0, 0]
    if not KEPT:
        KEPT.append(image(session))
    assert image(session) == KEPT[0]
    axis = session.axis("1.1")
    assert axis.status().state == "Switch on disabled" and axis.status().position == 0
    assert axis.read("profile_velocity") != 1234
"""

LEAVES = """
def wait_for_fault(session, axis):
    axis.disturb("over_current")
    axis.wait_until(lambda status: status.state == "Fault")

def move(session, axis):
    axis.start_move(10**6)
    session.step(50)

def send_set_point(session, axis):
    session.send_set_points({1: {0x6081: 4321}}, tick=session.step(1) + 3)

def fail(session, axis):
    assert session is None

def fill_snapshots(session, axis):
    while len(session.snapshots()) < 16:
        session.take_snapshot()

LEAVES = {
    "nothing": lambda session, axis: None,
    "a failure": fail,
    "a motion": move,
    "a waiting set-point": send_set_point,
    "a fault": wait_for_fault,
    "a blocked load": lambda session, axis: axis.disturb("blocked_load"),
    "a stepper": lambda session, axis: HELD.append(vdrive.StepClock(session, [1])),
    "16 snapshots": fill_snapshots,
    "a closed session": lambda session, axis: session.close(),
}
HELD, BENCHES = [], []

def leave(session, what):
    HELD.append(session)  # nobody closes it
    axis = session.axis("1.1")
    axis.enable()
    axis.move_to(700)
    axis.write("profile_velocity", 1234)
    LEAVES[what](session, axis)

def check(session):
    check_start(session)
    axis = session.axis("1.1")
    session.step(10)
    assert image(session)[0] == KEPT[0][0] and axis.read("profile_velocity") != 4321
    axis.enable()
    axis.move_to(300)
    assert axis.status().position == 300
    assert len(session.snapshots()) == 1

def test_before(vdrive_shared_session):
    check_start(vdrive_shared_session)

# What the wire has a part in: sessions and set-points whose end is on its way.
CHOSEN = (("a failure", "a motion", "a waiting set-point", "a stepper") if "VDRIVE_CHOSEN" in os.environ
          else LEAVES)

@pytest.mark.parametrize("what, use", [(what, use) for what in CHOSEN for use in ("leave", "check")])
def test_one_after_the_other(vdrive_shared_bench, what, use):
    BENCHES.append(vdrive_shared_bench)
    session = vdrive_shared_bench.session()
    leave(session, what) if use == "leave" else check(session)

def test_one_bench_was_shared():
    assert len(set(map(id, BENCHES))) == 1
"""


# One test before, one after, and two for each of the 9 LEAVES, or 4 over DDS; one of them fails.
@pytest.mark.parametrize("over, passed", [("local", 19), ("dds", 9)])
def test_what_a_test_leaves_does_not_reach_the_next_one(pytester, monkeypatch, over, passed):
    if over == "dds":
        monkeypatch.setenv("VDRIVE_CHOSEN", "1")
    result = run(pytester, over, LEAVES, passed=passed, failed=1)
    result.stdout.fnmatch_lines(["*FAILED*test_one_after_the_other?a failure-leave?*"])


@OVER
def test_an_axis_that_a_session_of_no_bench_owns_is_free_again(pytester, over):
    run(pytester, over, """
def test_leaves(vdrive_shared_bench):
    bench = vdrive_shared_bench
    place = ({"domain": bench.domain, "find_timeout": 30} if "VDRIVE_DOMAIN" in os.environ
             else {"local": bench._local})
    other = vdrive.Session(**place)
    other.axis("1.2").enable()
    KEPT.extend([bench, other])

def test_after(vdrive_shared_bench, vdrive_shared_session):
    bench, other = KEPT
    KEPT.clear()
    assert bench is vdrive_shared_bench and not other.is_closed
    check_start(vdrive_shared_session)
""", passed=2)


@OVER
def test_a_bench_that_a_test_ends_is_made_again(pytester, over):
    run(pytester, over, """
def test_ends_it(vdrive_shared_bench):
    vdrive_shared_bench.close()

def test_drops_the_snapshot(vdrive_shared_session):
    check_start(vdrive_shared_session)
    vdrive_shared_session.axis("1.1").enable()
    for number in vdrive_shared_session.snapshots():
        vdrive_shared_session.drop_snapshot(number)

def test_after(vdrive_shared_session):
    check_start(vdrive_shared_session)
""", passed=3)


def test_a_project_prepares_the_start(pytester):
    run(pytester, "local", """
@pytest.fixture(scope="session")
def vdrive_shared_start():
    def enable_and_leave_home(session):
        axis = session.axis("1.1")
        axis.enable()
        axis.move_to(500)
    return enable_and_leave_home

@pytest.mark.parametrize("number", range(3))
def test_it_starts_there(vdrive_shared_session, number):
    axis = vdrive_shared_session.axis("1.1")
    assert axis.status().is_enabled and axis.status().position == 500 and axis.status().owner == 0
    axis.move_by(100)
    assert axis.status().position == 600
""", passed=3)


@OVER
def test_a_realtime_bench_returns_too_and_time_goes_on_at_its_rate(pytester, over):
    run(pytester, over, """
pytestmark = pytest.mark.vdrive(clock="realtime")

def test_leaves(vdrive_shared_session):
    axis = vdrive_shared_session.axis("1.1")
    axis.enable()
    axis.start_move(10**6)
    vdrive_shared_session.set_rate(0)

def test_after(vdrive_shared_session):
    assert vdrive_shared_session.find_bench().rate == 1.0
    vdrive_shared_session.wait(0.01)
    status = vdrive_shared_session.axis("1.1").status()
    assert (status.state, status.position, status.owner) == ("Switch on disabled", 0, 0)
""", passed=2)


def test_a_bench_that_a_failed_test_made_next_to_the_shared_one_ends_with_it(pytester):
    run(pytester, "local", """
def test_fails(vdrive_shared_bench):
    beside = vdrive.Bench(number=2, beside=vdrive_shared_bench)
    assert beside is None  # its traceback keeps the bench

def test_after(vdrive_shared_session):
    assert [bench.number for bench in vdrive_shared_session.find_benches()] == [1]
""", passed=1, failed=1)


def test_no_event_of_the_return_is_one_of_the_next_test(pytester):
    run(pytester, "local", """
def test_leaves(vdrive_shared_session):
    vdrive_shared_session.axis("1.1").enable()

def test_after(vdrive_shared_session):
    check_start(vdrive_shared_session)
    begin = vdrive_shared_session.observe().tick
    with vdrive_shared_session.events(history=True) as events:
        vdrive_shared_session.step(10)
        vdrive_shared_session.axis("1.1").enable()
        while (event := events.next(timeout=10)).tick <= begin: pass
    assert event.session == vdrive_shared_session.id, event
""", passed=2)


def test_other_options_have_another_bench(pytester):
    run(pytester, "local", """
SEEN = []

@pytest.mark.parametrize("axes", [pytest.param(n, marks=pytest.mark.vdrive(axes=n)) for n in (1, 2, 1)])
def test_axes(vdrive_shared_bench, vdrive_shared_session, axes):
    assert len(vdrive_shared_session.find_bench().axes) == axes
    SEEN.append((axes, id(vdrive_shared_bench)))

def test_two_were_made():
    assert len(set(SEEN)) == 2 and SEEN[0] == SEEN[2]
""", passed=4)


def test_what_a_snapshot_cannot_bring_back_is_refused(pytester):
    result = run(pytester, "local", """
@pytest.mark.vdrive(clock="freerun")
def test_freerun(vdrive_shared_bench): pass

@pytest.mark.vdrive(state="state")
def test_state(vdrive_shared_bench): pass

@pytest.mark.vdrive(over="dds", arguments=["--state", "state"])
def test_state_of_a_service(vdrive_shared_bench): pass
""", errors=3)
    result.stdout.fnmatch_lines(["*clock = 'freerun': a shared bench returns to a snapshot*",
                                 "*a shared bench has no state directory*"])
