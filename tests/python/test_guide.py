# SPDX-License-Identifier: Apache-2.0
"""The programs in the guides run."""
import pathlib
import re

import pytest
import vdrive

GUIDE = pathlib.Path(__file__).resolve().parents[2] / "docs/guides/python.md"
BENCHES = GUIDE.with_name("bench-in-process.md")


def blocks(guide):
    return re.findall(r"^```python\n(.*?)^```", guide.read_text(), re.DOTALL | re.MULTILINE)


BLOCKS = blocks(GUIDE)
TESTS = [block for block in BLOCKS if "def test_" in block]


@pytest.mark.vdrive(over="dds")
def test_the_programs_of_the_guide_run_one_after_the_other(vdrive_bench, capsys):
    names = {}
    programs = [block for block in BLOCKS if block not in TESTS]
    assert len(programs) >= 5
    for block in programs:
        exec(compile(block, str(GUIDE), "exec"), names)  # as a reader would type it
    names["session"].close()
    printed = capsys.readouterr().out
    assert printed.startswith("10000 Operation enabled") and "0x8611" in printed


@pytest.mark.parametrize("place, passed", [(0, 1), (1, 2)])
def test_the_tests_of_the_guide_pass(pytester, place, passed):
    assert len(TESTS) == 3
    pytester.makepyfile(TESTS[place])
    pytester.runpytest_subprocess("-q", timeout=200).assert_outcomes(passed=passed)


def test_the_test_of_the_guide_with_a_can_bus_passes(pytester):
    pytest.importorskip("can", reason="python3-can is not installed")
    assert "vdrive_can" in TESTS[2]
    pytester.makepyfile(TESTS[2])
    pytester.runpytest_subprocess("-q", timeout=200).assert_outcomes(passed=1)


def test_the_programs_of_the_guide_of_benches_run(capsys):
    programs = blocks(BENCHES)
    assert len(programs) == 2
    names = {"vdrive": vdrive}
    for block in programs:
        exec(compile(block, str(BENCHES), "exec"), names)
    assert capsys.readouterr().out == "10000\n"


def test_the_program_of_the_guide_to_the_drive_alone_runs():
    program, = blocks(GUIDE.with_name("embedding.md"))
    exec(compile(program, "embedding.md", "exec"), {})
