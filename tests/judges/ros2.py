#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""An independent judge of vdrive-ros2.

  ros2.py VDRIVED VDRIVE ROS2 WORK

Foxglove's ROS 2 stack (npm, versions fixed by the lock file; no Fast DDS, no Cyclone DDS) finds
/joint_states, decodes every field of 1,000 messages while an axis moves, and sees the hash of the
type. WORK is a directory for the npm packages.
Exit code 0: all agree; 77: the judge is missing (no node, no registry).
"""
import json
import math
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
DOMAIN = "45"
MESSAGES = 1000
SKIPPED = 77
HASH = "typehash=RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e;"
TARGET = 2048  # [UU] half a turn


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(SKIPPED)


def fail(text):
    print(f"ros2.py: {text}", file=sys.stderr)
    sys.exit(1)


def expect(value, wanted, what):
    if value != wanted:
        fail(f"{what} is {value!r}, not {wanted!r}")


def install(work):
    """Installs the packages of the lock file below `work`, unless they are installed."""
    if not shutil.which("npm") or not shutil.which("node"):
        skip("node or npm is not installed")
    work.mkdir(parents=True, exist_ok=True)
    lock = work / "package-lock.json"
    is_there = (work / "node_modules" / "@foxglove" / "ros2").exists() and (
        lock.exists() and lock.read_bytes() == (HERE / "ros2" / lock.name).read_bytes())
    for name in ("package.json", "package-lock.json", "judge.mjs"):
        shutil.copy(HERE / "ros2" / name, work / name)
    if is_there:
        return
    done = subprocess.run(["npm", "ci", "--no-audit", "--no-fund", "--ignore-scripts"], cwd=work,
                          capture_output=True, text=True, timeout=300)
    if done.returncode != 0:
        skip(f"npm ci failed: {done.stderr.strip()[-300:]}")


def check(result):
    expect(result["topic"], "/joint_states", "the topic")
    expect(result["dataType"], "sensor_msgs/msg/JointState", "the type")
    expect(result["type"], "sensor_msgs::msg::dds_::JointState_", "the name on DDS")
    expect(result["userData"], HASH, "USER_DATA")
    messages = result["messages"]
    expect(len(messages), MESSAGES, "the number of messages")
    last = -1.0
    for message in messages:
        expect(message["name"], ["x", "y"], "name")
        expect(message["frame_id"], "", "frame_id")
        for member in ("position", "velocity", "effort"):
            if len(message[member]) != 2 or not all(map(math.isfinite, message[member])):
                fail(f"{member} is {message[member]}")
        time = message["sec"] + message["nanosec"] * 1e-9
        if time <= last:
            fail(f"the time {time} does not follow {last}")
        last = time
    expect(messages[0]["position"], [0.0, 0.0], "the first position")
    turn = TARGET / 4096 * 2 * math.pi
    if abs(messages[-1]["position"][0] - turn) > 0.01 or messages[-1]["position"][1] != 0.0:
        fail(f"the last position is {messages[-1]['position']}")
    if max(message["velocity"][0] for message in messages) < 1.0:
        fail("no message shows the motion")


def main():
    vdrived, vdrive, ros2, work = sys.argv[1:]
    work = pathlib.Path(work) / "ros2"
    install(work)
    programs = []

    def start(*command, **options):
        programs.append(subprocess.Popen(command, text=True, **options))
        return programs[-1]

    try:
        start(vdrived, "--domain", DOMAIN, "--log-level", "error")
        subprocess.run([vdrive, "--domain", DOMAIN, "--timeout", "20", "list"], check=True,
                       capture_output=True, timeout=60)
        start(ros2, "--domain", DOMAIN, stdout=subprocess.DEVNULL)
        judge = start("node", work / "judge.mjs", DOMAIN, str(MESSAGES), stdout=subprocess.PIPE)
        # The judge is receiving once its output shows the first message.
        if judge.stdout.readline() != "first\n":
            fail("no message came")
        for words in (["enable", "1.1"], ["move", "1.1", str(TARGET)]):
            subprocess.run([vdrive, "--domain", DOMAIN, *words], check=True, capture_output=True,
                           timeout=60)
        output, _ = judge.communicate(timeout=120)
        if judge.returncode != 0:
            fail("Foxglove's stack did not get its messages")
        check(json.loads(output))
        print(f"{MESSAGES} messages agree")
    finally:
        for process in reversed(programs):
            process.terminate()
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()


if __name__ == "__main__":
    main()
