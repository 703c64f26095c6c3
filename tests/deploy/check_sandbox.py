#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs vdrived with the permissions of its systemd unit, as far as possible without systemd.

    tests/deploy/check_sandbox.py VDRIVED VDRIVE [DROP_IN]

The filter of system calls and address families is built from the unit itself, memory that is both
writable and executable is refused, the system is read-only without home directories, and the user
is nobody. The service must become ready, send watchdog messages, answer the tool and end on
request. Its engine and its network process ("wire") must each add their own filter; a wire that is
killed must be replaced while the engine continues. With a drop-in, the tick thread must also get
its real-time priority. Exit code 77: no sandbox can be made here.
"""

import json
import os
import pathlib
import resource
import signal
import socket
import subprocess
import sys
import tempfile
import time

import seccomp

UNIT = pathlib.Path(__file__).parents[2] / "deploy/systemd/vdrived.service"
DOMAIN = "229"
NOBODY = "65534"


def fail(text):
    sys.exit(f"check_sandbox: {text}")


def values(files, key):
    """The values of a setting, one list per line."""
    for file in files:
        for line in file.read_text().splitlines():
            if line.startswith(key + "="):
                yield line.split("=", 1)[1].split()


def expand(names):
    """The system calls named, with groups such as @system-service resolved."""
    calls = set()
    for name in names:
        if not name.startswith("@"):
            calls.add(name)
            continue
        text = subprocess.run(["systemd-analyze", "syscall-filter", name], check=True,
                              capture_output=True, text=True).stdout
        members = [line.strip() for line in text.splitlines()[1:]]
        calls |= expand(member for member in members if member and not member.startswith("#"))
    return calls


def allowed_calls(files):
    calls = set()
    for names in values(files, "SystemCallFilter"):
        if names[0].startswith("~"):
            calls -= expand([names[0][1:]] + names[1:])
        else:
            calls |= expand(names)
    # systemd adds the calls needed to reach main().
    return calls | expand(["@default"]) | {"execve"}


def make_filter(files):
    families = [getattr(socket, name) for names in values(files, "RestrictAddressFamilies")
                for name in names]
    rules = seccomp.SyscallFilter(seccomp.ERRNO(1))
    for call in allowed_calls(files):
        try:
            if call == "socket":
                for family in families:
                    rules.add_rule(seccomp.ALLOW, call, seccomp.Arg(0, seccomp.EQ, family))
            elif call == "mmap":  # PROT_WRITE and PROT_EXEC together are refused
                for protection in (0, 2, 4):
                    rules.add_rule(seccomp.ALLOW, call,
                                   seccomp.Arg(2, seccomp.MASKED_EQ, 6, protection))
            elif call == "mprotect":
                rules.add_rule(seccomp.ALLOW, call, seccomp.Arg(2, seccomp.MASKED_EQ, 4, 0))
            else:
                rules.add_rule(seccomp.ALLOW, call)
        except (RuntimeError, ValueError, OSError):
            pass  # of another architecture or a newer kernel
    return rules


def sandbox(program, arguments, rules, state):
    """The command line that runs `program` in the sandbox, and a file that it needs open."""
    compiled = tempfile.TemporaryFile()
    rules.export_bpf(compiled)
    compiled.seek(0)
    command = ["bwrap", "--die-with-parent", "--ro-bind", "/", "/", "--dev", "/dev", "--proc", "/proc", "--tmpfs", "/tmp",
               "--tmpfs", "/home", "--tmpfs", "/root", "--ro-bind", program, "/tmp/vdrived",
               "--bind", state, "/tmp/state", "--setenv", "STATE_DIRECTORY", "/tmp/state",
               "--unshare-user", "--unshare-ipc", "--unshare-uts", "--uid", NOBODY, "--gid", NOBODY,
               "--cap-drop", "ALL", "--hostname", "vdrive", "--seccomp", str(compiled.fileno()),
               "/tmp/vdrived"] + arguments
    return command, compiled


def children_of(process):
    text = pathlib.Path(f"/proc/{process}/task/{process}/children").read_text()
    return [int(child) for child in text.split()]


def name_of(process):
    return pathlib.Path(f"/proc/{process}/comm").read_text().strip()


def only_child(process, name):
    """Waits until the only child of a process has this name."""
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline:
        try:
            children = children_of(process)
            if [name_of(child) for child in children] == [name]:
                return children[0]
        except (FileNotFoundError, ProcessLookupError):
            pass  # it ended during the check
        time.sleep(0.005)
    fail(f"process {process} has no child '{name}' and nothing else")


def state_of(process, field):
    for line in pathlib.Path(f"/proc/{process}/status").read_text().splitlines():
        if line.startswith(field + ":"):
            return int(line.split()[1])
    return fail(f"the kernel does not show {field} of a process")


def is_there(process):
    """Whether the process runs; a zombie has already released everything."""
    try:
        return "(zombie)" not in pathlib.Path(f"/proc/{process}/status").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return False


def check_filters(engine, spawner, wire):
    """The spawner has the unit's filter; engine and wire have one more each."""
    for name, process in (("engine", engine), ("wire", wire)):
        if state_of(process, "Seccomp") != 2:
            fail(f"the {name} has no filter of system calls")
        added = state_of(process, "Seccomp_filters") - state_of(spawner, "Seccomp_filters")
        if added != 1:
            fail(f"the {name} has {added} filters beside that of the unit instead of 1")


class Tool:
    def __init__(self, program):
        self.command = [program, "--domain", DOMAIN, "--timeout", "10", "--json"]

    def run(self, *words, may_fail=False):
        """@return the output, one object per line."""
        result = subprocess.run(self.command + list(words), capture_output=True, text=True)
        if result.returncode != 0 and not may_fail:
            fail(f"vdrive {' '.join(words)}: {result.stderr}")
        return [json.loads(line) for line in result.stdout.splitlines()]


def check_restart(tool, spawner, wire):
    """Kills the wire: another one of the same run of the service replaces it, and the axes are
    unchanged."""
    tool.run("enable", "1.1")
    killed = time.monotonic()
    os.kill(wire, signal.SIGKILL)
    while is_there(wire):
        time.sleep(0.001)
    state = tool.run("status", "1.1")[0]["state"]
    answered = time.monotonic()
    if state != "Operation enabled":
        fail(f"the axis did not outlive the wire: it is in {state}")
    # A restarted service would report only one start. Other findings of the doctor about this
    # machine are ignored.
    findings = [finding["text"] for finding in tool.run("doctor", may_fail=True)]
    if not any("bench 1 was started again once" in text for text in findings):
        fail(f"the doctor does not see a second wire of the same run: {findings}")
    print(f"the tool was answered {answered - killed:.3f} s after the wire was killed")
    return only_child(spawner, "vdrived-wire")


def end(service, processes):
    """Sends SIGTERM according to the unit's KillMode. @return the log of the service."""
    mode = [names[0] for names in values([UNIT], "KillMode")]
    begin = time.monotonic()
    for process in processes[:1] if mode == ["mixed"] else processes:
        os.kill(process, signal.SIGTERM)
    errors = service.communicate(timeout=5)[1]
    duration = time.monotonic() - begin
    if duration > 2:
        fail(f"it ended {duration:.3f} s after SIGTERM instead of 2 s: {errors}")
    left = [process for process in processes if is_there(process)]
    if left:
        fail(f"processes {left} outlived the service")
    print(f"it ended {duration:.3f} s after SIGTERM")
    return errors


def check_life(service, listener, tool):
    """Checks from start to end. @return the log of the service."""
    for line in ("READY=1", "WATCHDOG=1"):
        while line not in listener.recv(4096).decode().split("\n"):
            pass
    engine = only_child(service.pid, "vdrived")  # bwrap waits for it, and passes no signal on
    spawner = only_child(engine, "vdrived-spawner")
    wire = only_child(spawner, "vdrived-wire")
    check_filters(engine, spawner, wire)
    wire = check_restart(tool, spawner, wire)
    check_filters(engine, spawner, wire)
    return end(service, [engine, spawner, wire])


def check(program, tool, files):
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    name = f"vdrive-sandbox-{os.getpid()}"
    listener.bind("\0" + name)
    listener.settimeout(20)
    environment = dict(os.environ, NOTIFY_SOCKET="@" + name, WATCHDOG_USEC="400000")
    with tempfile.TemporaryDirectory() as state:
        priority = ""
        if len(files) > 1:
            priority = "clock: {realtime_priority: 10}\n"
        pathlib.Path(state, "bench.yaml").write_text(priority + "bench: {number: 1}\n")
        os.chmod(state, 0o755)
        command, compiled = sandbox(program, ["--domain", DOMAIN, "--wire", "process", "--config",
                                              "/tmp/state/bench.yaml"], make_filter(files), state)
        service = subprocess.Popen(command, env=environment, pass_fds=[compiled.fileno()],
                                   stderr=subprocess.PIPE, text=True)
        try:
            errors = check_life(service, listener, Tool(tool))
        except (TimeoutError, subprocess.TimeoutExpired) as problem:
            service.kill()
            fail(f"{problem}: {service.communicate()[1]}")
        finally:
            service.kill()
    if service.returncode != 0:
        fail(f"exit code {service.returncode}: {errors}")
    warnings = [line for line in errors.splitlines()
                if "not permitted" in line or "warning" in line]
    if [line for line in warnings if "event=wire" not in line]:
        fail(errors)


def main():
    if subprocess.run(["bwrap", "--ro-bind", "/", "/", "--unshare-user", "true"],
                      capture_output=True).returncode != 0:
        print("check_sandbox: no sandbox can be made here")
        sys.exit(77)
    program, tool, *drop_ins = sys.argv[1:]
    files = [UNIT] + [pathlib.Path(drop_in) for drop_in in drop_ins]
    limit = max([int(names[0]) for names in values(files, "LimitRTPRIO")], default=0)
    try:
        resource.setrlimit(resource.RLIMIT_RTPRIO, (limit, limit))  # inherited
    except ValueError:
        print("check_sandbox: the limit of real-time priorities cannot be raised here")
        sys.exit(77)
    check(os.path.abspath(program), os.path.abspath(tool), files)


if __name__ == "__main__":
    main()
