#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Programs of one build with those of another: services, clients, files, over DDS on loopback.

  across.py --a BUILD --b BUILD [--root-b ROOT] [--only TEXT]

BUILD is a build directory, such as build/quick, with the programs of the target across_tests. With --root-b the
second one is a path inside of ROOT, the root of another system: its programs run there by chroot, which needs
root. Each check runs with the service of a and the client of b, and the other way round; the manual's examples
also run with both of b. Standard output has a line for each: result, check, seconds. Exit code 0: all passed; 1: some
failed, and standard error has why; 2: a program is missing, or an argument is wrong.
"""
import argparse
import contextlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

TREE = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(TREE / "tests/support"))
from test_domain import claim_domain  # noqa: E402

SCENARIOS = ("absolute_forward_timing.scn", "absolute_negative_timing.scn")
PROGRAMS = ("bin/vdrived", "bin/vdrive", "bin/vdrive-ros2", "examples/03_two_services_one_group",
            "tests/vendor/vendor_client", "tests/vendor/raw_dds/raw_dds", "tests/ros2/ros2_plugin")
TURNS = 5  # attempts until a loaded machine has kept up with real time
PATIENCE_S = 60  # for a program that ends by itself, on a loaded machine
CYCLONE_ON_LOOPBACK = ("<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo' multicast='true'/>"
                       "</Interfaces></General><Discovery><LeaseDuration>2s</LeaseDuration></Discovery>"
                       "</Domain></CycloneDDS>")


class Failure(Exception):
    """Why a check failed."""


class Side:
    """The programs of one build; they may live in the root of another system."""

    def __init__(self, name, build, root, domain):
        self.name, self.build, self.root, self.domain = name, build, root, domain

    def path(self, file):
        """The path of a file of this system for the programs of this side."""
        return str(file) if self.root is None else "/" + str(pathlib.Path(file).relative_to(self.root))

    def missing(self):
        return [program for program in PROGRAMS
                if not os.access(pathlib.Path(self.root or "/", self.build.lstrip("/"), program), os.X_OK)]

    def command(self, program, words):
        found = [f"{self.build}/{program}", *map(str, words)]
        return found if self.root is None else ["chroot", str(self.root), *found]

    def environment(self, **more):
        return {"PATH": os.environ["PATH"], "HOME": "/root", "LANG": "C.UTF-8", "VDRIVE_DOMAIN": str(self.domain),
                **more}

    def run(self, program, *words, code=0, **environment):
        """Run a program to its end; return its standard output."""
        try:
            done = subprocess.run(self.command(program, words), env=self.environment(**environment), text=True,
                                  capture_output=True, timeout=PATIENCE_S, cwd="/", check=False)
        except subprocess.TimeoutExpired as late:
            raise Failure(f"{program} of {self.name} {words} did not end within {PATIENCE_S} s") from late
        if done.returncode != code:
            raise Failure(f"{program} of {self.name} {words} ended with {done.returncode}, not {code}:\n"
                          f"{done.stdout[-2000:]}{done.stderr[-2000:]}")
        return done.stdout if code == 0 else done.stderr

    def tool(self, *words, **options):
        return self.run("bin/vdrive", "--timeout", "20", *words, **options)

    def library(self):
        """The version of its DDS library."""
        return self.run("bin/vdrive", "--version").split("Fast DDS ")[1].rstrip(")\n")

    def read(self, axis, item):
        return json.loads(self.tool("--json", "read", axis, item))["value"]

    @contextlib.contextmanager
    def running(self, program, *words):
        """A program that ends by SIGTERM, with exit code 0, or is killed after a failure."""
        with tempfile.TemporaryFile("w+") as log:
            with subprocess.Popen(self.command(program, words), env=self.environment(), stdout=log, stderr=log,
                                  cwd="/") as process:
                try:
                    yield process
                    process.terminate()
                    code = process.wait(PATIENCE_S)
                    log.seek(0)
                    if code != 0:
                        raise Failure(f"{program} of {self.name} {words} ended with {code}:\n{log.read()[-2000:]}")
                except subprocess.TimeoutExpired as late:
                    raise Failure(f"{program} of {self.name} did not end after SIGTERM") from late
                finally:
                    process.kill()

    def service(self, *words):
        return self.running("bin/vdrived", "--log-level", "warn", *words)


def examples(service, client, work):
    for scenario in SCENARIOS:
        shutil.copy(TREE / "clients/scenarios" / scenario, work)
    with service.service("--clock", "lockstep"):
        for scenario in SCENARIOS:
            client.tool("run", client.path(work / scenario))


def group(service, client, _work):
    with service.service("--axes", "1", "--bench", "1"), client.service("--axes", "1", "--bench", "2"):
        for side in (service, client):
            for turn in range(TURNS):
                side.tool("status", "1.1", "2.1")  # waits until both are found
                try:
                    output = side.run("examples/03_two_services_one_group", side.domain)
                    break
                except Failure as failure:  # in real time a loaded machine may be late with a frame
                    if "too late" not in str(failure) or turn == TURNS - 1:
                        raise
            if "both sides at 1000" not in output:
                raise Failure(f"the group of {side.name} did not arrive:\n{output}")


def expect(what, seen, wanted):
    if seen != wanted:
        raise Failure(f"{what} is {seen}, not {wanted}")


def stores(service, client, work):
    """One version stores; the other one reads the same directory, then removes what was stored."""
    state = work / "state"
    state.mkdir()
    velocity = "profile_velocity"
    with service.service("--state", service.path(state)):
        default = client.read("1.1", velocity)
        client.tool("write", "1.1", velocity, default + 77)
        client.tool("store", "1.1")
    with client.service("--state", client.path(state)):
        expect(f"{velocity} after a restart by {client.name}", service.read("1.1", velocity), default + 77)
        service.tool("restore", "1.1")
    with service.service("--state", service.path(state)):
        expect(f"{velocity} after its removal by {client.name}", client.read("1.1", velocity), default)


def journals(service, client, work):
    """The replay compares a hash of every tick: the same bits in both versions."""
    journal = work / "run.journal"
    shutil.copy(TREE / "clients/scenarios" / SCENARIOS[0], work)
    with service.service("--clock", "lockstep", "--journal", service.path(journal)):
        client.tool("run", client.path(work / SCENARIOS[0]))
    text = client.run("bin/vdrived", "--replay", client.path(journal))
    if "all checks agree" not in text and "every hash agrees" not in text:  # the latter in older versions
        raise Failure(f"the replay says: {text}")


def closed(service, client, work):
    authority = work / "authority"
    scripts = TREE / "deploy/security"
    subprocess.run([scripts / "make_authority.sh", authority], check=True, capture_output=True)
    for role, name in (("service", "bench"), ("controller", "operator"), ("viewer", "guest")):
        subprocess.run([scripts / "make_member.sh", authority, role, name], check=True, capture_output=True)
    members = authority / "members"
    with service.service("--clock", "lockstep", "--security", service.path(members / "bench")):
        as_operator = ("--security", client.path(members / "operator"))
        if service.library()[0] != client.library()[0]:
            # Fast DDS 3 does not admit participants of version 2 (docs/SECURITY.md).
            text = client.run("bin/vdrive", "--timeout", "3", *as_operator, "status", "1.1", code=3)
            if f"closed, by Fast DDS {client.library()}" not in text:
                raise Failure(f"the tool does not tell its version: {text}")
            return
        client.tool(*as_operator, "enable", "1.1")
        client.tool(*as_operator, "move", "1.1", "10000", "--velocity", "20000")
        as_guest = ("--security", client.path(members / "guest"))
        seen = json.loads(client.tool("--json", *as_guest, "status", "1.1"))
        expect("the position that a viewer sees", seen["load_position_actual_value"], 10000)
        client.tool(*as_guest, "disable", "1.1", code=5)
        client.run("bin/vdrive", "--timeout", "3", "status", "1.1", code=3)  # without credentials: not found


def ros2(service, client, _work):
    """The bridge of the client's version, the bench of the service's, and a Cyclone DDS of each version."""
    with service.service("--axes", "2"), client.running("bin/vdrive-ros2", "--enable"):
        for axis in ("1.1", "1.2"):
            client.tool("wait", axis, "operation_enabled")
        names = [json.loads(line)["name"] for line in client.tool("--json", "list").splitlines()]
        service.run("tests/ros2/ros2_plugin", service.domain, *names, CYCLONEDDS_URI=CYCLONE_ON_LOOPBACK)


def cyclone(service, client, _work):
    """Cyclone DDS of the client's system: the manual's forward example without our library, twice."""
    with service.service("--clock", "lockstep"):
        client.tool("status", "1.2")  # waits until it is found
        text = client.run("tests/vendor/vendor_client", client.domain, 1, 2, CYCLONEDDS_URI=CYCLONE_ON_LOOPBACK)
        if "9 arrived: 6041h = 0x1637, 6062h = 10000, 6064h = 10000" not in text:
            raise Failure(f"the client of Cyclone DDS says:\n{text}")
    with service.service():
        client.tool("status", "1.1")
        text = client.run("tests/vendor/raw_dds/raw_dds", client.domain)
        if "position 10000" not in text:
            raise Failure(f"example 06 says:\n{text}")


CHECKS = (
    ("the manual's examples in lock-step, each tick", examples),
    ("a group over one bench of each", group),
    ("a store, read and removed by the other one", stores),
    ("a journal, replayed by the other one", journals),
    ("the closed mode", closed),
    ("joints of ROS 2", ros2),
    ("a client on Cyclone DDS", cyclone),
)


def parsed():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--a", required=True, metavar="BUILD", help="build directory of this system")
    parser.add_argument("--b", required=True, metavar="BUILD", help="build directory, inside of ROOT if there is one")
    parser.add_argument("--root-b", type=pathlib.Path, metavar="ROOT", help="root of another system")
    parser.add_argument("--only", default="", metavar="TEXT", help="only checks that have it in their names")
    arguments = parser.parse_args()
    if arguments.root_b is not None:
        if os.geteuid() != 0:
            parser.error(f"--root-b {arguments.root_b}: chroot needs root")
        if not (arguments.root_b / "usr").is_dir():
            parser.error(f"--root-b {arguments.root_b}: no root of a system")
        if not (arguments.root_b / "proc/self").exists():
            parser.error(f"--root-b {arguments.root_b}: has no /proc, which the service needs; mount it")
        arguments.root_b = arguments.root_b.resolve()
    if not any(arguments.only in name for name, _ in CHECKS):
        parser.error(f"--only '{arguments.only}': no check has it in its name")
    return arguments


def main():
    arguments = parsed()
    domain, kept = claim_domain()
    root = arguments.root_b
    sides = (Side("a", str(pathlib.Path(arguments.a).resolve()), None, domain),
             Side("b", arguments.b if root else str(pathlib.Path(arguments.b).resolve()), root, domain))
    for side in sides:
        for program in side.missing():
            print(f"across: {side.name} has no program {side.build}/{program}; build the target across_tests",
                  file=sys.stderr)
    if any(side.missing() for side in sides):
        return 2
    failed = 0
    # Files of both sides are in the root of b, which is visible to a.
    with kept, tempfile.TemporaryDirectory(prefix="across-", dir=root and root / "tmp") as folder:
        for number, (name, check) in enumerate(CHECKS):
            pairs = [sides, sides[::-1]]
            if check is examples:
                pairs.append(sides[1:] * 2)  # b with itself, which no other test here runs
            for service, client in pairs:
                if arguments.only not in name:
                    continue
                work = pathlib.Path(folder, f"{number}{service.name}{client.name}")
                work.mkdir()
                begin = time.monotonic()
                try:
                    check(service, client, work)
                    result = "passed"
                except (Failure, subprocess.SubprocessError, OSError) as reason:
                    failed += 1
                    result = "FAILED"
                    print(f"across: {name}, service of {service.name}: {reason}", file=sys.stderr)
                print(f"{result}  {name}: service of {service.name}, client of {client.name}, "
                      f"{time.monotonic() - begin:.1f} s", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
