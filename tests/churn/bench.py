# SPDX-License-Identifier: Apache-2.0
"""A service under test, the resources of its processes, and the programs that use it."""

import contextlib
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import threading
import time
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import test_domain  # noqa: E402

WIRE_WORD = "--wire-process"
END_LIMIT = 2.0  # [s] from SIGTERM until no process of a bench is left
PATIENCE = 20.0  # [s] for an event that must happen
# A bench has priority over the programs that use it, as in its unit; where that is not permitted,
# `nice` reports it and continues.
BENCH_NICENESS = -10
VISITOR_NICENESS = 5
TICKS_PER_SECOND = 1000


class Failure(Exception):
    """The reason why a run failed, as a sentence."""


def is_nightly():
    return bool(os.environ.get("VDRIVE_NIGHTLY"))


def now():
    return time.monotonic()


@contextlib.contextmanager
def claimed_domain():
    """A DDS domain that no other test on this machine uses."""
    domain, claim = test_domain.claim_domain()
    with claim:
        yield domain


def percentile(values, part):
    """The value that a fraction `part` (0 to 1) of the values does not exceed."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(part * len(ordered)))] if ordered else 0.0


def wait_for(what, condition, patience=PATIENCE):
    """Waits until condition() is true. Fails after `patience` seconds."""
    deadline = now() + patience
    while True:
        result = condition()
        if result:
            return result
        if now() > deadline:
            raise Failure(f"{what} did not come within {patience:g} s")
        time.sleep(0.02)


def command_line(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/cmdline").read_bytes().decode(errors="replace").split("\0")
    except OSError:
        return []


def descendants(pid):
    """The process ids of all children of `pid` and of their children."""
    parents = {}
    for entry in os.listdir("/proc"):
        if not entry.isdigit():
            continue
        try:
            text = pathlib.Path(f"/proc/{entry}/stat").read_text(encoding="utf-8")
        except OSError:
            continue
        parents[int(entry)] = int(text.rpartition(")")[2].split()[1])
    found = []
    generation = [pid]
    while generation:
        generation = [child for child, parent in parents.items() if parent in generation]
        found += generation
    return found


def is_running(pid):
    """A zombie has ended: only its exit code remains."""
    try:
        text = pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="utf-8")
    except OSError:
        return False
    return text.rpartition(")")[2].split()[0] != "Z"


def usage_of(pid):
    """(resident memory [KiB], descriptors, threads) of a process; zeros if it has ended."""
    try:
        text = pathlib.Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
        descriptors = len(os.listdir(f"/proc/{pid}/fd"))
    except OSError:
        return (0, 0, 0)
    fields = {name: int(value) for name, value in
              re.findall(r"^(VmRSS|RssShmem|Threads):\s+(\d+)", text, re.MULTILINE)}
    # Without the ring buffers between engine and wire: a pause touches more of them, up to their
    # size.
    return (fields.get("VmRSS", 0) - fields.get("RssShmem", 0), descriptors, fields.get("Threads", 0))


def shared_memory_of(pid):
    """Files of /dev/shm that a process has mapped or open."""
    found = set()
    try:
        maps = pathlib.Path(f"/proc/{pid}/maps").read_text(encoding="utf-8")
        found.update(re.findall(r"(/dev/shm/\S+)", maps))
        for descriptor in os.listdir(f"/proc/{pid}/fd"):
            with contextlib.suppress(OSError):
                target = os.readlink(f"/proc/{pid}/fd/{descriptor}")
                if target.startswith("/dev/shm/"):
                    found.add(target.removesuffix(" (deleted)"))
    except OSError:
        pass
    return found


def how_it_ended(process):
    code = process.returncode
    return signal.Signals(-code).name if code < 0 else f"exit code {code}"


class Bench:
    """A vdrived and its descendants."""

    def __init__(self, program, directory, domain, *words, number=1):
        self.number = number
        self.log = pathlib.Path(directory) / f"vdrived-{number}-{time.monotonic_ns()}.log"
        self.words = ["nice", "-n", str(BENCH_NICENESS), str(program), "--domain", str(domain), "--bench", str(number),
                      "--metrics", "0", *map(str, words)]
        with open(self.log, "w", encoding="utf-8") as log:
            self.process = subprocess.Popen(  # pylint: disable=consider-using-with
                self.words, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        self.begin = now()
        self.shared_memory = set()
        self.url = None

    def find_metrics(self):
        def find_url():
            if self.process.poll() is not None:
                raise Failure(f"vdrived did not start: {self.last_words()}")
            found = re.search(r"metrics=(http\S+)", self.log.read_text(encoding="utf-8"))
            return found and found.group(1)
        self.url = wait_for("the address of the metrics", find_url)

    @property
    def pid(self):
        return self.process.pid

    def metrics(self):
        """All metrics without histograms: name -> value; vdrive_info -> its labels."""
        if self.url is None:
            self.find_metrics()
        with urllib.request.urlopen(self.url, timeout=5) as answer:
            text = answer.read().decode()
        found = {name: float(value) for name, value in
                 re.findall(r"^(\w+)\{bench=\"\d+\"\} (\S+)$", text, re.MULTILINE)}
        info = re.search(r"^vdrive_info\{(.*)\}", text, re.MULTILINE)
        found["incarnation"] = re.search(r"incarnation=\"(\d+)\"", info.group(1)).group(1)
        return found

    def account(self):
        """The engine's own count of its ticks. The difference between the tick number and the
        number of ticks run is constant as long as no tick is skipped. The two values are not
        read at the same instant, and the tick number is read first, so the largest of several
        differences is the true one."""
        readings = [self.metrics() for _ in range(5)]
        last = dict(readings[-1])
        last["numbered_not_run"] = max(int(r["vdrive_tick"]) - int(r["vdrive_ticks_total"])
                                       for r in readings)
        return last

    def wire_processes(self):
        return [pid for pid in descendants(self.pid) if WIRE_WORD in command_line(pid)]

    def usage(self):
        """Sums over the service and its descendants; also records their shared memory."""
        processes = [self.pid, *descendants(self.pid)]
        for pid in processes:
            self.shared_memory |= shared_memory_of(pid)
        return tuple(map(sum, zip(*map(usage_of, processes))))

    def check_alive(self):
        if self.process.poll() is not None:
            raise Failure(f"vdrived ended by {how_it_ended(self.process)} after "
                          f"{now() - self.begin:.1f} s: {self.last_words()}")

    def last_words(self):
        lines = self.log.read_text(encoding="utf-8", errors="replace").splitlines()
        report = [line for line in lines if "Assertion" in line or "terminate" in line]
        return " | ".join(report[-1:] or lines[-2:])

    def stop(self):
        """Ends it with SIGTERM. @return seconds until none of its processes was left."""
        self.check_alive()
        everybody = [self.pid, *descendants(self.pid)]
        self.usage()
        begin = now()
        self.process.send_signal(signal.SIGTERM)
        while self.process.poll() is None or any(map(is_running, everybody)):
            if now() - begin > END_LIMIT + 8:
                break
            time.sleep(0.005)
        duration = now() - begin
        left = [pid for pid in everybody if is_running(pid)]
        if left or duration > END_LIMIT:
            names = ", ".join(" ".join(command_line(pid))[:60] for pid in left)
            raise Failure(f"{duration:.2f} s after SIGTERM; still there: {names or 'nobody'}")
        if self.process.returncode != 0:
            raise Failure(f"vdrived answered SIGTERM with code {self.process.returncode}: "
                          f"{self.last_words()}")
        files = sorted(file for file in self.shared_memory if os.path.exists(file))
        if files:
            raise Failure(f"vdrived left {len(files)} files behind: {files[0]}")
        return duration

    def kill(self):
        """Kills its remaining processes, as a cleanup."""
        for pid in descendants(self.pid):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()


class Program:
    """A role of churn_client; its output lines are kept."""

    def __init__(self, client, domain, role, *words, security=None, bench=1, niceness=0):
        options = ["--domain", str(domain), "--bench", str(bench)]
        if security:
            options += ["--security", str(security)]
        self.role = role
        self.lines = []
        self.by_key = {}
        self.process = subprocess.Popen(  # pylint: disable=consider-using-with
            ["nice", "-n", str(niceness), str(client), *options, role, *map(str, words)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.begin = now()
        self.errors = ""
        self.readers = [threading.Thread(target=self.read_lines),
                        threading.Thread(target=self.read_errors)]
        for reader in self.readers:
            reader.start()

    def read_lines(self):
        for line in self.process.stdout:
            with contextlib.suppress(json.JSONDecodeError):  # the last line of a killed program
                report = json.loads(line)
                self.lines.append(report)
                for key in report:
                    self.by_key.setdefault(key, []).append(report)

    def read_errors(self):
        self.errors = self.process.stderr.read()

    def check_alive(self):
        """Checks a program that should run until it is asked to end."""
        if self.process.poll() is not None:
            for reader in self.readers:
                reader.join()
            raise Failure(f"the program '{self.role}' ended by {how_it_ended(self.process)} after "
                          f"{now() - self.begin:.1f} s: {self.errors.strip()[-200:]}")

    def found(self, key):
        """The lines with this key."""
        return list(self.by_key.get(key, ()))

    def end(self, patience=PATIENCE):
        """Closes its standard input and waits. @return its exit code, or the negative signal
        number."""
        with contextlib.suppress(OSError):
            self.process.stdin.close()
        try:
            code = self.process.wait(patience)
        except subprocess.TimeoutExpired:
            self.kill()
            raise Failure(f"the program '{self.role}' did not end within {patience:g} s") from None
        for reader in self.readers:
            reader.join()
        return code

    def kill(self):
        self.process.kill()
        self.process.wait()
        for reader in self.readers:
            reader.join()


def run_role(client, domain, role, *words, **options):
    """Runs a role that ends on its own. @return its lines."""
    program = Program(client, domain, role, *words, **options)
    code = program.end(60)
    if code != 0:
        report = program.found("failed")
        raise Failure(f"the program '{role}' ended with {code}: "
                      f"{report[-1]['message'] if report else program.errors.strip()}")
    return program.lines


class Usage:
    """Memory, descriptors and threads of a bench; the caller takes a sample once a second."""

    NAMES = ("memory [MiB]", "descriptors", "threads")

    def __init__(self, bench):
        self.bench = bench
        self.begin = now()
        self.samples = []  # (seconds, memory, descriptors, threads)

    def sample(self):
        memory, descriptors, threads = self.bench.usage()
        self.samples.append((now() - self.begin, memory / 1024, descriptors, threads))

    def report(self, warm_up, bounds):
        """Prints min, max and slope after the warm-up. @return the values that grew beyond their
        bound between the first and the last quarter. The medians of the quarters are compared,
        so that a single sample during a restart of a wire has no weight."""
        steady = [sample for sample in self.samples if sample[0] >= warm_up]
        wrong = []
        if len(steady) < 8:
            print(f"usage: {len(steady)} samples after {warm_up:g} s of warm-up: not judged")
            return wrong
        quarter = len(steady) // 4
        for place, name in enumerate(self.NAMES, 1):
            values = [sample[place] for sample in steady]
            growth = percentile(values[-quarter:], 0.5) - percentile(values[:quarter], 0.5)
            slope = slope_of([sample[0] for sample in steady], values) * 60
            print(f"{name}: min {min(values):.0f}, max {max(values):.0f}, "
                  f"slope {slope:+.2f} a minute, grew by {growth:+.1f} (bound {bounds[place - 1]:g})")
            if growth > bounds[place - 1]:
                wrong.append(f"{name} grew by {growth:.1f} after the warm-up, "
                             f"the bound is {bounds[place - 1]:g}")
        return wrong


def slope_of(times, values):
    """The slope of a least-squares line."""
    middle_time = sum(times) / len(times)
    middle_value = sum(values) / len(values)
    spread = sum((t - middle_time) ** 2 for t in times)
    return sum((t - middle_time) * (v - middle_value)
               for t, v in zip(times, values)) / spread if spread else 0.0
