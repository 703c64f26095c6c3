# SPDX-License-Identifier: Apache-2.0
"""Fixtures for pytest: each test that asks for one gets its own bench.

    def test_it_gets_there(vdrive_session):
        axis = vdrive_session.axis("1.1")
        axis.enable()
        axis.move_to(10000, velocity=20000)
        assert axis.status().position == 10000

    @pytest.mark.vdrive(axes=4)          # arguments of vdrive.Bench
    def test_four(vdrive_session): ...

    def test_two_benches(vdrive_benches):
        first, second = vdrive_benches(2, axes=1)      # the axes 1.1 and 2.1, on one clock

    def test_it_is_at_home(vdrive_shared_session): ... # one bench for many tests

    @pytest.mark.vdrive_judge(off={"motion-1": "this test is about the limits"}, fail_on="warning")
    def test_like_a_master(vdrive_session, vdrive_judge): ...     # a finding of the judge fails it

    @pytest.mark.vdrive_can(axes=3)      # arguments of vdrive.canopen.Bus
    def test_a_master(vdrive_can): ...   # the axes are nodes of a CAN bus

When a test with `vdrive_bench` fails, the last ticks and events of its bench are saved in files next to
the report, which names them; `--vdrive-record=0` turns that off.

The bench is in the process of the test. `--vdrive-over=dds` runs the same tests with a service over
DDS; a test that starts other programs, which must find the bench, uses `@pytest.mark.vdrive(over="dds")`.
"""
from __future__ import annotations

import contextlib
import os
import re
import time
import zlib

import pytest

TYPE_CHECKING = False  # as typing.TYPE_CHECKING, without the time to import typing
if TYPE_CHECKING:
    from typing import Any, Callable, Generator, Iterator

    from numpy.typing import NDArray

    import vdrive
    import vdrive.canopen

    Options = dict[str, Any]
    Start = Callable[[vdrive.Session], object]


# Statuses of axes to keep, some 60 MB: with many axes, these are fewer ticks.
_MOST_STATUSES = 400_000
_MOST_EVENTS = 1024  # as many as a bench keeps
_MOST_FAILURES = 20  # failed tests of one process that leave files
_USUAL_TICKS = 1000
_MOST_STORIES = 3
_LONGEST_NAME = 100


def _ticks(text: str) -> int:
    if not text.isdecimal():
        import argparse

        raise argparse.ArgumentTypeError(f"{text!r}: must be a whole number of ticks, 0 = none")
    return int(text)


class _Recorder:
    """Keeps the last ticks and events of a bench, in case the test fails. It never fails itself."""

    def __init__(self, bench: vdrive.Bench, ticks: int) -> None:
        self._session: vdrive.Session | None = None
        self._problem: Exception | None = None
        try:
            self._session = bench.session()
            self._axes = self._session.axes()
            self._capacity = max(1, min(ticks, _MOST_STATUSES // len(self._axes)))
            self._stream = self._session.stream(self._axes, capacity=self._capacity)
            self._events = self._session.events(history=True, capacity=_MOST_EVENTS)
            self._period = self._session.find_bench(self._axes[0].bench).period
            self._earlier = max((each.number for each in self._session.faults()), default=0)
        except Exception as error:
            self._problem = error

    def close(self) -> None:
        if self._session is None:
            return
        with contextlib.suppress(Exception):
            self._session.close()

    def save(self, stem: str) -> str:
        """Write the files `stem`.mcap and `stem`.events.txt; return the text for the report."""
        if self._problem is not None:
            return f"the bench was not recorded: {self._problem}"
        try:
            os.makedirs(os.path.dirname(stem), exist_ok=True)
            return "\n".join([self._save_ticks(f"{stem}.mcap"),
                              self._save_events(f"{stem}.events.txt"), *self._stories()])
        except Exception as error:
            return f"the record of the bench cannot be written: {error}"

    def _stories(self) -> list[str]:
        """Return the explanations of the faults of the bench, newest first."""
        stories: list[str] = []
        with contextlib.suppress(Exception):  # the test may have ended the bench
            assert self._session is not None
            faults = [each for each in self._session.faults() if each.number > self._earlier]
            for fault in reversed(faults[-_MOST_STORIES:]):
                stories += map(str, self._session.fault(fault.number).stories)
        return stories

    def _save_ticks(self, path: str) -> str:
        import vdrive

        frames = self._frames()
        if frames is None:
            return "no tick of the bench was received"
        vdrive.Recording([axis.id for axis in self._axes], [axis.name for axis in self._axes],
                         frames, period=self._period).save(path)
        ticks = frames["tick"][:, 0]
        return f"last ticks, {ticks[0]} to {ticks[-1]}, for vdrive.load and vdrive convert: {path}"

    def _frames(self) -> NDArray[Any] | None:
        """Return the newest samples up to the present state."""
        import numpy

        present: NDArray[Any] | None = None
        with contextlib.suppress(Exception):  # the test may have ended the bench
            assert self._session is not None
            present = self._session.observe(self._axes).array()[numpy.newaxis, :]
        parts: list[NDArray[Any]] = []
        end = time.monotonic() + 1.0
        # Publications of the bench reach the stream slightly later.
        while time.monotonic() < end:
            try:
                part = self._stream.take(timeout=0.1)
            except Exception:  # the stream has ended, perhaps with the bench
                break
            parts += [part] if len(part) else []
            if not len(part) or present is None or part["tick"][-1, 0] >= present["tick"][0, 0]:
                break
        newest = parts[-1]["tick"][-1, 0] if parts else -1
        if present is not None and present["tick"][0, 0] > newest:
            parts.append(present)
        return numpy.concatenate(parts)[-self._capacity:] if parts else None

    def _save_events(self, path: str) -> str:
        lines: list[str] = []
        with contextlib.suppress(Exception):  # the test may have ended the bench
            while len(lines) < _MOST_EVENTS:
                event = self._events.next(timeout=0.05)
                if event is None:
                    break
                who = f"{event.bench}.{event.axis}" if event.axis else f"bench {event.bench}"
                lines.append(f"{event.tick}  {who}  {event.kind}  {event.text}\n")
        with open(path, "w", encoding="utf-8") as file:
            file.writelines(lines)
        return f"last events, {len(lines)} of them: {path}"


_RECORDER = pytest.StashKey[_Recorder]()
_FAILURES = pytest.StashKey[int]()


def _record_directory(config: pytest.Config) -> str:
    chosen = config.getoption("--vdrive-record-dir")
    if chosen:
        return os.path.abspath(str(chosen))
    junit = config.getoption("xmlpath", None)
    beside = os.path.dirname(os.path.abspath(junit)) if junit else str(config.invocation_params.dir)
    return os.path.join(beside, "vdrive-failures")


def _file_name(test: str) -> str:
    """Return the name of a test as a file name of limited length."""
    name = re.sub(r"[^\w.-]+", "_", test, flags=re.ASCII)
    is_the_same = name == test.replace("::", "_").replace("/", "_") and len(name) <= _LONGEST_NAME
    return name if is_the_same else (
        f"{name[-_LONGEST_NAME:]}.{zlib.crc32(test.encode()):08x}")


def _complete_report(item: pytest.Item) -> Generator[None, Any, None]:
    """Fail a test because of findings of the judge, or save the last ticks and events of a failed test."""
    outcome = yield
    report = outcome.get_result()
    judge = getattr(item, "funcargs", {}).get("vdrive_judge")
    if isinstance(judge, _Judge) and report.when == "call" and report.passed:
        failure, unused = judge.failure()
        if unused:
            item.warn(pytest.PytestWarning(
                f"vdrive_judge: off has rules that were not broken: {', '.join(unused)}"))
        if failure:
            report.outcome = "failed"
            report.longrepr = failure
        return
    recorder = item.stash.get(_RECORDER, None)
    if recorder is None or not report.failed or report.when == "teardown":
        return
    failures = item.config.stash.get(_FAILURES, 0) + 1
    item.config.stash[_FAILURES] = failures
    text = f"{_MOST_FAILURES} tests have files already: those of this test are left out"
    if failures <= _MOST_FAILURES:
        directory = _record_directory(item.config)
        text = recorder.save(os.path.join(directory, _file_name(item.nodeid)))
    report.sections.append(("vdrive bench", text))


# Not used as a decorator, because it has no types.
pytest_runtest_makereport = pytest.hookimpl(hookwrapper=True)(_complete_report)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.getgroup("vdrive").addoption(
        "--vdrive-over", choices=("local", "dds"), default="local",
        help="where the benches of the fixtures are, unless their marker says it: in this process "
        "(local, the default), or a service over DDS (dds)")
    parser.getgroup("vdrive").addoption(
        "--vdrive-record", type=_ticks, metavar="TICKS",
        help="how many of the last ticks of vdrive_bench are kept for a test that fails; 0 = none, no "
        f"events either; default: {_USUAL_TICKS} of a bench in this process, 0 of one over DDS")
    parser.getgroup("vdrive").addoption(
        "--vdrive-record-dir", metavar="DIR",
        help="directory of these files; default: vdrive-failures next to the file of --junit-xml, else in "
        "the current directory")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line(
        "markers", "vdrive(axes=None, preset=None, config=None, clock='lockstep', over='local', ...): "
        "the private bench of this test, with the arguments of vdrive.Bench")
    config.addinivalue_line(
        "markers", "vdrive_judge(off={}, fail_on='error'): exceptions of the judge, each with its "
        "reason, and the lowest severity that fails the test")
    config.addinivalue_line(
        "markers", "vdrive_can(axes=1, preset=None, clock=None, sync_steps=None, config=None, ...): "
        "the CAN bus of this test, with the arguments of vdrive.canopen.Bus")


def _options_of(request: pytest.FixtureRequest) -> Options:
    options: Options = {"over": request.config.getoption("--vdrive-over")}
    options.update(_marked(request, "vdrive"))
    return options


def _marked(request: pytest.FixtureRequest, name: str) -> Options:
    """Return the arguments from the markers of a test; if several give the same one, the closest counts."""
    import vdrive

    options: Options = {}
    for marker in reversed(list(request.node.iter_markers(name))):  # the closest one last
        if len(marker.args) > 1:
            raise vdrive.ConfigurationError(
                f"pytest.mark.{name}{marker.args!r}: only `axes` may be given without its name")
        options.update(zip(("axes",), marker.args))
        options.update(marker.kwargs)
    return options


def _name_domain(monkeypatch: pytest.MonkeyPatch, options: Options, bench: vdrive.Bench) -> None:
    """Set VDRIVE_DOMAIN to the domain of a bench over DDS, for programs that the test starts."""
    if options["over"] == "dds":
        monkeypatch.setenv("VDRIVE_DOMAIN", str(bench.domain))


class _Judge:
    """Judges what a test did on vdrive_bench, once the test has passed."""

    def __init__(self, journal: str, options: Options) -> None:
        import vdrive
        from vdrive._judge import SEVERITIES

        unknown = sorted(set(options) - {"off", "fail_on"})
        if unknown:
            raise vdrive.ConfigurationError(
                f"pytest.mark.vdrive_judge: unknown {', '.join(unknown)}; known keys: off, fail_on")
        self.journal = journal
        self.bench: vdrive.Bench | None = None
        self._off = options.get("off", {})
        fail_on = options.get("fail_on", "error")
        if fail_on not in SEVERITIES:
            raise vdrive.ConfigurationError(
                f"pytest.mark.vdrive_judge: fail_on={fail_on!r}: one of {', '.join(SEVERITIES)}")
        self._failing = SEVERITIES[:SEVERITIES.index(fail_on) + 1]

    def verdict(self) -> vdrive.Verdict:
        """End the bench, and judge what its masters did."""
        import vdrive

        if self.bench is not None:
            self.bench.close()  # completes its journal
        return vdrive.judge(self.journal, off=self._off)

    def failure(self) -> tuple[str, list[str]]:
        """Return why the test fails, or an empty text, and the rules in `off` that were not broken."""
        try:
            verdict = self.verdict()
        except Exception as error:  # such as an error in the marker
            return f"vdrive_judge: {error}", []
        fails = any(finding.severity in self._failing for finding in verdict.findings)
        return "vdrive_judge: " + verdict.report if fails else "", verdict.unused


@pytest.fixture
def vdrive_judge(request: pytest.FixtureRequest, tmp_path: Any) -> _Judge:
    """Judge what this test does on vdrive_bench, as `vdrive judge` does: a finding fails the test.

    When the test function has passed, its bench ends, before the other fixtures. The marker vdrive_judge
    takes the exceptions, off={rule: reason}, and fail_on: "error" (default), "warning" or "advice".
    verdict() ends the bench and returns the findings.
    """
    return _Judge(str(tmp_path / "bench.journal"), _marked(request, "vdrive_judge"))


@pytest.fixture
def vdrive_bench(request: pytest.FixtureRequest,
                 monkeypatch: pytest.MonkeyPatch) -> Iterator[vdrive.Bench]:
    """A private bench, in lock-step. For a bench over DDS, VDRIVE_DOMAIN is its domain."""
    import vdrive  # imported only when a test needs a bench: it takes time

    options = _options_of(request)
    ticks = request.config.getoption("--vdrive-record")
    if ticks is None:  # over DDS, an additional session takes time to find the bench
        ticks = _USUAL_TICKS if options["over"] == "local" else 0
    judge = request.getfixturevalue("vdrive_judge") if "vdrive_judge" in request.fixturenames else None
    if judge is not None:
        judge.journal = str(options.setdefault("journal", judge.journal))
    with vdrive.Bench(**options) as bench:
        if judge is not None:
            judge.bench = bench
        _name_domain(monkeypatch, options, bench)
        if ticks == 0:
            yield bench
            return
        recorder = request.node.stash[_RECORDER] = _Recorder(bench, ticks)
        yield bench
        del request.node.stash[_RECORDER]
        recorder.close()


@pytest.fixture
def bench(vdrive_bench: vdrive.Bench) -> vdrive.Bench:
    """The same as vdrive_bench."""
    return vdrive_bench


@pytest.fixture
def vdrive_session(vdrive_bench: vdrive.Bench) -> Iterator[vdrive.Session]:
    """A session on the private bench of this test."""
    with vdrive_bench.session() as session:
        yield session


@pytest.fixture
def vdrive_benches(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch,
                   ) -> Iterator[Callable[..., list[vdrive.Bench]]]:
    """A function that creates private benches for use by one session: `vdrive_benches(2, axes=1)`.

    It returns a list of that many benches, numbered from 1. Their options come from the marker and from
    the call. Benches from different calls are separate. All end with the test.
    """
    import vdrive
    from vdrive._arguments import whole
    from vdrive._vdrive import HIGHEST_BENCH

    with contextlib.ExitStack() as made:
        def make(count: int, **options: Any) -> list[vdrive.Bench]:
            try:
                count = whole("count", count, 1, HIGHEST_BENCH)
            except ValueError as error:
                raise vdrive.ConfigurationError(str(error)) from None
            options = {**_options_of(request), **options}
            for name in ("number", "beside"):
                if name in options:
                    raise vdrive.ConfigurationError(
                        f"{name} = {options[name]!r}: vdrive_benches chooses it: leave it out")
            benches: list[vdrive.Bench] = []
            for number in range(1, count + 1):
                beside = benches[0] if benches else None
                benches.append(made.enter_context(
                    vdrive.Bench(number=number, beside=beside, **options)))
            _name_domain(monkeypatch, options, benches[0])
            return benches

        yield make


@pytest.fixture
def vdrive_can(request: pytest.FixtureRequest) -> Iterator[vdrive.canopen.Bus]:
    """A CAN bus for this test, by default with one axis, node 1; the marker vdrive_can has its arguments.

    It ends with the test, which closes the buses from its can(). The test fails if the program of the
    bus has ended by itself.
    """
    from vdrive import canopen  # imported only when a test needs a bus: it takes time

    options = _marked(request, "vdrive_can")
    if "config" not in options:
        options.setdefault("axes", 1)
    with canopen.Bus(**options) as bus:
        yield bus


class _SharedBench:
    """A bench that tests use one after the other, with a snapshot from before the first test."""

    # 0x08000021: another session is in control.
    _IS_OWNED = 0x08000021

    def __init__(self, options: Options, start: Start | None) -> None:
        import vdrive

        self._refused = vdrive.Refused
        # Restoring a snapshot does not restore stored parameters.
        if options.get("state") is not None or any(
                str(word).startswith("--state") for word in options.get("arguments", ())):
            raise vdrive.ConfigurationError(
                "a shared bench has no state directory: what a test stores would be there for the "
                "next one; use vdrive_bench")
        self.options, self.start = options, start
        self.bench = vdrive.Bench(**options)
        try:
            self._begin()
        except BaseException:
            self.bench.close()
            raise

    def _begin(self) -> None:
        import vdrive

        # Stays open: over DDS, each session searches for the bench again.
        self._keeper = self.bench.session()
        found = self._keeper.find_bench()
        if found.clock_mode == "freerun":
            raise vdrive.ConfigurationError(
                "clock = 'freerun': a shared bench returns to a snapshot, for which its time has to "
                "stand still; use lockstep or realtime, or vdrive_bench")
        self._rate = found.rate if found.clock_mode == "realtime" else None
        if self.start is not None:
            self.start(self._keeper)
            self._keeper.release()
        with self._time_stands():
            self._snapshot = self._keeper.take_snapshot()

    @contextlib.contextmanager
    def _time_stands(self) -> Iterator[None]:
        if self._rate is not None:
            self._keeper.set_rate(0)
        yield
        if self._rate is not None:
            self._keeper.set_rate(self._rate)

    def restore(self) -> None:
        """Restore all axes to the snapshot, without owners."""
        with self._time_stands():
            for number in self._keeper.snapshots():  # a bench keeps 16
                if number != self._snapshot:
                    self._keeper.drop_snapshot(number)
            try:
                self._keeper.restore_snapshot(self._snapshot)
            except self._refused as refusal:
                if refusal.code != self._IS_OWNED:
                    raise
                # Held by a session that bench.session() did not open, or by one that is just ending.
                for axis in self._keeper.axes():
                    axis.take_over()
                self._keeper.restore_snapshot(self._snapshot)
            if self._rate is None:
                # The bench reports the restored changes as events of its next tick. This tick belongs to
                # no test.
                self._keeper.step(1)
                self._keeper.restore_snapshot(self._snapshot)
        self._keeper.release()

    def end_test(self) -> None:
        """Close the sessions of the test: a callback or a stepper must not act in the next test.

        Also end the benches that the test created with this one as `beside`: the next test would find
        them.
        """
        self.bench._close_others()
        self.bench._close_sessions(but=self._keeper)


class _SharedBenches:
    """The shared benches of a run of pytest: one for each set of options."""

    def __init__(self) -> None:
        self._benches: list[_SharedBench] = []

    def get(self, options: Options, start: Start | None) -> _SharedBench:
        """Return the shared bench with these options, in its state before the first test."""
        import vdrive

        for shared in self._benches:
            if (shared.options, shared.start) != (options, start):
                continue
            try:
                shared.restore()
                return shared
            except vdrive.Error:  # a test has ended it, or dropped the snapshot
                shared.bench.close()
                self._benches.remove(shared)
                break
        self._benches.append(_SharedBench(options, start))
        return self._benches[-1]

    def close(self) -> None:
        for shared in self._benches:
            shared.bench.close()


@pytest.fixture(scope="session")
def _vdrive_shared_benches() -> Iterator[_SharedBenches]:
    benches = _SharedBenches()
    yield benches
    benches.close()


@pytest.fixture(scope="session")
def vdrive_shared_start() -> Start | None:
    """A function that prepares a shared bench before its first test; it gets a session. None = no preparation.

    Override this fixture in your project, with session or module scope.
    """
    return None


@pytest.fixture
def vdrive_shared_bench(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch,
                        _vdrive_shared_benches: _SharedBenches,
                        vdrive_shared_start: Start | None) -> Iterator[vdrive.Bench]:
    """A bench that all tests with these options share; each starts with the state before the first test.

    The axes have no owner. The tick number, session numbers, epochs and the history of events carry
    over. A bench that a test has ended is created again.
    """
    options = _options_of(request)
    shared = _vdrive_shared_benches.get(options, vdrive_shared_start)
    _name_domain(monkeypatch, options, shared.bench)
    yield shared.bench
    shared.end_test()


@pytest.fixture
def vdrive_shared_session(vdrive_shared_bench: vdrive.Bench) -> Iterator[vdrive.Session]:
    """A session on the shared bench."""
    with vdrive_shared_bench.session() as session:
        yield session
