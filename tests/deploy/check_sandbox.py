#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs vdrived in what its systemd unit lets it do, as far as that can be had without systemd.

    tests/deploy/check_sandbox.py VDRIVED VDRIVE [DROP_IN]

The filter of system calls and address families is built from the unit itself, memory that can be
written and executed is refused, the system is read-only without homes, the user is nobody. The
service has to become ready, beat, answer the tool and end when it is told to. With a drop-in the
tick thread also has to get its real-time priority. Exit code 77: no sandbox can be made here.
"""

import os
import pathlib
import resource
import signal
import socket
import subprocess
import sys
import tempfile

import seccomp

UNIT = pathlib.Path(__file__).parents[2] / "deploy/systemd/vdrived.service"
DOMAIN = "229"
NOBODY = "65534"


def fail(text):
    sys.exit(f"check_sandbox: {text}")


def values(files, key):
    """The values of a setting, one for each line."""
    for file in files:
        for line in file.read_text().splitlines():
            if line.startswith(key + "="):
                yield line.split("=", 1)[1].split()


def expand(names):
    """System calls by name, groups such as @system-service resolved."""
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
    # systemd adds what it takes to get as far as main().
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
            pass  # of another machine or a newer kernel
    return rules


def sandbox(program, arguments, rules, state):
    """The command line that runs `program` in there, and the file that it needs."""
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


def child_of(process):
    """bwrap waits for what it runs, and passes no signal on."""
    return int(pathlib.Path(f"/proc/{process}/task/{process}/children").read_text().split()[0])


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
        command, compiled = sandbox(program, ["--domain", DOMAIN, "--config",
                                              "/tmp/state/bench.yaml"], make_filter(files), state)
        service = subprocess.Popen(command, env=environment, pass_fds=[compiled.fileno()],
                                   stderr=subprocess.PIPE, text=True)
        try:
            for line in ("READY=1", "WATCHDOG=1"):
                while line not in listener.recv(4096).decode().split("\n"):
                    pass
            answer = subprocess.run([tool, "--domain", DOMAIN, "--timeout", "10", "enable", "1.1"],
                                    capture_output=True, text=True)
            if answer.returncode != 0:
                fail("the tool found no service: " + answer.stderr)
            os.kill(child_of(service.pid), signal.SIGTERM)
            errors = service.communicate(timeout=5)[1]
        except (TimeoutError, subprocess.TimeoutExpired) as problem:
            service.kill()
            fail(f"{problem}: {service.communicate()[1]}")
    if service.returncode != 0:
        fail(f"exit code {service.returncode}: {errors}")
    if "not permitted" in errors or "warning" in errors:
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
        print("check_sandbox: nobody may raise the limit of real-time priorities here")
        sys.exit(77)
    check(os.path.abspath(program), os.path.abspath(tool), files)


if __name__ == "__main__":
    main()
