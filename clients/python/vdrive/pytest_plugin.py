# SPDX-License-Identifier: Apache-2.0
"""Fixtures of pytest: each test that asks for one has a bench of its own.

    def test_it_gets_there(vdrive_session):
        axis = vdrive_session.axis("1.1")
        axis.enable()
        axis.move_to(10000, velocity=20000)
        assert axis.status().position == 10000

    @pytest.mark.vdrive(axes=4)          # arguments of vdrive.Bench
    def test_four(vdrive_session): ...
"""
import pytest


def pytest_configure(config):
    config.addinivalue_line(
        "markers", "vdrive(axes=None, config=None, clock='lockstep', arguments=(), service=None): "
        "the private bench of this test, as vdrive.Bench starts it")


def _options_of(request):
    marker = request.node.get_closest_marker("vdrive")
    return marker.kwargs if marker else {}


@pytest.fixture
def vdrive_bench(request, monkeypatch):
    """A private bench, in lock-step: a service in a DDS domain of its own, which VDRIVE_DOMAIN names."""
    import vdrive  # not for tests that have no bench: reading it takes time

    with vdrive.Bench(**_options_of(request)) as bench:
        monkeypatch.setenv("VDRIVE_DOMAIN", str(bench.domain))
        yield bench


@pytest.fixture
def bench(vdrive_bench):
    """The same as vdrive_bench."""
    return vdrive_bench


@pytest.fixture
def vdrive_session(vdrive_bench):
    """A session on the private bench of this test."""
    with vdrive_bench.session() as session:
        yield session
