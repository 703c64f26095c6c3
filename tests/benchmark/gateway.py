#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The cost of the gateway: its processor time and memory, the age of its messages, the bench's ticks.

  gateway.py [--axes 256] [--clients 20] [--seconds 20] [--domain 43] [--build build/release]
  gateway.py --soak 30 [--axes 64] [--clients 5] [--domain 43] [--build build/release]
  gateway.py --ticks 2 [--axes 256] [--clients 20] [--seconds 4] [--domain 43] [--build build/release]

--soak only watches the memory of a gateway that sends for this many minutes.
--ticks only counts the overruns of the bench, in this many rounds: without a gateway, with one whose
clients have the usual priority, and with one whose clients have idle priority and therefore, like
clients on other machines, take no time from the bench; each with a tick thread of usual priority and
of SCHED_FIFO.
Prints one JSON object. Needs the targets vdrived, vdrive-gateway and gateway_load.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import tempfile
import time
import urllib.request

from hops import free_port

ROOT = pathlib.Path(__file__).resolve().parents[2]


def processor_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def resident_mb(pid):
    return int(re.search(r"VmRSS:\s+(\d+)", pathlib.Path(f"/proc/{pid}/status").read_text())[1]) / 1024


def overruns(port):
    text = urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=5).read().decode()
    return sum(float(line.split()[-1]) for line in text.splitlines()
               if re.match(r"vdrive_\w*overruns\w*[ {]", line))


def wait_until(condition, what):
    """Repeats the check until it holds."""
    deadline = time.monotonic() + 60
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(what)
        time.sleep(0.05)


def shows(port, line):
    """Whether the metrics at a port have a line of this pattern; False while nothing answers."""
    try:
        text = urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=5).read().decode()
    except OSError:
        return False
    return re.search(f"^{line}$", text, re.MULTILINE) is not None


def start_service(options, running, *arguments):
    """Returns the port of the service's metrics, once it ticks."""
    port = free_port()
    running.append(subprocess.Popen(
        [options.build / "bin/vdrived", "--domain", options.domain, "--axes", str(options.axes),
         "--log-level", "error", "--metrics", str(port), *arguments]))
    wait_until(lambda: shows(port, r"vdrive_ticks_total\{.*\} [1-9]\S*"), "the bench does not tick")
    return port


def start_gateway(options, running):
    """Returns the gateway, its port and that of its metrics, once it shows the bench."""
    metrics = free_port()
    gateway = subprocess.Popen([options.build / "bin/vdrive-gateway", "--domain", options.domain,
                                "--listen", "127.0.0.1:0", "--metrics", f"127.0.0.1:{metrics}"],
                               stdout=subprocess.PIPE, text=True)
    running.append(gateway)
    port = gateway.stdout.readline().split("127.0.0.1:")[1].split("/")[0]
    wait_until(lambda: shows(metrics, r'vdrive_gateway_bench_alive\{bench="1"\} 1'),
               "the gateway does not find the bench")
    return gateway, port, metrics


CONDITIONS = {  # arguments placed before the clients' program; none = no clients
    "alone": None,
    "clients_at_idle_priority": ["chrt", "-i", "0"],
    "clients_at_usual_priority": [],
}


def count_overruns(options, port, clients_of, metrics):
    """Overruns in 10,000 ticks of 1 ms."""
    before = overruns(metrics)
    if clients_of is None:
        time.sleep(options.seconds)
    else:
        subprocess.run([*clients_of, options.build / "bin/gateway_load", port,
                        str(options.clients), str(options.seconds)], check=True,
                       capture_output=True)
    return (overruns(metrics) - before) * 10 / options.seconds


def keep_awake(running):
    """An idle virtual processor wakes up late: spinners at idle priority keep it running."""
    for _ in range(os.cpu_count()):
        running.append(subprocess.Popen(["chrt", "-i", "0", "sh", "-c", "while :; do :; done"]))


def ticks(options, running):
    keep_awake(running)
    spinners = len(running)
    result = {"axes": options.axes, "clients": options.clients, "seconds": options.seconds,
              "load_average": os.getloadavg()[0], "overruns_in_10000_ticks": {}}
    for priority in (0, 50):
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
            file.write(f"clock: {{realtime_priority: {priority}}}\n")
            file.flush()
            metrics = start_service(options, running, "--config", file.name)
        _, port, _ = start_gateway(options, running)
        counts = {name: [] for name in CONDITIONS}
        for _ in range(options.ticks):
            for name, clients_of in CONDITIONS.items():
                counts[name].append(count_overruns(options, port, clients_of, metrics))
        result["overruns_in_10000_ticks"][f"realtime_priority_{priority}"] = counts
        for process in reversed(running[spinners:]):
            process.terminate()
            process.wait(timeout=10)
        del running[spinners:]
    return result


def slope(times, values):
    """The slope of the least-squares line."""
    middle, mean = sum(times) / len(times), sum(values) / len(values)
    squares = sum((t - middle) ** 2 for t in times)
    return sum((t - middle) * (v - mean) for t, v in zip(times, values)) / squares


def soak(options, running):
    start_service(options, running)
    gateway, port, _ = start_gateway(options, running)
    seconds = options.soak * 60
    load = subprocess.Popen([options.build / "bin/gateway_load", port, str(options.clients),
                             str(seconds)], stdout=subprocess.PIPE, text=True)
    running.append(load)
    begin, loads, times, sizes = time.monotonic(), [], [], []
    while load.poll() is None:
        try:
            load.wait(timeout=10)
        except subprocess.TimeoutExpired:
            pass
        times.append(time.monotonic() - begin)
        sizes.append(resident_mb(gateway.pid))
        loads.append(os.getloadavg()[0])
    running.remove(load)
    result = json.loads(load.stdout.read())
    later = next(i for i, t in enumerate(times) if t >= seconds / 10)  # excludes the start
    hours = [t / 3600 for t in times[later:]]
    return {"axes": options.axes, "minutes": options.soak, "load_average": [min(loads), max(loads)],
            "clients": options.clients, "messages_per_second": result["messages_per_second"],
            "rss_mb": {"after_10_s": sizes[0], "after_a_tenth": sizes[later], "end": sizes[-1],
                       "least": min(sizes), "most": max(sizes)},
            "growth_mb_per_hour": slope(hours, sizes[later:]),
            "samples": [round(size, 2) for size in sizes[::6]]}


def cost(options, running):
    result = {"axes": options.axes, "seconds": options.seconds, "load_average": os.getloadavg()[0]}
    metrics = start_service(options, running)
    before = overruns(metrics)
    time.sleep(options.seconds)
    result["overruns_without"] = overruns(metrics) - before
    gateway, port, of_gateway = start_gateway(options, running)
    result["rss_idle_mb"] = resident_mb(gateway.pid)
    before, spent = overruns(metrics), processor_seconds(gateway.pid)
    load = subprocess.run([options.build / "bin/gateway_load", port, str(options.clients),
                           str(options.seconds)], check=True, capture_output=True, text=True)
    result.update(json.loads(load.stdout))
    result["overruns_with"] = overruns(metrics) - before
    result["cores_of_gateway"] = (processor_seconds(gateway.pid) - spent) / options.seconds
    result["rss_mb"] = resident_mb(gateway.pid)
    # These clients read nothing, but end before the gateway considers them lost.
    deaf = subprocess.Popen([options.build / "bin/gateway_load", port, "10", "8", "--deaf"])
    running.append(deaf)
    most = result["rss_mb"]
    while deaf.poll() is None:
        most = max(most, resident_mb(gateway.pid))
        try:
            deaf.wait(timeout=0.1)
        except subprocess.TimeoutExpired:
            pass
    result["rss_of_a_deaf_client_mb"] = (most - result["rss_mb"]) / 10
    wait_until(lambda: shows(of_gateway, "vdrive_gateway_clients 0"), "clients stay")
    result["rss_after_mb"] = resident_mb(gateway.pid)
    return result


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--soak", type=int, default=0, metavar="MINUTES")
    parser.add_argument("--ticks", type=int, default=0, metavar="ROUNDS")
    parser.add_argument("--axes", type=int)
    parser.add_argument("--clients", type=int)
    parser.add_argument("--seconds", type=int)
    parser.add_argument("--domain", default="43")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    options = parser.parse_args()
    options.axes = options.axes or (64 if options.soak else 256)
    options.clients = options.clients or (5 if options.soak else 20)
    options.seconds = options.seconds or (4 if options.ticks else 20)
    running = []
    try:
        measure = soak if options.soak else ticks if options.ticks else cost
        result = measure(options, running)
    finally:
        for process in reversed(running):
            process.terminate()
            process.wait(timeout=10)
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
