# SPDX-License-Identifier: Apache-2.0
"""The plug-in of pytest, in runs of pytest of their own."""
import os
import pathlib
import select
import signal
import subprocess
import sys
import textwrap

import pytest

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
    # By the process and not by its domain: another test may have that one by now.
    children = (pytester.path / "children").read_text().split()
    assert children
    for child in children:
        command = pathlib.Path("/proc", child, "cmdline")
        assert not (command.exists() and b"vdrived" in command.read_bytes())



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
