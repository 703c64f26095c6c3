# SPDX-License-Identifier: Apache-2.0
"""The types of the module, as `mypy --strict` sees them in the tests of a user."""
import os
import pathlib
import subprocess
import sys
import textwrap

import pytest
import vdrive

pytest.importorskip("mypy")
PACKAGES = pathlib.Path(vdrive.__file__).parent.parent


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """A function that type-checks a user's program together with the module, and returns the
    errors."""
    directory = tmp_path_factory.mktemp("typed")
    # For a package on PYTHONPATH, as for an installed one, mypy suppresses the errors.
    environment = {**os.environ, "MYPYPATH": str(PACKAGES)}
    environment.pop("PYTHONPATH", None)

    def check(text):
        program = directory / "test_of_a_user.py"
        program.write_text(textwrap.dedent(text))
        done = subprocess.run(
            [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--cache-dir",
             str(directory / "cache"), str(program)], env=environment, cwd=directory,
            capture_output=True, text=True, timeout=200, check=False)
        assert done.stderr == ""
        assert (done.returncode == 0) == (done.stdout == "")
        return done.stdout.splitlines()

    return check


def test_a_test_suite_of_a_user_has_no_error(checked):
    assert checked("""\
        import asyncio
        from typing import Callable

        import numpy
        import pytest
        import vdrive
        import vdrive.canopen


        @pytest.mark.vdrive(axes=4)
        def test_it_gets_there(vdrive_session: vdrive.Session) -> None:
            axis = vdrive_session.axis("1.1")
            axis.enable()
            axis.move_to(numpy.int64(1000), velocity=2e4)
            axis.move_to(90, unit="deg")
            status = axis.status()
            assert abs(status.position - 1024) <= 1
            assert status.power_state is vdrive.PowerState.OPERATION_ENABLED
            assert status.shows(vdrive.Statusword.TARGET_REACHED)
            assert status.op_mode_actual == vdrive.OperatingMode.PROFILE_POSITION


        @pytest.mark.vdrive_can(axes=3, sync_steps=0.001)
        def test_nodes(vdrive_can: vdrive.canopen.Bus) -> None:
            master = vdrive_can.can()
            host, port = vdrive_can.gateway
            assert host == vdrive_can.host and port != vdrive_can.port
            assert sum(vdrive_can.nodes) == 6 and master.recv(timeout=0) is None


        def test_two(vdrive_benches: Callable[..., list[vdrive.Bench]]) -> None:
            first, second = vdrive_benches(2, axes=1)
            with first.session() as session:
                recording = session.record("1.1", ticks=100)
                peak: float = recording["velocity"].max()
                assert peak <= recording.time[-1] + recording.missed


        async def move(axis: vdrive.Axis) -> vdrive.Status:
            await axis.start_move(100)
            await axis.start_move(0).wait_async(timeout=5.0)
            return await axis.wait_until_async(lambda status: status.position == 0)

        async def follow(session: vdrive.Session) -> int:
            async for observation in session.follow_async():
                return observation.tick
            return 0


        def main() -> None:
            with vdrive.Bench(axes=2, clock="realtime") as bench, bench.session() as session:
                seen: list[vdrive.Event] = []
                observer = session.on_event(seen.append, history=True)
                session.on_status(lambda observation: print(observation.tick), period=0.1)
                print(asyncio.run(follow(session)), seen, observer.error)
                try:
                    session.axis("1.3")
                except vdrive.NotFound as error:
                    print(error.code, vdrive.Reason(error.code).name)
                with session.watch_services(lambda change: print(change.news, change.silence)):
                    follower = session.follow(pace="observe")
                    late: float = follower.lateness.longest
                    session.record(ticks=10).save("run.mcap")
                    print(late)
                session.abandon()
            print(vdrive.load("run.csv", period=0.001).axis("1.1")["tick"])
            with vdrive.canopen.Bus(clock="lockstep", sync_steps=0.001) as bus:
                print(bus.exit_code, bus.errors)
            frames: int = bus.counters["frames"]
            print(frames)
        """) == []


@pytest.mark.parametrize("wrong, says", [
    ('axis.move_to("1000")', 'Argument 1 to "move_to" of "Axis" has incompatible type "str"'),
    ('bench.session().axis(1)', 'Argument 1 to "axis" of "Session" has incompatible type "int"'),
    ('vdrive.Bench(clock="lockstp")', 'Argument "clock" to "Bench" has incompatible type'),
    ("vdrive.Bench(preset=7)", 'Argument "preset" to "Bench" has incompatible type "int"'),
    ('vdrive.canopen.Bus(clock="freerun")', 'Argument "clock" to "Bus" has incompatible type'),
    ('bench.session(find_timout=1.0)', 'Unexpected keyword argument "find_timout" for "session" of "Bench"'),
    ('bench.session(silence="1")', 'Argument "silence" to "session" of "Bench" has incompatible type "str"'),
    ('vdrive.load("a.csv")["position"].foo()', 'has no attribute "foo"'),
    ("vdrive.PowerState.FALUT", 'has no attribute "FALUT"'),
    ("vdrive.PowerStates", 'Module has no attribute "PowerStates"'),
    ("axis.status().postion", '"Status" has no attribute "postion"'),
])
def test_a_mistake_of_a_user_is_found(checked, wrong, says):
    errors = checked(f"""\
        import vdrive

        with vdrive.Bench() as bench, bench.session() as session:
            axis = session.axis("1.1")
            {wrong}
        """)
    assert len(errors) >= 1 and errors[0].startswith("test_of_a_user.py:5: error: ")
    assert says in errors[0]
