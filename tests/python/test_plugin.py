# SPDX-License-Identifier: Apache-2.0
"""The pytest plug-in, in separate runs of pytest."""
import os
import pathlib
import re
import select
import signal
import subprocess
import sys
import textwrap

import pytest
import vdrive

TEN_LINES = """
    import pytest

    @pytest.mark.parametrize("number", range(8))
    def test_it_gets_there(vdrive_bench, vdrive_session, number):
        axis = vdrive_session.axis("1.1")
        # No other test used it: a shared bench would have moved.
        assert axis.status().position == 0 and len(vdrive_session.find_benches()) == 1
        axis.enable()
        axis.move_to(100 * number)
        assert axis.status().position == 100 * number
"""


def test_the_plug_in_is_found_by_its_entry_point(pytestconfig):
    assert pytestconfig.pluginmanager.has_plugin("vdrive")


@pytest.mark.parametrize("over", ["local", "dds"])
def test_parallel_tests_do_not_disturb_each_other(pytester, over):
    pytester.makepyfile(TEN_LINES)
    result = pytester.runpytest_subprocess("-n", "4", "-q", "-p", "no:cacheprovider",
                                           "--vdrive-over", over, timeout=250)
    result.assert_outcomes(passed=8)


@pytest.mark.dds
def test_a_failing_test_ends_its_bench(pytester):
    pytester.makepyfile("""
        import pathlib
        def test_one(vdrive_bench, vdrive_session):
            children = [path.read_text() for path in pathlib.Path("/proc/self/task").glob("*/children")]
            pathlib.Path("children").write_text(" ".join(children))
            assert False
    """)
    result = pytester.runpytest_subprocess("-q", "--vdrive-over=dds", timeout=100)
    result.assert_outcomes(failed=1)
    # Found by process and not by domain, which another test may already be using.
    children = (pytester.path / "children").read_text().split()
    assert children
    for child in children:
        command = pathlib.Path("/proc", child, "cmdline")
        assert not (command.exists() and b"vdrived" in command.read_bytes())



FAILS = """
    import pytest

    def test_that_fails(vdrive_session):
        axis = vdrive_session.axis("1.1")
        axis.enable()
        axis.disturb("over_current")
        for _ in range(60):
            tick = vdrive_session.step(1)
        pytest.fail(f"at tick {tick}")

    def test_that_passes(vdrive_session):
        vdrive_session.step(3)

    @pytest.mark.xfail
    def test_that_may_fail(vdrive_session):
        vdrive_session.step(3)
        assert False
"""


def test_a_failed_test_has_the_last_ticks_and_events_of_its_bench(pytester):
    test = pytester.makepyfile(FAILS)
    result = pytester.runpytest_subprocess("-q", "-p", "no:cacheprovider", "--vdrive-record=50",
                                           "--junit-xml=reports/result.xml", timeout=100)
    result.assert_outcomes(failed=1, passed=1, xfailed=1)
    stem = pytester.path / "reports/vdrive-failures" / f"{test.name}_test_that_fails"
    assert sorted(file.name for file in stem.parent.iterdir()) == [
        f"{stem.name}.events.txt", f"{stem.name}.mcap"]
    result.stdout.fnmatch_lines(["*-- vdrive bench --*", f"last ticks, * to *: {stem}.mcap",
                                 f"last events, * of them: {stem}.events.txt"])
    last = int(re.search(r"at tick (\d+)", result.stdout.str())[1])
    recording = vdrive.load(f"{stem}.mcap")
    assert recording.axes == ["1.1", "1.2"] and 0 < len(recording) <= 50
    assert recording.ticks[-1] == last
    # 603Fh of the over-current fault.
    assert recording.axis("1.1")["error_code"][-1] == 0x2310
    lines = pathlib.Path(f"{stem}.events.txt").read_text().splitlines()
    assert any("  1.1  fault  " in line for line in lines) and len(lines) <= 1024


MASTERS = """
    import pytest

    def master(session, waits):
        axis = session.axis("1.1")
        axis.write(0x6060, 1)
        axis.enable()
        axis.write(0x607A, 100000)
        axis.write(0x6040, 0x1F)
        session.step(3)
        if waits:
            axis.write(0x6040, 0x0F)
            session.step(3)
        axis.write(0x607A, 200000)
        axis.write(0x6040, 0x1F)     # without a fall of bit 4 no edge
        session.step(3)
        axis.write(0x6040, 0x0F)
        session.step(3)

    def test_right(vdrive_session, vdrive_judge):
        axis = vdrive_session.axis("1.1")
        axis.enable()
        axis.move_to(1000)
        axis.disable()

    def test_wrong(vdrive_judge, vdrive_session):
        master(vdrive_session, False)

    @pytest.mark.vdrive_judge(off={"handshake-2": "that is what this test does"})
    def test_excepted(vdrive_session, vdrive_judge):
        master(vdrive_session, False)

    @pytest.mark.vdrive_judge(off={"handshake-2": "nobody does it"})
    def test_unused(vdrive_session, vdrive_judge):
        master(vdrive_session, True)

    @pytest.mark.vdrive_judge(off={"handshake-99": "no such rule"})
    def test_no_rule(vdrive_session, vdrive_judge):
        pass

    def test_unjudged(vdrive_session):
        master(vdrive_session, False)
"""


@pytest.mark.parametrize("over", ["local", "dds"])
def test_a_test_that_asks_for_the_judge_fails_by_what_its_master_did_wrong(pytester, over):
    pytester.makepyfile(MASTERS)
    result = pytester.runpytest_subprocess("-q", "-p", "no:cacheprovider", f"--vdrive-over={over}",
                                           timeout=200)
    result.assert_outcomes(passed=4, failed=2, warnings=1)
    result.stdout.fnmatch_lines(["*error handshake-2 on axis 1.1: *", "*'handshake-99' is not a rule of the judge*",
                                 "*off has rules that were not broken: handshake-2*"])
    result.stdout.no_fnmatch_line("*test_right*")


def test_nothing_is_recorded_where_it_is_turned_off(pytester):
    pytester.makepyfile(FAILS)
    result = pytester.runpytest_subprocess("-q", "-p", "no:cacheprovider", "--vdrive-record=0", timeout=100)
    result.assert_outcomes(failed=1, passed=1, xfailed=1)
    assert not (pytester.path / "vdrive-failures").exists()
    assert "vdrive bench" not in result.stdout.str()
    result = pytester.runpytest_subprocess("--vdrive-record=-1", timeout=100)
    result.stderr.fnmatch_lines(["*--vdrive-record: '-1': must be a whole number of ticks, 0 = none"])


def test_a_record_that_cannot_be_written_fails_no_test_and_says_why(pytester):
    pytester.makepyfile(FAILS)
    (pytester.path / "full").write_text("a file")
    result = pytester.runpytest_subprocess("-q", "-p", "no:cacheprovider", "--vdrive-record-dir=full", timeout=100)
    result.assert_outcomes(failed=1, passed=1, xfailed=1)
    result.stdout.fnmatch_lines(["the record of the bench cannot be written: *File exists*"])


def test_of_many_failed_tests_the_first_20_have_files(pytester):
    pytester.makepyfile("""
        import pytest

        @pytest.mark.parametrize("name", [str(n) * 80 for n in range(100, 123)])
        def test_that_fails(vdrive_bench, name):
            assert False
    """)
    result = pytester.runpytest_subprocess("-q", "-p", "no:cacheprovider", "--vdrive-record-dir=kept", timeout=200)
    result.assert_outcomes(failed=23)
    files = [file.name for file in (pytester.path / "kept").iterdir()]
    assert len(files) == 2 * 20 and max(map(len, files)) < 255
    assert result.stdout.str().count("20 tests have files already") == 3


@pytest.mark.dds
def test_a_killed_pytest_leaves_no_service_behind(tmp_path):
    (tmp_path / "test_waits.py").write_text(textwrap.dedent("""
        import pathlib, threading
        def test_waits(vdrive_bench):
            children = pathlib.Path(f"/proc/self/task")
            services = [child for task in children.iterdir()
                        for child in (task / "children").read_text().split()]
            print("SERVICE", *services, flush=True)
            threading.Event().wait()
    """))
    run = subprocess.Popen([sys.executable, "-m", "pytest", "-s", "-q", "-p", "no:cacheprovider",
                            "--vdrive-over=dds", str(tmp_path)], stdout=subprocess.PIPE, text=True, cwd=tmp_path)
    line = next(line for line in run.stdout if "SERVICE" in line)
    services = line.split("SERVICE")[1].split()
    assert len(services) == 1
    handle = os.pidfd_open(int(services[0]))
    run.send_signal(signal.SIGKILL)
    run.communicate()
    ended, _, _ = select.select([handle], [], [], 60)
    os.close(handle)
    assert ended


@pytest.mark.vdrive(axes=1, over="dds")
def test_the_short_name_of_the_fixture_is_the_same_bench(bench, vdrive_bench):
    assert bench is vdrive_bench
    assert os.environ["VDRIVE_DOMAIN"] == str(bench.domain)
