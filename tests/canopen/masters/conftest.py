# SPDX-License-Identifier: Apache-2.0
"""A bus with one axis, in both clocks, a master on it, and the time of this master."""
import pytest
import vdrive.canopen
from can_client import CanClient, RealTime, Time

PERIOD = 0.01  # [s] of SYNC: that of the masters' examples


@pytest.fixture(params=["realtime", "lockstep"])
def bus(request):
    options = {"sync_steps": PERIOD} if request.param == "lockstep" else {}
    with vdrive.canopen.Bus(axes=1, clock=request.param, **options) as bus:
        yield bus


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
