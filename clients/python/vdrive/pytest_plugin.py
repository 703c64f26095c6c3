# SPDX-License-Identifier: Apache-2.0
"""Fixtures of pytest: each test that asks for one has a bench of its own.

    def test_it_gets_there(vdrive_session):
        axis = vdrive_session.axis("1.1")
        axis.enable()
        axis.move_to(10000, velocity=20000)
        assert axis.status().position == 10000

    @pytest.mark.vdrive(axes=4)          # arguments of vdrive.Bench
    def test_four(vdrive_session): ...

    def test_two_benches(vdrive_benches):
        first, second = vdrive_benches(2, axes=1)      # the axes 1.1 and 2.1, in one clock

The bench is in the process of the test. `--vdrive-over=dds` runs the same tests with a service over
DDS; a test that starts programs of its own, which have to meet the bench, asks for it by
`@pytest.mark.vdrive(over="dds")`.
"""
import contextlib

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


def _name_domain(monkeypatch, options, bench):
    """Make VDRIVE_DOMAIN name the domain of a bench over DDS, for programs of the test."""
    if options["over"] == "dds":
        monkeypatch.setenv("VDRIVE_DOMAIN", str(bench.domain))


@pytest.fixture
def vdrive_bench(request, monkeypatch):
    """A private bench, in lock-step. Over DDS VDRIVE_DOMAIN names its domain."""
    import vdrive  # not for tests that have no bench: reading it takes time

    options = _options_of(request)
    with vdrive.Bench(**options) as bench:
        _name_domain(monkeypatch, options, bench)
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


@pytest.fixture
def vdrive_benches(request, monkeypatch):
    """A function that makes private benches which meet each other: `vdrive_benches(2, axes=1)`.

    It returns a list of so many benches, with the numbers from 1 on. Their options are those of the
    marker and of the call. Benches of another call do not meet them. All end with the test.
    """
    import vdrive

    with contextlib.ExitStack() as made:
        def make(count, **options):
            options = {**_options_of(request), **options}
            benches = []
            for number in range(1, count + 1):
                beside = benches[0] if benches else None
                benches.append(made.enter_context(
                    vdrive.Bench(number=number, beside=beside, **options)))
            _name_domain(monkeypatch, options, benches[0])
            return benches

        yield make
