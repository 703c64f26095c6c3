#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A fleet of pods: the part of tests/fleet/run.sh that follows once images and pods exist.

  fleet.py --pods DIR --closed DIR --images DIR --client NETWORK_CLIENT --work DIR [--next VDRIVED]

This program takes the place of a cluster's controllers and kubelets for podman: it recreates
removed pods, one at a time where a budget demands it, and polls /readyz. It restarts nothing else.
At the end it prints the figures of the run, as the table of docs/explanation/scale.md.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import time
import urllib.error
import urllib.request

import yaml

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "network"))
import hosts  # noqa: E402

SERVER = "vdrive-discovery-0.vdrive-discovery:11811"
BENCHES = range(1, 7)
AXES = 500  # of a bench: patch.yaml
CONFIGURATION = pathlib.Path(__file__).resolve().parents[1] / "deploy/containers.conf"
PATIENCE = 60  # [s] of a wait; a machine of two processors is busy with six benches
GROUP = ("1.1", "2.1", "3.1")
OTHERS = ("4.1", "5.1", "6.1")


class Failed(AssertionError):
    """An expectation was not met."""


class Missing(Exception):
    """This machine cannot run pods; the text gives the reason."""


def expect(condition, text):
    if not condition:
        raise Failed(text)


class Podman:
    """Pods with their own network and storage."""

    NETWORK = "vdrive-fleet"

    def __init__(self, work):
        self.work = work
        self.files = {}
        os.environ["CONTAINERS_CONF"] = str(CONFIGURATION)
        self.command = ["podman", "--storage-driver", "vfs", "--root", str(work / "storage"),
                        "--runroot", str(work / "run"), "--network-config-dir", str(work / "networks")]

    def take(self, pods):
        """Uses the pods of a folder from now on."""
        self.files = {p.name.removesuffix(".yaml").split(".")[0]: p for p in pods.glob("*.yaml")}

    def call(self, *words, code=0):
        """Returns the output of the command. With `code` None, any exit code is accepted."""
        done = subprocess.run([*self.command, *map(str, words)], capture_output=True, text=True,
                              timeout=PATIENCE)
        # podman warns about a missing syslog.
        errors = "\n".join(x for x in done.stderr.splitlines() if "syslog" not in x)
        expect(code is None or done.returncode == code,
               f"podman {' '.join(map(str, words[:3]))}: exit code {done.returncode}: {errors}")
        return done.stdout + ("" if code == 0 else errors)

    def play(self, pod, change=None, code=0):
        """Starts a pod as a kubelet would. `change` may modify the pod."""
        documents = list(yaml.safe_load_all(self.files[pod].read_text()))
        for container in documents[-1]["spec"]["containers"]:
            container.pop("ports", None)  # those of this machine may be in use
        if change:
            change(documents[-1])
        name = documents[-1]["metadata"]["name"]
        path = self.work / f"{name}.yaml"
        path.write_text(yaml.safe_dump_all(documents))
        alias = name + self.files[pod].name.removesuffix(".yaml").removeprefix(pod)
        return self.call("kube", "play", "--network", f"{self.NETWORK}:alias={alias}", path,
                         code=code)

    def remove(self, pod):
        """Removes a pod as a controller would: SIGTERM, and SIGKILL after 5 s."""
        self.call("pod", "stop", "--time", 5, pod)
        self.call("pod", "rm", "--force", pod)

    def container(self, pod):
        return next(name for name in self.call("ps", "--all", "--filter", f"pod={pod}", "--format",
                                               "{{.Names}}").split() if not name.endswith("-infra"))

    def process(self, pod):
        return int(self.call("inspect", "--format", "{{.State.Pid}}", self.container(pod)))

    def address(self, pod):
        infra = self.call("pod", "inspect", "--format", "{{.InfraContainerID}}", pod).strip()
        return self.call("inspect", "--format",
                         "{{range .NetworkSettings.Networks}}{{.IPAddress}}{{end}}", infra).strip()

    def logs(self, pod):
        return self.call("logs", self.container(pod), code=None)

    def end(self):
        for words in (["pod", "rm", "--all", "--force", "--time", "0"],
                      ["rm", "--all", "--force", "--time", "0"],
                      ["network", "rm", "--force", self.NETWORK]):
            subprocess.run([*self.command, *words], capture_output=True)


def traffic(process):
    """Returns the bytes and packets that the pod of a process has sent and received, and the time.
    """
    for line in pathlib.Path(f"/proc/{process}/net/dev").read_text().splitlines():
        interface, _, counts = line.partition(":")
        if interface.strip() == "eth0":
            words = [int(word) for word in counts.split()]
            return words[8], words[9], words[0], words[1], time.monotonic()
    raise Failed(f"process {process} has no eth0")


class Master:
    """A program in its own pod that moves axes and prints each of its calls."""

    def __init__(self, podman, name, image, client, role, axes):
        self.axes = axes
        self.podman = podman
        self.name = name
        self.process = hosts.Process(
            [*podman.command, "run", "--name", name, "--network", podman.NETWORK, "--read-only",
             "--cap-drop", "all", "--log-driver", "none", "--volume", f"{client}:/usr/bin/client:ro",
             "--entrypoint", "/usr/bin/client", image, "--interface", "eth0", "--discovery-server",
             SERVER, role, *axes], podman.work / f"{name}.log")

    def lines(self, since=0.0):
        lines = (json.loads(x) for x in self.process.lines() if x.startswith("{"))
        return [x for x in lines if x["time"] >= since]

    def moves(self, since, axis=None):
        return [x for x in self.lines(since) if x.get("call") == "move" and x["outcome"] == "ok"
                and axis in (None, x["axis"])]

    def failures(self, since):
        """Calls that failed, except those of late(), which are due to a busy machine."""
        return [x for x in self.lines(since) if x.get("outcome", "ok") not in ("ok", *self.LATE)]

    LATE = ("refused", "timed_out")

    def late(self):
        return [x for x in self.lines() if x.get("outcome") in self.LATE]

    def wait_for_moves(self, since, axes, count=2):
        def have_moved():
            return all(len(self.moves(since, axis)) >= count for axis in axes)
        hosts.wait_for(f"motion of {', '.join(axes)}", have_moved, PATIENCE)
        return max(self.moves(since, axis)[0]["time"] for axis in axes)

    def end(self):
        self.podman.call("stop", "--time", 5, self.name, code=None)


class Fleet:
    def __init__(self, arguments):
        self.work = arguments.work
        self.podman = Podman(arguments.work)
        self.podman.take(arguments.pods)
        self.closed = arguments.closed
        self.client = arguments.client
        self.figures = []
        self.version = self.load(arguments.images)
        self.next_version = self.make_next(arguments.next)

    def load(self, images):
        """Returns the version of the images."""
        files = [next(iter(images.glob(f"vdrive-{name}_*.tar")), None)
                 for name in ("bench", "discovery", "gateway")]
        expect(all(files), f"{images} lacks images of bench, discovery or gateway: deploy/image.sh")
        for file in files:
            self.podman.call("load", "--quiet", "--input", file)
        version = files[0].name.split("_")[1]
        try:
            self.podman.call("network", "create", self.podman.NETWORK)
            self.podman.call("run", "--rm", "--network", self.podman.NETWORK,
                             f"localhost/vdrive-bench:{version}", "--version")
        except Failed as error:
            raise Missing(f"podman runs no container here: {error}") from error
        return version

    def make_next(self, program):
        """Makes the image `next`, with another vdrived if there is one. Returns its version."""
        image = f"localhost/vdrive-bench:{self.version}"
        if not program:
            self.podman.call("tag", image, "localhost/vdrive-bench:next")
            return self.version
        container = self.podman.call("create", image).strip()
        self.podman.call("cp", program, f"{container}:/usr/bin/vdrived")
        self.podman.call("commit", "--quiet", container, "localhost/vdrive-bench:next")
        self.podman.call("rm", container)
        text = self.podman.call("run", "--rm", "localhost/vdrive-bench:next", "--version")
        return text.split()[1]

    def note(self, what, value):
        self.figures.append((what, value))
        print(f"{time.monotonic() - self.begin:6.1f} s  {what}: {value}", flush=True)

    def note_time(self, what, begin, end=None):
        self.note(what, f"{(end or time.monotonic()) - begin:.1f} s")

    def say(self, text):
        print(f"{time.monotonic() - self.begin:6.1f} s  {text}", flush=True)

    # ---- actions of a person or a kubelet --------------------------------------------------------

    def tool(self, *words, code=0, server=SERVER):
        """Runs the tool in the pod of the gateway. Returns its output."""
        return self.podman.call("exec", self.podman.container("vdrive-gateway"), "/usr/bin/vdrive",
                                "--interface", "eth0", "--discovery-server", server, *words, code=code)

    def listed(self):
        """Returns the numbers of the axes of each bench."""
        axes = {}
        for line in self.tool("--json", "list", code=None).splitlines():
            entry = json.loads(line) if line.startswith("{") else {}
            if "axis" in entry:
                axes.setdefault(entry["bench"], []).append(entry["axis"])
        return axes

    def all_listed(self):
        counts = {bench: len(axes) for bench, axes in self.listed().items()}
        return counts == dict.fromkeys(BENCHES, AXES)

    def wait_for_all(self):
        hosts.wait_for("list of all axes", self.all_listed, PATIENCE)

    def probe(self, pod, path="readyz", port=9464):
        try:
            url = f"http://{self.podman.address(pod)}:{port}/{path}"
            with urllib.request.urlopen(url, timeout=2) as answer:
                return answer.status, answer.read().decode()
        except urllib.error.HTTPError as error:
            return error.code, error.read().decode()
        except OSError as error:
            return 0, str(error)

    def wait_ready(self, pod, path="readyz", port=9464):
        hosts.wait_for(f"ready {pod}", lambda: self.probe(pod, path, port)[0] == 200, PATIENCE)

    # ---- actions of controllers ------------------------------------------------------------------

    def image(self, tag):
        def change(pod):
            pod["spec"]["containers"][0]["image"] = f"localhost/vdrive-bench:{tag}"
        return change

    def other(self, name, number, *words):
        """Starts an additional pod, with a bench number and further arguments."""
        def change(pod):
            pod["metadata"]["name"] = name
            pod["metadata"]["labels"]["apps.kubernetes.io/pod-index"] = str(number)
            container = pod["spec"]["containers"][0]
            container["image"] = f"localhost/vdrive-bench:{self.version}"
            container["args"] += words
        self.podman.play("vdrive-bench-6", change)

    def remove_other(self, name):
        self.podman.call("pod", "rm", "--force", "--time", 2, name)

    def play_bench(self, number, tag=None):
        self.podman.play(f"vdrive-bench-{number}", self.image(tag or self.version))

    def replace(self, number, tag):
        """Removes a bench and makes its pod again, like an eviction or an upgrade. Returns the
        time until it is ready [s]."""
        pod = f"vdrive-bench-{number}"
        before = self.podman.address(pod)
        begin = time.monotonic()
        self.podman.remove(pod)
        self.play_bench(number, tag)
        self.wait_ready(pod)
        expect(self.podman.address(pod) != before, f"{pod} has its former address")
        return time.monotonic() - begin

    # ---- the sequence of the test ----------------------------------------------------------------

    def run(self):
        self.begin = time.monotonic()
        self.start()
        self.measure_traffic("without masters")
        self.start_masters()
        self.measure_traffic("with two masters")
        self.kill_in_motion()
        self.roll()
        self.lose_server()
        self.drain()
        self.lose_node()
        for master, what in ((self.group, "lines of the group"),
                             (self.cycle, "moves of the other master")):
            self.note(f"{what}: made, and given again because the machine was late",
                      f"{len(master.moves(0))}, {len(master.late())}")
        for master in (self.group, self.cycle, self.observer):
            master.end()
        self.bad_input()
        self.run_closed()
        print("\n| what | value |\n| --- | --- |")
        for what, value in self.figures:
            print(f"| {what} | {value} |")

    def start(self):
        self.say("discovery server, six benches and a gateway")
        begin = time.monotonic()
        for pod in sorted(self.podman.files):
            self.podman.play(pod)
        played = time.monotonic()
        for number in BENCHES:
            self.wait_ready(f"vdrive-bench-{number}")
        ready = time.monotonic()
        self.wait_for_all()
        self.note("`kube play` of eight pods, one after the other", f"{played - begin:.1f} s")
        self.note("from the first `kube play` to six ready benches", f"{ready - begin:.1f} s")
        self.note_time("from the first `kube play` to all 3,000 axes listed", begin)
        for number in BENCHES:
            status, text = self.probe(f"vdrive-bench-{number}", "livez")
            expect((status, text) == (200, f"bench {number} is alive\n"), text)
        self.wait_ready("vdrive-gateway", "", 8765)

    def measure_traffic(self, when):
        pods = [f"vdrive-bench-{number}" for number in BENCHES]
        pods += ["vdrive-gateway", "vdrive-discovery-0"]
        processes = {pod: self.podman.process(pod) for pod in pods}
        before = {pod: traffic(processes[pod]) for pod in pods}
        time.sleep(10)  # the period over which traffic is measured
        rates = {}
        for pod in pods:
            now = traffic(processes[pod])
            *counts, seconds = (after - then for after, then in zip(now, before[pod]))
            rates[pod] = [count / seconds for count in counts]
        benches = [sum(column) / len(BENCHES) for column in
                   zip(*(rates[f"vdrive-bench-{number}"] for number in BENCHES))]
        for name, rate in (("a bench", benches), ("the gateway", rates["vdrive-gateway"]),
                           ("the discovery server", rates["vdrive-discovery-0"])):
            self.note(f"traffic of {name}, {when}",
                      f"sends {rate[0] / 1000:.1f} kB/s in {rate[1]:.0f} packets, "
                      f"receives {rate[2] / 1000:.1f} kB/s in {rate[3]:.0f}")

    def start_masters(self):
        image = f"localhost/vdrive-bench:{self.version}"
        begin = time.monotonic()
        self.observer = Master(self.podman, "observer", image, self.client, "observe", GROUP)
        self.group = Master(self.podman, "group", image, self.client, "group", GROUP)
        self.cycle = Master(self.podman, "cycle", image, self.client, "cycle", OTHERS)
        self.group.wait_for_moves(begin, ["group"])
        self.cycle.wait_for_moves(begin, OTHERS)
        self.say("a master moves a group over benches 1 to 3, another one axes of 4 to 6")

    def observed(self, since=0.0):
        return [line for line in self.observer.lines(since) if "axis" in line]

    def came_to_rest(self, axis, begin, end):
        """When the axis last stopped between two instants; `begin` if it was at rest."""
        rest, moving = begin, False
        for line in self.observed():
            if line["axis"] == axis and line["time"] <= end:
                if moving and not line["moving"]:
                    rest = max(begin, line["time"])
                moving = line["moving"]
        expect(not moving, f"{axis} moves when the call of its group has ended")
        return rest

    def expect_no_unowned_motion(self, since):
        for line in self.observed(since):
            expect(not line.get("moving") or line["owner"] != 0, f"an axis moves unowned: {line}")

    def kill_in_motion(self):
        """Kills bench 2 with SIGKILL while the group moves. Its pod restarts it, as a kubelet
        would."""
        process = self.podman.process("vdrive-bench-2")

        def moves_now():
            """A motion takes 0.3 s."""
            last = [x for x in self.observed() if x["axis"] == "2.1"][-1:]
            return last and last[0]["moving"] and time.monotonic() - last[0]["time"] < 0.1
        hosts.wait_for("motion of 2.1", moves_now, PATIENCE)
        begin = time.monotonic()
        os.kill(process, 9)
        failure = hosts.wait_for("failure of the group", lambda: self.group.failures(begin),
                                 PATIENCE)[0]
        self.note("a bench is killed: the group's call has ended",
                  f"{failure['time'] - begin:.1f} s, `{failure['outcome']}`, \"{failure['message']}\"")
        rest = max(self.came_to_rest(axis, begin, failure["time"]) for axis in ("1.1", "3.1"))
        self.note_time("the same: the axes of the other benches at rest", begin, rest)
        again = self.group.wait_for_moves(failure["time"], ["group"])
        self.note_time("the same: the group moves again, the bench under its number", begin, again)
        self.wait_for_all()
        self.expect_unharmed(self.cycle, begin)
        self.expect_no_unowned_motion(begin)
        faults = [x for x in self.observed(begin) if x["error"] and x["axis"] != "2.1"]
        expect(not faults, f"axes of other benches have faults: {faults}")

    def expect_unharmed(self, master, since):
        lost = master.failures(since)
        expect(not lost, f"{master.name} lost what it had: {lost[:2]}")
        late, made = len(master.late()), len(master.moves(0))
        expect(late <= made, f"{master.name}: {late} calls too late and {made} moves: it does not get on")

    def wait_for_masters(self, since):
        self.group.wait_for_moves(since, ["group"])
        self.cycle.wait_for_moves(since, OTHERS)

    def roll(self):
        self.say("all benches to another image, one by one, from the highest number on")
        begin = time.monotonic()
        times = []
        for numbers, working in (((6, 5, 4), self.group), ((3, 2, 1), self.cycle)):
            self.expect_versions({number: self.version for number in numbers})
            start = time.monotonic()
            times += [self.replace(number, "next") for number in numbers]
            self.expect_versions({number: self.next_version for number in numbers})
            self.expect_unharmed(working, start)
            expect(working.moves(start), "the master of the others stood still")
            self.wait_for_masters(time.monotonic())
        self.note("an upgrade, bench by bench: the longest, all six", f"{max(times):.1f} s, "
                  f"{time.monotonic() - begin:.1f} s")
        self.wait_for_all()
        self.expect_no_unowned_motion(begin)

    def expect_versions(self, versions):
        """Waits until `list` names the pod and the version of each bench."""
        def are_listed():
            lines = self.tool("list", code=None).splitlines()
            return all(any(line.startswith(f"bench {number} ") and
                           line.endswith(f"on vdrive-bench-{number}, version {version}")
                           for line in lines) for number, version in versions.items())
        hosts.wait_for(f"list with the versions {versions}", are_listed, PATIENCE)

    def lose_server(self):
        """Participants that have found each other continue; a bench that starts without the server is
        found when it is back."""
        before = self.podman.address("vdrive-discovery-0")
        begin = time.monotonic()
        os.kill(self.podman.process("vdrive-discovery-0"), 9)
        self.podman.call("pod", "rm", "--force", "--time", 0, "vdrive-discovery-0")
        self.say("the discovery server is gone")
        self.other("vdrive-bench-7", 7)
        self.wait_ready("vdrive-bench-7")
        self.wait_for_masters(begin + 25)  # longer than any lease
        for command in ("list", "doctor"):
            self.expect_line("vdrive-discovery-0.vdrive-discovery", self.tool(command, code=None),
                             f"{command} without a server")
        self.expect_log("vdrive-bench-7", "no discovery server answers", "a bench without a server")
        back = time.monotonic()
        self.podman.play("vdrive-discovery-0")
        expect(self.podman.address("vdrive-discovery-0") != before,
               "the server has its former address")
        hosts.wait_for("list of all seven benches", lambda: len(self.listed()) == 7, PATIENCE)
        self.note_time("the discovery server is back with another address: all benches listed, also "
                       "one that started without it", back)
        self.remove_other("vdrive-bench-7")
        self.wait_for_all()
        for master in (self.group, self.cycle):
            self.expect_unharmed(master, begin)
            self.say(f"{master.name} has made {len(master.moves(begin))} moves meanwhile")

    def drain(self):
        self.say("half of the benches to another node, one by one, as their disruption budget says")
        begin = time.monotonic()
        for number in (6, 5, 4):
            self.replace(number, "next")
        self.note_time("a node with three benches is drained: all ready elsewhere", begin)
        self.note_time("the same: their master moves all again", begin,
                       self.cycle.wait_for_moves(time.monotonic(), OTHERS))
        self.expect_unharmed(self.group, begin)
        self.wait_for_all()

    def lose_node(self):
        self.say("three benches are killed at once, and made again")
        begin = time.monotonic()
        for number in (4, 5, 6):
            os.kill(self.podman.process(f"vdrive-bench-{number}"), 9)
            self.podman.call("pod", "rm", "--force", "--time", 0, f"vdrive-bench-{number}")
        for number in (4, 5, 6):
            self.play_bench(number, "next")
        self.note_time("a node with three benches is lost: their master moves all again", begin,
                       self.cycle.wait_for_moves(time.monotonic(), OTHERS))
        self.expect_unharmed(self.group, begin)
        self.wait_for_all()

    # ---- mistakes --------------------------------------------------------------------------------

    def expect_line(self, expected, text, what):
        line = next((x for x in text.splitlines() if expected in x), None)
        expect(line, f"{what}: no line has '{expected}': {text[-2000:]}")
        self.say(f"{what}: {line.strip()}")

    def expect_log(self, pod, expected, what):
        hosts.wait_for(f"'{expected}' in the log of {pod}",
                       lambda: expected in self.podman.logs(pod), PATIENCE)
        self.expect_line(expected, self.podman.logs(pod), what)

    def bad_input(self):
        self.other("twin", 3)
        self.expect_log("twin", "bench 3 is already served", "two pods with one number")
        self.wait_for_all()
        self.remove_other("twin")
        found = self.tool("doctor", code=None, server="nowhere.vdrive-discovery:11811")
        self.expect_line("nowhere.vdrive-discovery", found, "a name that does not resolve, by doctor")


    def run_closed(self):
        """The overlay of closed mode: peers by name, certificates in Secrets."""
        self.podman.end()
        self.podman.take(self.closed)
        self.say("two benches and the gateway of the closed mode")
        self.podman.call("network", "create", self.podman.NETWORK)
        for pod in ("vdrive-bench-1", "vdrive-bench-2", "vdrive-gateway"):
            self.podman.play(pod)
        words = ["exec", self.podman.container("vdrive-gateway"), "/usr/bin/vdrive", "--interface",
                 "eth0", "--peer", "vdrive-bench-1.vdrive-bench", "--peer",
                 "vdrive-bench-2.vdrive-bench", "--security", "/etc/vdrive-security", "list"]

        def both_listed():
            text = self.podman.call(*words, code=None)
            return "on vdrive-bench-1," in text and "on vdrive-bench-2," in text
        hosts.wait_for("list of both benches", both_listed, PATIENCE)

        def forget_files(pod):
            pod["metadata"]["name"] = "vdrive-bench-3"
            for volume in pod["spec"]["volumes"]:
                if "security" in volume["name"]:
                    volume["emptyDir"] = {}
                    del volume["configMap"]
        self.podman.play("vdrive-bench-3", forget_files)
        self.expect_log("vdrive-bench-3", "identity_ca.pem: cannot be read",
                        "a Secret without its files")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--keep", action="store_true", help="leave the pods of a failure")
    parser.add_argument("--next", type=pathlib.Path)
    for option in ("--pods", "--closed", "--images", "--client", "--work"):
        parser.add_argument(option, type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    try:
        fleet = Fleet(arguments)
    except Missing as reason:
        print(f"fleet: {reason}", file=sys.stderr)
        sys.exit(77)
    except Failed as error:
        sys.exit(f"fleet: {error}")
    try:
        fleet.run()
    except (Failed, hosts.Late) as error:
        print(f"fleet: {error}", file=sys.stderr)
        if arguments.keep:
            print(f"fleet: CONTAINERS_CONF={os.environ['CONTAINERS_CONF']}",
                  *fleet.podman.command, "ps", file=sys.stderr)
            sys.exit(1)
        fleet.podman.end()
        sys.exit(1)
    fleet.podman.end()


if __name__ == "__main__":
    main()
