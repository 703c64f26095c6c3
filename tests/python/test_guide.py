# SPDX-License-Identifier: Apache-2.0
"""The guide shows programs that run."""
import pathlib
import re

import pytest

GUIDE = pathlib.Path(__file__).resolve().parents[2] / "docs/guides/python.md"
BLOCKS = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.DOTALL | re.MULTILINE)
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


def test_the_test_of_the_guide_passes(pytester):
    assert len(TESTS) == 1
    pytester.makepyfile(TESTS[0])
    pytester.runpytest_subprocess("-q", timeout=200).assert_outcomes(passed=1)
