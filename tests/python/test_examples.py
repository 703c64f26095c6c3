# SPDX-License-Identifier: Apache-2.0
"""The examples run, and the picture in the documents is the one that they draw."""
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "clients/python/examples"


def run(name, *arguments, cwd=None):
    done = subprocess.run([sys.executable, str(EXAMPLES / name), *arguments], capture_output=True,
                          text=True, cwd=cwd)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_arm_keeps_its_energy_balance_and_moves_the_same_way_twice():
    lines = run("two_joint_arm.py").splitlines()
    assert lines[-1].split()[-1] == lines[-2].split()[-1]


@pytest.mark.parametrize("over", ["local", "dds"])
def test_two_benches_in_one_clock_move_together_and_stop_together(over):
    # A tick is 1 ms. Equal distances with equal limits have equal demands at every tick.
    assert run("two_benches.py", over).splitlines() == [
        "ticks of the benches after 10 ms: [10, 10]",
        "positions: [8192.0, 8192.0] widest gap of the demands: 0.0",
        "stopped: axis 2.1 shows error 0x2310 continuous over-current, 0x21F Fault reaction active: "
        "voltage enabled, remote; waited for target reached, bit 10",
        "state of the group: error_stop"]


@pytest.mark.parametrize("over", ["local", "dds"])
def test_each_set_point_is_the_demand_of_its_tick(over):
    # From 0 by 4096 UU.
    assert run("set_points.py", over) == "2000 set-points, 0 not followed, at 4096\n"


def test_the_energy_of_the_arm_agrees_with_its_torques():
    # Along any smooth motion, the power of the torques is the time derivative of the energy, here a
    # difference quotient of the closed form.
    sys.path.insert(0, str(EXAMPLES))
    import numpy
    import two_joint_arm

    arm = two_joint_arm.Arm()

    def angles(t):
        return numpy.array([numpy.sin(t), 0.5 * numpy.cos(2 * t)])

    def speeds(t):
        return numpy.array([numpy.cos(t), -numpy.sin(2 * t)])

    def accelerations(t):
        return numpy.array([-numpy.sin(t), -2 * numpy.cos(2 * t)])

    for t in (0.1, 0.7, 1.9):
        power = arm.torque(angles(t), speeds(t), accelerations(t)) @ speeds(t)
        step = 1e-5
        rate = (arm.energy(angles(t + step), speeds(t + step))
                - arm.energy(angles(t - step), speeds(t - step))) / (2 * step)
        assert power == pytest.approx(rate, rel=1e-6)


def test_the_plot_of_the_documents_is_the_output_of_the_script(tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    run("plot_a_move.py", str(tmp_path / "move.svg"), cwd=tmp_path)
    drawn = (tmp_path / "move.svg").read_text()
    shown = (ROOT / "docs/images/python_move.svg").read_text()
    if f"Matplotlib v{matplotlib.__version__}," not in shown:
        pytest.skip("the picture was drawn by another version of matplotlib")
    assert drawn == shown, "run plot_a_move.py docs/images/python_move.svg"
