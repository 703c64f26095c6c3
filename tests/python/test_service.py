# SPDX-License-Identifier: Apache-2.0
"""Features of benches over DDS only: a domain, arguments, other programs, an announced end."""
import subprocess
import sys
import time

import pytest
import vdrive

pytestmark = pytest.mark.vdrive(over="dds")


def test_the_bench_of_the_fixture_is_found_and_described(vdrive_bench, vdrive_session):
    bench = vdrive_session.find_bench()
    assert bench.clock_mode == "lockstep" and bench.period == 0.001
    assert [axis.id for axis in bench.axes] == ["1.1", "1.2"]
    assert bench.service_version == vdrive.__version__
    assert bench.figures["wire_starts"] == bench.wire_starts
    assert bench.figures["longest_silence_us"] == round(bench.longest_silence * 1e6)
    assert all(type(value) is int for value in bench.figures.values())
    with vdrive.Session() as other:  # VDRIVE_DOMAIN is the domain of the bench
        assert [found.number for found in other.find_benches()] == [1]


@pytest.mark.vdrive(axes=3, arguments=["--period", "2000"])
def test_the_marker_chooses_the_bench(vdrive_session):
    bench = vdrive_session.find_bench()
    assert len(bench.axes) == 3 and bench.period == 0.002


def test_a_service_that_ends_is_lost(vdrive_bench):
    session = vdrive.Session(domain=vdrive_bench.domain, find_timeout=5)
    axis = session.axis("1.1")
    vdrive_bench.close()
    with pytest.raises(vdrive.Error) as lost:
        # The announcement of the end may still be in transit.
        end = time.monotonic() + 30
        while time.monotonic() < end:
            axis.status()
    assert isinstance(lost.value, (vdrive.Lost, vdrive.NotFound))
    with pytest.raises(vdrive.Failed, match="ended"):
        print(vdrive_bench.domain)


def test_a_program_with_observers_ends(vdrive_bench):
    program = """
import vdrive
session = vdrive.Session(find_timeout=20)
session.on_event(lambda event: None, history=True)
session.on_status(lambda sample: None, period=0.001)
session.step(20)
"""
    assert subprocess.run([sys.executable, "-c", program], timeout=60).returncode == 0


# find_timeout is 2 s; on a slow machine the search may take up to three times as long.
def test_a_wrong_number_of_a_bench_costs_the_time_of_every_session(vdrive_session):
    assert vdrive_session.find_bench().number == 1
    begin = time.monotonic()
    with pytest.raises(vdrive.NotFound, match="no bench 9 on domain"):
        vdrive_session.axis("9.1")
    assert time.monotonic() - begin < 20


def test_a_session_for_a_bench_that_is_not_there_names_those_that_are(vdrive_bench, vdrive_session):
    assert vdrive_session.find_bench().number == 1
    with vdrive_bench.session(bench=9) as session:
        begin = time.monotonic()
        with pytest.raises(vdrive.NotFound, match="^no bench 9 on domain .*, found bench 1 "):
            session.find_bench()
        assert time.monotonic() - begin < 20
