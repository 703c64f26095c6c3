# SPDX-License-Identifier: Apache-2.0
"""Fixtures of pytest: each test that asks for one has a bench of its own.

    def test_it_gets_there(vdrive_session):
        axis = vdrive_session.axis("1.1")
        axis.enable()
        axis.move_to(10000, velocity=20000)
        assert axis.status().position == 10000

    @pytest.mark.vdrive(axes=4)          # arguments of vdrive.Bench
    def test_four(vdrive_session): ...

The bench is in the process of the test. `--vdrive-over=dds` runs the same tests with a service over
DDS; a test that starts programs of its own, which have to meet the bench, asks for it by
`@pytest.mark.vdrive(over="dds")`.
"""
import pytest


def pytest_addoption(parser):
    parser.getgroup("vdrive").addoption(
        "--vdrive-over", choices=("local", "dds"), default="local",
        help="where the benches of the fixtures are, unless their marker says it: in this process "
        "(local, the default), or a service over DDS (dds)")


def pytest_configure(config):
    config.addinivalue_line(
        "markers", "vdrive(axes=None, config=None, clock='lockstep', over='local', ...): "
        "the private bench of this test, with the arguments of vdrive.Bench")


def _options_of(request):
    options = {"over": request.config.getoption("--vdrive-over")}
    for marker in reversed(list(request.node.iter_markers("vdrive"))):  # the closest one last
        options.update(marker.kwargs)
    return options


@pytest.fixture
def vdrive_bench(request, monkeypatch):
    """A private bench, in lock-step. Over DDS VDRIVE_DOMAIN names its domain."""
    import vdrive  # not for tests that have no bench: reading it takes time

    options = _options_of(request)
    with vdrive.Bench(**options) as bench:
        if options["over"] == "dds":
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
