# SPDX-License-Identifier: Apache-2.0
"""A bus with one axis, with either clock; a master on it, its clock, and its judge."""
import json
import os
import subprocess

import pytest
import vdrive.canopen
from can_client import CanClient, RealTime, Time

PERIOD = 0.01  # [s] of SYNC, as in the examples of the masters


@pytest.fixture(params=["realtime", "lockstep"])
def bus(request, tmp_path):
    options = {"sync_steps": PERIOD} if request.param == "lockstep" else {}
    log = tmp_path / "bus.candump"
    with vdrive.canopen.Bus(axes=1, clock=request.param, arguments=["--log", log], **options) as bus:
        yield bus
    # In real time, a master in Python is as late as the machine is busy, which is no mistake of the
    # master.
    if request.param == "lockstep":
        judge(request.module, log)


def judge(module, log):
    """Check that the judge finds nothing in the log of the bus but the FINDINGS of the module, which
    explain each rule.

    A test also commands things that its master does not, such as a fault.
    docs/guides/judging.md lists the findings that are due to the masters."""
    tool = os.environ.get("VDRIVE_TOOL")
    if tool is None or not os.path.exists(tool):  # in builds with a sanitizer
        return
    done = subprocess.run([tool, "judge", log, "--json", "--fail-on", "never"], capture_output=True, text=True,
                          timeout=60)
    assert done.returncode == 0, done.stderr
    findings = [json.loads(line) for line in done.stdout.splitlines()][:-1]
    unknown = [f"{each['severity']} {each['rule']}, {each['count']} times, line {each['first']['line']}: {each['happened']}"
               for each in findings if each["rule"] not in module.FINDINGS]
    assert not unknown, f"vdrive judge {log}:\n" + "\n".join(unknown)


@pytest.fixture
def client(bus):
    with CanClient(bus.host, bus.port) as client:
        yield client


@pytest.fixture
def clock(request, bus, client):
    kind = RealTime if request.node.callspec.params["bus"] == "realtime" else Time
    return kind(client, PERIOD, bus.nodes[0])


@pytest.fixture
def node(bus):
    return bus.nodes[0]
