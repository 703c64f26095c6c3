# SPDX-License-Identifier: Apache-2.0
"""vdrive.canopen: start and end, raw sockets on its bus, python-can, and the fixture."""
import configparser
import os
import pathlib
import re
import select
import signal
import socket
import struct
import subprocess
import sys
import textwrap
import time

import pytest
import vdrive
import vdrive.canopen

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "canopen/masters"))
from can_client import HEARTBEAT, START, TPDO, CanClient, Frame, SdoAbort

PATIENCE = 60
PERIOD = 0.001  # [s]


@pytest.fixture(scope="module", autouse=True)
def program():
    """Skip the module without vdrive-canopen."""
    try:
        return vdrive.canopen.find_program()
    except vdrive.NotFound as error:
        pytest.skip(str(error))


@pytest.fixture
def fake(tmp_path):
    """A function that replaces vdrive-canopen with a shell script."""
    def make(text):
        path = tmp_path / "vdrive-canopen"
        path.write_text(f"#!/bin/sh\n{text}\n")
        path.chmod(0o755)
        return path

    return make


LINE = ("vdrive-canopen: bus 1: 2 nodes (4 to 5), socketcand 127.0.0.1:29536, gateway 127.0.0.1:60000, "
        "session 1a2b3c4d5e6f7081")
# The signal may arrive as soon as the first line has been read, so the trap is set before that.
ENDS = """trap 'echo "vdrive-canopen: bus 1: 1234 frames, 5 SDO aborts"; exit 0' TERM"""
RUNS = "while :; do sleep 0.02; done"


def serving(first):
    """A script that runs `first`, which prints the first line, then serves until it is ended."""
    return f"{ENDS}\n{first}\n{RUNS}"


# The first line, and the ways in which a program may fail. Scripts replace the real program.

def test_the_first_line_says_where_the_bus_is_and_the_last_one_what_it_counted(fake):
    with vdrive.canopen.Bus(program=fake(serving(f"echo '{LINE}'"))) as bus:
        assert (bus.host, bus.port, bus.channel) == ("127.0.0.1", 29536, "can0")
        assert bus.gateway == ("127.0.0.1", 60000) and bus.nodes == (4, 5)
        assert bus.exit_code is None and bus.counters == {}
    assert bus.exit_code == 0 and bus.counters == {"frames": 1234, "SDO aborts": 5}


@pytest.mark.parametrize("nodes, expected", [
    ("1 node (7)", (7,)), ("3 nodes (1 to 3)", (1, 2, 3)), ("4 nodes (1, 3 to 4, 127)", (1, 3, 4, 127))])
def test_nodes_are_read_in_each_form(fake, nodes, expected):
    line = LINE.replace("2 nodes (4 to 5)", nodes)
    with vdrive.canopen.Bus(program=fake(serving(f"echo '{line}'"))) as bus:
        assert bus.nodes == expected


def test_a_line_that_comes_in_parts_is_read_whole(fake):
    parts = serving(f"printf '{LINE[:40]}'\nsleep 0.1\nprintf '{LINE[40:]}\\n'")
    with vdrive.canopen.Bus(program=fake(parts)) as bus:
        assert bus.nodes == (4, 5)


@pytest.mark.parametrize("script, kind, text", [
    ("echo 'cannot listen on 127.0.0.1:1: denied' >&2; exit 1", vdrive.Failed,
     "did not start: cannot listen on 127.0.0.1:1: denied"),
    ("echo 'unknown option' >&2; exit 2", vdrive.ConfigurationError, "did not start: unknown option"),
    ("exit 3", vdrive.Failed, "vdrive-canopen ended with exit code 3 and wrote nothing"),
    ("kill -KILL $$", vdrive.Failed, "vdrive-canopen was ended by signal 9 and wrote nothing"),
    ("echo hello; exec sleep 100", vdrive.Failed, "its first line has no nodes: 'hello'"),
    ("echo '1 node (1), gateway a:1'; exec sleep 100", vdrive.Failed, "its first line has no socketcand"),
    ("echo '1 node (1), socketcand a:1'; exec sleep 100", vdrive.Failed, "its first line has no gateway"),
    ("printf 'no end of the line'; exit 0", vdrive.Failed, "ended with exit code 0 and wrote nothing"),
])
def test_a_program_that_does_not_start_is_an_error_with_its_text(fake, script, kind, text):
    with pytest.raises(kind, match="vdrive-canopen") as error:
        vdrive.canopen.Bus(program=fake(script))
    assert text in str(error.value)


def test_a_program_that_writes_nothing_is_ended_after_a_while(fake, monkeypatch):
    monkeypatch.setattr(vdrive.canopen, "_START", 0.2)
    with pytest.raises(vdrive.Failed, match="did not start within 0.2 s: still busy"):
        vdrive.canopen.Bus(program=fake("echo 'still busy' >&2; exec sleep 100"))


def test_a_path_that_is_no_program_is_named(tmp_path):
    with pytest.raises(vdrive.Failed, match="nowhere: no such file"):
        vdrive.canopen.Bus(program=tmp_path / "nowhere")
    (tmp_path / "text").write_text("text")
    with pytest.raises(vdrive.Failed, match="text: not a program that can be executed"):
        vdrive.canopen.Bus(program=tmp_path / "text")
    with pytest.raises(vdrive.Failed, match="not a program that can be executed"):
        vdrive.canopen.Bus(program=tmp_path)


def test_where_there_is_no_program_the_variable_is_named(monkeypatch):
    monkeypatch.delenv("VDRIVE_CANOPEN", raising=False)
    monkeypatch.setenv("PATH", "/nowhere")
    if pathlib.Path(os.readlink("/proc/self/exe")).with_name("vdrive-canopen").exists():
        pytest.skip("vdrive-canopen is beside the interpreter")
    with pytest.raises(vdrive.NotFound, match="name the program in VDRIVE_CANOPEN"):
        vdrive.canopen.Bus()


def test_a_signal_handler_that_raises_ends_the_start_and_the_program(fake):
    def ring(*_):
        raise TimeoutError("rung")

    before = signal.signal(signal.SIGALRM, ring)
    others = children()
    begin = time.monotonic()
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        with pytest.raises(TimeoutError, match="rung"):
            vdrive.canopen.Bus(program=fake("exec sleep 1000"))
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert time.monotonic() - begin < PATIENCE, "a wait that a signal interrupts waits for the end"
    assert children() == others


def test_what_a_master_raises_at_its_end_leaves_no_program(fake, monkeypatch):
    class Broken:
        def shutdown(self):
            raise OSError("of the master")

    class Can:
        @staticmethod
        def Bus(**_):
            return Broken()

    monkeypatch.setitem(sys.modules, "can", Can)
    bus = vdrive.canopen.Bus(program=fake(serving(f"echo '{LINE}'")))
    made = bus.can(), bus.can()
    with pytest.raises(OSError, match="of the master"):
        bus.close()
    assert bus.exit_code == 0 and bus.counters == {"frames": 1234, "SDO aborts": 5}
    assert len(made) == 2
    bus.close()


def test_the_arguments_of_the_bus_are_those_of_the_program(fake, tmp_path):
    config = tmp_path / "bench.yaml"
    config.write_text("axes: [{number: 1}]\n")
    path = fake(serving(f"echo \"$@\" > {tmp_path}/arguments; echo '{LINE}'"))
    for options, words in (
            ({}, ["--axes", "3"]),
            ({"axes": 1, "clock": "realtime"}, ["--axes", "1", "--clock", "realtime"]),
            ({"preset": "winder"}, ["--axes", "3", "--preset", "winder"]),
            ({"sync_steps": 0.001}, ["--axes", "3", "--sync-steps", "1000us"]),
            ({"clock": "lockstep", "sync_steps": 1, "node_offset": 4},
             ["--axes", "3", "--clock", "lockstep", "--sync-steps", "1000000us", "--node-offset", "4"]),
            ({"config": config, "arguments": ["--state", tmp_path]},
             ["--bench-config", str(config), "--state", str(tmp_path)])):
        with vdrive.canopen.Bus(program=path, **options):
            assert (tmp_path / "arguments").read_text().split() == [
                "--private", "--socketcand", "127.0.0.1:0", "--gateway", "127.0.0.1:0", *words]


# Arguments.

@pytest.mark.parametrize("options, message", [
    ({"axes": 0}, "axes = 0: must be from 1 to 127"),
    ({"axes": 128}, "axes = 128: must be from 1 to 127"),
    ({"axes": 1.5}, "axes = 1.5: must be a whole number from 1 to 127"),
    ({"axes": 100, "node_offset": 28}, "axes = 100: with node_offset = 28 must be at most 99"),
    ({"node_offset": -1}, "node_offset = -1: must be from 0 to 126"),
    ({"node_offset": 127}, "node_offset = 127: must be from 0 to 126"),
    ({"clock": "freerun"}, "clock = 'freerun': must be one of realtime, lockstep"),
    ({"sync_steps": 0}, "sync_steps = 0: must be a whole number of microseconds"),
    ({"sync_steps": -0.001}, "sync_steps = -0.001"), ({"sync_steps": 11}, "sync_steps = 11: "),
    ({"sync_steps": float("nan")}, "sync_steps = nan"), ({"sync_steps": 1.5e-6}, "sync_steps = 1.5e-06"),
    ({"sync_steps": 0.01, "clock": "realtime"}, "sync_steps= is of a bus in lock-step"),
    ({"config": "nowhere.yaml"}, "config = 'nowhere.yaml': No such file or directory"),
    ({"config": __file__, "axes": 2}, "axes= and config= both define the axes"),
    ({"config": __file__, "preset": "winder"}, "preset= and config= both define the axes"),
    ({"preset": "winda"}, "preset = 'winda': must be one of ball-screw, "),
    ({"program": ""}, "program = '': must be a path"),
])
def test_a_value_that_no_bus_can_have_is_named_with_its_limit(options, message):
    with pytest.raises(vdrive.ConfigurationError) as error:
        vdrive.canopen.Bus(**options)
    assert message in str(error.value)


@pytest.mark.parametrize("options, message", [
    ({"axes": "2"}, "axes = '2': must be a whole number"), ({"config": 7}, "config = 7: must be a path"),
    ({"sync_steps": "1ms"}, "sync_steps = '1ms'"), ({"program": 1}, "program = 1: must be a path"),
    ({"arguments": "--state x"}, "arguments = '--state x': must be a list of words"),
    ({"preset": 7}, "preset = 7: must be the name of a machine"),
])
def test_a_value_of_a_wrong_type_is_named(options, message):
    with pytest.raises(TypeError) as error:
        vdrive.canopen.Bus(**options)
    assert message in str(error.value)


def test_what_the_program_refuses_has_its_words():
    with pytest.raises(vdrive.ConfigurationError, match="'--acses' is not an option"):
        vdrive.canopen.Bus(arguments=["--acses", "3"])
    with pytest.raises(vdrive.ConfigurationError, match="--sync-steps '1us'"):
        vdrive.canopen.Bus(sync_steps=1e-6)
    with pytest.raises(vdrive.ConfigurationError, match="--clock lockstep needs --sync-steps"):
        vdrive.canopen.Bus(clock="lockstep")


def test_the_network_of_the_environment_is_not_for_it(monkeypatch):
    monkeypatch.setenv("VDRIVE_DOMAIN", "17")
    monkeypatch.setenv("VDRIVE_SECURITY", "/nowhere")
    with vdrive.canopen.Bus(axes=1) as bus:
        assert bus.nodes == (1,)


# The bus of the real program, by raw sockets.

def test_the_axes_of_a_bench_are_its_nodes():
    with vdrive.canopen.Bus(axes=2, node_offset=10) as bus, CanClient(bus.host, bus.port) as client:
        assert bus.nodes == (11, 12)
        for node in bus.nodes:
            assert client.read(node, 0x1000) == 0x00020192  # a servo drive of CiA 402
        with pytest.raises(SdoAbort) as abort:
            client.read(11, 0x5FFF)
        assert abort.value.code == 0x06020000
    assert bus.counters["frames"] >= 6


def test_a_configuration_names_the_nodes(tmp_path):
    config = tmp_path / "bench.yaml"
    config.write_text("axes: [{number: 5}, {number: 9, name: lift}]\n")
    with vdrive.canopen.Bus(config=config) as bus:
        assert bus.nodes == (5, 9)


def test_each_sync_lets_a_period_pass():
    with vdrive.canopen.Bus(axes=1, sync_steps=PERIOD) as bus, CanClient(bus.host, bus.port) as client:
        client.write(1, 0x1017, 0, 10, 2)  # a heartbeat every 10 ms of drive time
        for _ in range(100):
            client.sync()
        client.read(1, 0x1000)
        client.drain()
        # Eleven if the first one is sent immediately.
        assert client.received[HEARTBEAT + 1] in (10, 11)


def scenario(bus):
    """Enable, move, and return all frames of the node."""
    with CanClient(bus.host, bus.port) as client:
        client.nmt(START, 1)
        client.write(1, 0x6060, 0, 1, 1)
        for word in (0x06, 0x07, 0x0F):
            client.write(1, 0x6040, 0, word, 2)
            client.sync()
        client.write(1, 0x607A, 0, 1000, 4)
        client.write(1, 0x6040, 0, 0x1F, 2)
        for _ in range(300):
            client.sync()
        assert client.read(1, 0x6064, signed=True) == 1000
        client.drain()
        return client.seen


def test_speeds_in_rpm_and_latched_positions_are_objects_of_a_node():
    with vdrive.canopen.Bus(axes=1, sync_steps=PERIOD) as bus, CanClient(bus.host, bus.port) as client:
        client.nmt(START, 1)
        client.write(1, 0x5E21, 3, 1000, 4)  # the home switch, 500 UU long
        client.write(1, 0x5E21, 4, 500, 4)
        client.write(1, 0x60B8, 0, 0x11, 2)  # probe 1, the first rising edge of that switch
        client.write(1, 0x6060, 0, 2, 1)
        client.write(1, 0x6042, 0, 60, 2)
        for word in (0x06, 0x07, 0x0F, 0x7F):  # the last one with the ramp bits
            client.write(1, 0x6040, 0, word, 2)
            client.sync()
        for _ in range(500):
            client.sync()
        assert client.read(1, 0x6061) == 2 and client.read(1, 0x6043, signed=True) == 60
        assert abs(client.read(1, 0x6044, signed=True) - 60) <= 1
        # Enabled, rising edge stored. 4096 UU/s are 0.5 UU in a sub-step of 125 us.
        assert client.read(1, 0x60B9) == 3
        assert client.read(1, 0x60BA, signed=True) in (1000, 1001)


def test_in_lockstep_a_test_repeats_itself_frame_by_frame():
    runs = []
    for _ in range(2):
        with vdrive.canopen.Bus(axes=1, sync_steps=PERIOD) as bus:
            runs.append(scenario(bus))
    assert runs[0] == runs[1] and any(frame.id == TPDO + 1 for frame in runs[0])


def test_masters_of_one_bus_see_each_others_frames_and_those_of_another_do_not():
    with vdrive.canopen.Bus(axes=1) as bus, vdrive.canopen.Bus(axes=1) as other:
        assert bus.port != other.port and bus.gateway != other.gateway
        with CanClient(bus.host, bus.port) as first, CanClient(bus.host, bus.port) as second, \
                CanClient(other.host, other.port) as stranger:
            first.send(0x7E5, b"\1\2\3")
            assert second.wait_for(lambda frame: frame.id == 0x7E5).data == b"\1\2\3"
            stranger.read(1, 0x1000)
            assert 0x7E5 not in stranger.latest and 0x7E5 not in first.latest


def test_the_ascii_gateway_answers():
    with vdrive.canopen.Bus(axes=1) as bus, \
            socket.create_connection(bus.gateway, timeout=PATIENCE) as gateway:
        gateway.sendall(b"[1] 1 r 0x1000 0 u32\r\n")
        assert gateway.makefile("rb").readline() == b"[1] 131474\r\n"


# The end of a bus.

def test_it_is_closed_any_number_of_times():
    bus = vdrive.canopen.Bus(axes=1)
    place = bus.host, bus.port
    assert repr(bus) == f"<vdrive.canopen.Bus {bus.host}:{bus.port}, 1 nodes>"
    bus.close()
    bus.close()
    assert bus.exit_code == 0 and "closed" in repr(bus)
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(place, timeout=PATIENCE)
    with pytest.raises(vdrive.Failed, match="the bus has ended"):
        bus.can()


def children():
    return {int(child) for path in pathlib.Path("/proc/self/task").glob("*/children")
            for child in path.read_text().split()}


def test_a_program_that_ends_by_itself_does_not_go_unnoticed():
    before = children()
    bus = vdrive.canopen.Bus(axes=1)
    child, = children() - before
    os.kill(child, signal.SIGKILL)
    while bus.exit_code is None:
        time.sleep(0.01)
    with pytest.raises(vdrive.Failed, match="has ended by itself: .*signal 9"):
        bus.close()
    bus.close()
    assert bus.exit_code == -signal.SIGKILL
    with pytest.raises(ValueError, match="of the test"):  # the first error is the one that is raised
        with vdrive.canopen.Bus(axes=1):
            os.kill((children() - before).pop(), signal.SIGKILL)
            raise ValueError("of the test")


MAKES_A_BUS = """
    import os, pathlib, signal, sys, time
    import vdrive.canopen
    bus = vdrive.canopen.Bus(axes=1)
    print(*[child for path in pathlib.Path("/proc/self/task").glob("*/children")
            for child in path.read_text().split()], bus.port, flush=True)
    {end}
"""


@pytest.mark.parametrize("end, code", [
    ("pass", 0), ("sys.exit(3)", 3), ("os._exit(4)", 4), ("raise SystemExit(5)", 5),
    ("os.kill(os.getpid(), signal.SIGKILL)", -signal.SIGKILL)])
def test_the_program_ends_with_the_interpreter_however_that_ends(end, code):
    done = subprocess.Popen([sys.executable, "-c", textwrap.dedent(MAKES_A_BUS.format(end=end))],
                            stdout=subprocess.PIPE, text=True)
    child = int(done.stdout.readline().split()[0])
    try:
        handle = os.pidfd_open(child)
    except ProcessLookupError:
        handle = None  # it has already ended
    assert done.wait(PATIENCE) == code
    if handle is not None:
        assert select.select([handle], [], [], PATIENCE)[0], "the program runs on"
        os.close(handle)


def test_a_forked_child_leaves_the_bus_to_its_parent():
    with vdrive.canopen.Bus(axes=1) as bus:
        reader, writer = os.pipe()
        child = os.fork()
        if child == 0:
            texts = []
            try:
                bus.close()
                for call in (lambda: bus.exit_code, lambda: bus.errors):
                    try:
                        call()
                    except vdrive.Forked as error:
                        texts.append(str(error))
                with CanClient(bus.host, bus.port) as client:
                    texts.append(str(client.read(1, 0x1000)))
            finally:
                os.write(writer, "\n".join(texts).encode())
                os._exit(0)
        os.close(writer)
        with os.fdopen(reader) as file:
            texts = file.read().splitlines()
        os.waitpid(child, 0)
        # The child joins the bus like any other program.
        assert len(texts) == 3 and "forked" in texts[0] and texts[2] == str(0x00020192)
        with CanClient(bus.host, bus.port) as client:
            assert client.read(1, 0x1000) == 0x00020192


# python-can.

def test_without_python_can_its_package_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "can", None)
    with vdrive.canopen.Bus(axes=1) as bus:
        with pytest.raises(vdrive.NotFound, match="apt-get install python3-can"):
            bus.can()


def test_python_can_drives_an_axis():
    can = pytest.importorskip("can", reason="python3-can is not installed")
    with vdrive.canopen.Bus(axes=1) as bus:
        with can.Bus(interface="socketcand", host=bus.host, port=bus.port, channel="can0") as master:
            master.send(can.Message(arbitration_id=0x000, data=[0x82, 1], is_extended_id=False))
            deadline = time.monotonic() + PATIENCE
            boot = None
            while boot is None or boot.arbitration_id != HEARTBEAT + 1:
                boot = master.recv(timeout=max(0.0, deadline - time.monotonic()))
                assert boot is not None, "no boot-up"
            assert bytes(boot.data) == b"\0"
        made = bus.can(receive_own_messages=False)
        made.send(can.Message(arbitration_id=0x601, data=[0x40, 0x00, 0x10, 0, 0, 0, 0, 0],
                              is_extended_id=False))
        answer = made.recv(timeout=PATIENCE)
        while answer.arbitration_id != 0x581:
            answer = made.recv(timeout=PATIENCE)
        assert bytes(answer.data) == bytes.fromhex("43 00 10 00 92 01 02 00")
    # The bus has closed the objects that it made.
    with pytest.raises((can.CanError, OSError, ValueError)):
        made.send(can.Message(arbitration_id=0x601, is_extended_id=False))
        made.recv(timeout=1.0)


def test_python_can_sees_every_frame_of_a_burst_in_order():
    can = pytest.importorskip("can", reason="python3-can is not installed")
    count = 2000
    with vdrive.canopen.Bus(axes=1) as bus, CanClient(bus.host, bus.port) as client:
        listener = bus.can()
        listener.send(can.Message(arbitration_id=0x7E4, is_extended_id=False))  # it is on the bus when this arrives
        client.wait_for(lambda frame: frame.id == 0x7E4)
        for number in range(count):
            client.send(0x7E5, number.to_bytes(2, "little"))
        seen = []
        while len(seen) < count:
            message = listener.recv(timeout=PATIENCE)
            assert message is not None, f"{len(seen)} of {count} frames have come"
            seen += [message.data] if message.arbitration_id == 0x7E5 else []
        assert [int.from_bytes(data, "little") for data in seen] == list(range(count))


# The fixture.

def test_the_fixture_has_one_axis_and_what_its_marker_says(pytester):
    pytester.makepyfile("""
        import pytest

        def test_one(vdrive_can):
            assert vdrive_can.nodes == (1,)

        @pytest.mark.vdrive_can(axes=3, clock="lockstep", sync_steps=0.01)
        def test_three(vdrive_can):
            assert vdrive_can.nodes == (1, 2, 3)

        @pytest.mark.vdrive_can(axes=2, node_offset=20)
        class TestTwo:
            def test_of_the_class(self, vdrive_can):
                assert vdrive_can.nodes == (21, 22)

            @pytest.mark.vdrive_can(axes=1)
            def test_of_its_own(self, vdrive_can):
                assert vdrive_can.nodes == (21,)
    """)
    pytester.runpytest_subprocess("-q", "-p", "no:cacheprovider", "--strict-markers",
                                  timeout=200).assert_outcomes(passed=4)


def test_a_bus_whose_program_ends_is_an_error_of_its_test(pytester):
    pytester.makepyfile("""
        import os, pathlib, signal

        def test_one(vdrive_can):
            child, = [int(child) for path in pathlib.Path("/proc/self/task").glob("*/children")
                      for child in path.read_text().split()]
            os.kill(child, signal.SIGKILL)
    """)
    result = pytester.runpytest_subprocess("-q", "-p", "no:cacheprovider", timeout=200)
    result.assert_outcomes(passed=1, errors=1)
    result.stdout.fnmatch_lines(["*Failed: vdrive-canopen *signal 9*"])


def test_importing_the_module_does_not_read_it():
    done = subprocess.run([sys.executable, "-c", "import sys, vdrive; print('vdrive.canopen' in sys.modules);"
                           "print(vdrive.canopen.Bus.__name__, 'canopen' in dir(vdrive))"],
                          capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "Bus", "True"]


def test_every_public_name_has_a_docstring():
    missing = [name for name in vdrive.canopen.__all__ if not getattr(vdrive.canopen, name).__doc__]
    missing += [name for name, value in vars(vdrive.canopen.Bus).items()
                if not name.startswith("_") and name != "channel" and not value.__doc__]
    assert missing == []


def test_a_frame_shows_itself_as_on_a_bus():
    assert repr(Frame(0x181, b"\x40\x02")) == "181#4002"


CONFIGURED = """
bench: {number: 7}
axes:
  - number: 3
    parameters: {profile_velocity: 4321, vendor_id: 0x1234, serial_number: 99}
"""
NUMBER_TYPES = {0x1: "?", 0x2: "b", 0x3: "h", 0x4: "i", 0x5: "B", 0x6: "H", 0x7: "I", 0x15: "q", 0x1B: "Q"}  # CiA 306


@pytest.mark.parametrize("machine", ["default", "preset", "configuration"])
def test_a_node_answers_what_its_device_configuration_file_says(tmp_path, machine):
    config = tmp_path / "bench.yaml"
    config.write_text(CONFIGURED)
    options = {"default": {"axes": 3}, "preset": {"axes": 3, "preset": "winder"},
               "configuration": {"config": config}}[machine]
    chosen = {"default": [], "preset": ["--preset", "winder"],
              "configuration": ["--config", str(config)]}[machine]
    text = subprocess.run([os.environ["VDRIVE_TOOL"], "dictionary", "--format", "eds", "--node", "3", *chosen],
                          check=True, capture_output=True, text=True).stdout
    sheet = configparser.ConfigParser(interpolation=None)
    sheet.optionxform = str
    sheet.read_string(text)
    objects = {name: entry for name, entry in sheet.items()
               if re.fullmatch(r"[0-9A-F]{4}(sub[0-9A-F]+)?", name) and "DefaultValue" in entry
               and not re.fullmatch("1003sub[1-8]", name)}  # a node without errors refuses these with 08000024h
    differing, compared = [], 0
    with vdrive.canopen.Bus(sync_steps=PERIOD, **options) as bus, CanClient(bus.host, bus.port) as client:
        for name, entry in objects.items():
            kind = NUMBER_TYPES.get(int(entry["DataType"], 0))
            if entry["AccessType"] == "wo" or kind is None or entry["DefaultValue"] == "":
                continue
            index, _, sub = name.partition("sub")
            answer = struct.unpack("<" + kind, client.upload(3, int(index, 16), int(sub or "0", 16)))[0]
            compared += 1
            if answer != int(entry["DefaultValue"], 0):
                differing.append((name, entry["DefaultValue"], answer))
    assert compared > 150 and differing == []
