# SPDX-License-Identifier: Apache-2.0
"""Hosts on one network, as network namespaces that a switch connects."""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

PREFIX = "vdrive"
NET = "10.77.0"


class Missing(Exception):
    """This machine cannot create hosts; the text gives the reason."""


class Late(AssertionError):
    """A wait that timed out, or something that took too long. tests/checks/failures.py
    distinguishes it from a wrong value."""


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()}")
    return done.stdout


def real_time():
    """A command prefix that gives a program real-time priority; empty where that is not permitted.
    A real host has its own processors. Here it shares two with other tests, whose programs of
    normal priority make a thread of the host wait for 50 ms or more."""
    words = ["chrt", "--rr", "1"]
    try:
        permitted = subprocess.run([*words, "true"], capture_output=True).returncode == 0
    except FileNotFoundError:
        permitted = False
    return words if permitted else []


def wait_for(what, condition, timeout):
    """Waits until `condition` returns a true value, and returns it."""
    deadline = time.monotonic() + timeout
    while True:
        found = condition()
        if found:
            return found
        if time.monotonic() > deadline:
            raise Late(f"after {timeout:.1f} s still no {what}")
        time.sleep(0.01)


class Process:
    """A running program; its output goes to a file that lines() reads."""

    def __init__(self, command, output, stdin=None):
        self.output = pathlib.Path(output)
        self.name = self.output.stem
        with open(output, "w", encoding="utf-8") as file:
            self.child = subprocess.Popen(
                command, stdin=stdin or subprocess.DEVNULL, stdout=file, stderr=subprocess.STDOUT,
                start_new_session=True)

    def lines(self):
        text = self.output.read_text(encoding="utf-8", errors="replace")
        return text[: text.rfind("\n") + 1].splitlines()

    def is_running(self):
        return self.child.poll() is None

    def stop(self, patience=5):
        """Ends the program with SIGTERM. Returns its exit code."""
        if self.is_running():
            self.child.send_signal(signal.SIGTERM)
        return self.child.wait(patience)

    def kill(self):
        if self.is_running():
            os.killpg(self.child.pid, signal.SIGKILL)
            self.child.wait()


class Host:
    """A namespace with loopback, one interface `net` and its own firewall rules."""

    def __init__(self, network, letter, number):
        self.network = network
        self.letter = letter
        self.namespace = network.name(letter)
        self.address = f"{NET}.{number}"
        self.port = f"port-{letter}"  # of the switch, where the cable ends
        run("ip", "netns", "add", self.namespace)
        run("ip", "link", "add", "net", "netns", self.namespace, "type", "veth",
            "peer", "name", self.port, "netns", network.switch)
        self.ip("address", "add", f"{self.address}/24", "dev", "net")
        self.ip("link", "set", "lo", "up")
        self.ip("link", "set", "net", "up")
        run("ip", "-n", network.switch, "link", "set", self.port, "master", "bridge", "up")

    def ip(self, *arguments):
        return run("ip", "-n", self.namespace, *arguments)

    def command(self, *command):
        # Each program has a private /dev/shm, so shared memory does not extend beyond the host.
        mount = "mount -t tmpfs tmpfs /dev/shm && "
        if self.network.resolver:
            mount += f"mount --bind {self.network.resolver} /etc/resolv.conf && "
        mount += 'exec "$@"'
        return ["ip", "netns", "exec", self.namespace, "sh", "-c", mount, "sh", *map(str, command)]

    def start(self, name, *command, stdin=None):
        output = self.network.directory / f"{name}.log"
        process = Process([*self.network.real_time, *self.command(*command)], output, stdin)
        self.network.processes.append(process)
        return process

    def call(self, *command, timeout=30):
        """Runs a program until it ends."""
        return subprocess.run(self.command(*command), capture_output=True, text=True,
                              timeout=timeout)

    def serve_names(self):
        """Starts a name server for all programs started from now on: see Network.names()."""
        self.network.names({})
        resolver = self.network.directory / "resolv.conf"
        resolver.write_text(f"nameserver {self.address}\noptions timeout:1 attempts:2\n",
                            encoding="utf-8")
        server = self.start("names", sys.executable, "-B",
                            pathlib.Path(__file__).with_name("name_server.py"), self.address,
                            self.network.directory / "names.json")
        wait_for("name server", server.lines, 10)
        self.network.resolver = resolver

    def unplug(self):
        """Unplugs the cable from the switch: this host loses its carrier."""
        run("ip", "-n", self.network.switch, "link", "set", self.port, "down")

    def plug(self):
        run("ip", "-n", self.network.switch, "link", "set", self.port, "up")

    def block_for(self, seconds):
        """Makes the switch block all traffic of this host; its carrier stays. A host that loses
        its carrier also forgets its neighbours' addresses, and requests them once a second."""
        state = f"bridge -n {self.network.switch} link set dev {self.port} state"
        run("sh", "-c", f"{state} 0 && sleep {seconds}; {state} 3")

    def lose(self, percent):
        """Makes the switch drop this share of the frames from and to this host."""
        lost = f"numgen random mod 100 < {percent} drop"
        self.network.load_rules(self.network.switch, "bridge", [] if percent == 0 else [
            f"chain forward {{ type filter hook forward priority 0",
            f"iifname {self.port} {lost}",
            f"oifname {self.port} {lost}",
            "}"])

    def block_multicast(self):
        self.network.load_rules(self.namespace, "inet", [
            "chain input { type filter hook input priority 0",
            "iifname net ip daddr 224.0.0.0/4 drop",
            "}"])


class Network:
    """Hosts a, b, c, ... at 10.77.0.1, .2, .3, ...; everything ends with the object.

    The names of the namespaces contain the number of this process, so several networks can
    coexist."""

    def __init__(self, directory, hosts=3):
        self.directory = pathlib.Path(directory)
        self.processes = []
        self.namespaces = []
        self.hosts = {}
        self.count = hosts
        self.real_time = real_time()
        self.resolver = None  # the resolv.conf of all hosts

    def name(self, what):
        name = f"{PREFIX}-{os.getpid()}-{what}"
        self.namespaces.append(name)
        return name

    def __enter__(self):
        check_rights()
        remove_leftovers()
        try:
            self.switch = self.name("switch")
            run("ip", "netns", "add", self.switch)
            run("ip", "-n", self.switch, "link", "add", "bridge", "type", "bridge",
                "mcast_snooping", "0")
            run("ip", "-n", self.switch, "link", "set", "bridge", "up")
            for number, letter in enumerate("abcdefgh"[: self.count], start=1):
                self.hosts[letter] = Host(self, letter, number)
        except BaseException:
            self.close()
            raise
        return self

    def names(self, names):
        """Sets the answers of the name server: names and lists of addresses."""
        file = self.directory / "names.json"
        file.with_suffix(".new").write_text(json.dumps(names), encoding="utf-8")
        file.with_suffix(".new").replace(file)

    def __getitem__(self, letter):
        return self.hosts[letter]

    def __exit__(self, *_):
        self.close()

    def load_rules(self, namespace, family, chains):
        """Replaces the firewall of a namespace; without chains, everything passes."""
        table = f"table {family} test"
        lines = [f"add {table}", f"delete {table}", f"{table} {{", *chains, "}"]
        script = self.directory / f"{namespace}.nft"
        script.write_text("\n".join(lines) + "\n", encoding="utf-8")
        run("ip", "netns", "exec", namespace, "nft", "--file", str(script))

    def close(self):
        for process in self.processes:
            process.kill()
        for namespace in self.namespaces:
            subprocess.run(["ip", "netns", "delete", namespace], capture_output=True)


def check_rights():
    """Raises Missing if this machine does not permit creating hosts."""
    if os.geteuid() != 0:
        raise Missing("needs root to make network namespaces")
    for tool, package in (("ip", "iproute2"), ("bridge", "iproute2"), ("nft", "nftables")):
        if shutil.which(tool) is None:
            raise Missing(f"needs {tool} (package {package})")
    probe = f"{PREFIX}-{os.getpid()}-probe"
    try:
        run("ip", "netns", "add", probe)
        run("ip", "netns", "exec", probe, "mount", "-t", "tmpfs", "tmpfs", "/dev/shm")
        run("ip", "netns", "exec", probe, "nft", "add", "table", "inet", "probe")
        run("ip", "-n", probe, "link", "add", "probe", "type", "bridge")
    except RuntimeError as error:
        raise Missing(f"network namespaces are not permitted here: {error}") from error
    finally:
        subprocess.run(["ip", "netns", "delete", probe], capture_output=True)


def remove_leftovers():
    """Deletes the namespaces of killed runs, whose processes are gone."""
    for line in run("ip", "netns", "list").splitlines():
        parts = line.split()[0].split("-")
        if len(parts) == 3 and parts[0] == PREFIX and not os.path.exists(f"/proc/{parts[1]}"):
            subprocess.run(["ip", "netns", "delete", line.split()[0]], capture_output=True)
