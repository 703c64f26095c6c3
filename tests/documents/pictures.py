#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the pictures of docs/images: the house, the power state machine, plots of moves and figures.

  pictures.py --recorder RECORD_MOVES --tool VDRIVE [--check]

RECORD_MOVES is the program of record_moves.cpp, VDRIVE the tool. Without --check the files are written; with it they
are compared, and the exit code is 1 if one is out of date.
"""
import argparse
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
IMAGES = ROOT / "docs" / "images"
STATE_MACHINE = ROOT / "core" / "src" / "cia402" / "power_state_machine.cpp"
FIGURES = ROOT / "tests" / "benchmark" / "measured.jsonl"  # what run.sh printed

INK = "#24292f"
SOFT = "#8c959f"
GRID = "#d8dee4"
BLUE = "#0969da"
ORANGE = "#bc4c00"
RED = "#cf222e"
PAPER = "#ffffff"
FILL = "#f6f8fa"


class Drawing:
    """Lines of an SVG of a given size [px]."""

    def __init__(self, width, height, title):
        self.lines = [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
            f'viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="13">',
            f"<title>{title}</title>",
            '<defs><marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="8" '
            f'markerHeight="8" orient="auto"><path d="M0 0L10 5L0 10z" fill="{INK}"/></marker></defs>',
            f'<rect width="{width}" height="{height}" fill="{PAPER}"/>']

    def add(self, line):
        self.lines.append(line)

    def text(self, x, y, text, anchor="middle", color=INK, size=13, weight="normal"):
        escaped = text.replace("&", "&amp;").replace("<", "&lt;")
        self.add(f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" fill="{color}" '
                 f'font-size="{size}" font-weight="{weight}">{escaped}</text>')

    def box(self, x, y, width, height, lines, color=INK):
        """A box with a bold title and lines below it."""
        self.add(f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="6" '
                 f'fill="{FILL}" stroke="{color}"/>')
        top = y + height / 2 - 8 * (len(lines) - 1) + 5
        for row, line in enumerate(lines):
            self.text(x + width / 2, top + 16 * row, line, size=13 if row == 0 else 11,
                      color=INK if row == 0 else SOFT, weight="bold" if row == 0 else "normal")

    def arrow(self, points, label="", at=None, anchor="middle"):
        path = "M" + " L".join(f"{x:g} {y:g}" for x, y in points)
        self.add(f'<path d="{path}" fill="none" stroke="{INK}" marker-end="url(#tip)"/>')
        if label:
            self.text(*at, label, anchor=anchor, size=11)

    def __str__(self):
        return "\n".join(self.lines + ["</svg>"]) + "\n"


def house():
    drawing = Drawing(760, 330, "The rooms of vdrive; an arrow points to what a room includes")
    drawing.box(280, 20, 200, 56, ["idl/", "the wire: topics, types, DDS"])
    drawing.box(40, 130, 200, 56, ["service/", "the engine of a bench"])
    drawing.box(520, 130, 200, 56, ["clients/", "library, tool, examples"])
    drawing.box(280, 240, 200, 56, ["core/", "the drive; no DDS, no clock"])
    drawing.arrow([(200, 130), (300, 76)])
    drawing.arrow([(560, 130), (460, 76)])
    drawing.arrow([(200, 186), (300, 240)])
    drawing.arrow([(560, 186), (460, 240)])
    drawing.arrow([(380, 76), (380, 240)])
    drawing.text(140, 270, "tests/ may include every room")
    drawing.text(140, 288, "no room includes tests/ or service/", color=SOFT, size=11)
    drawing.text(620, 270, "deploy/ has scripts and units")
    drawing.text(620, 288, "no code", color=SOFT, size=11)
    return str(drawing)


# ---- power state machine -------------------------------------------------------------------------

STATES = {  # name in the source: (x, y, label)
    "not_ready_to_switch_on": (60, 20, "Not ready to switch on"),
    "switch_on_disabled": (60, 120, "Switch on disabled"),
    "ready_to_switch_on": (60, 220, "Ready to switch on"),
    "switched_on": (60, 320, "Switched on"),
    "operation_enabled": (60, 420, "Operation enabled"),
    "quick_stop_active": (480, 420, "Quick stop active"),
    "fault_reaction_active": (480, 20, "Fault reaction active"),
    "fault": (480, 120, "Fault"),
}
BOX = (190, 44)
# number: (from, points, place of the label)
TRANSITIONS = {
    1: ("not_ready_to_switch_on", [(155, 64), (155, 120)], (165, 96)),
    2: ("switch_on_disabled", [(130, 164), (130, 220)], (118, 196)),
    7: ("ready_to_switch_on", [(180, 220), (180, 164)], (192, 196)),
    3: ("ready_to_switch_on", [(130, 264), (130, 320)], (118, 296)),
    6: ("switched_on", [(180, 320), (180, 264)], (192, 296)),
    4: ("switched_on", [(130, 364), (130, 420)], (118, 396)),
    5: ("operation_enabled", [(180, 420), (180, 364)], (192, 396)),
    8: ("operation_enabled", [(250, 436), (290, 436), (290, 246), (250, 246)], (300, 340)),
    10: ("switched_on", [(250, 342), (330, 342), (330, 150), (250, 150)], (342, 250)),
    9: ("operation_enabled", [(250, 428), (370, 428), (370, 136), (250, 136)], (380, 300)),
    11: ("operation_enabled", [(250, 444), (480, 444)], (430, 440)),
    16: ("quick_stop_active", [(480, 456), (250, 456)], (430, 470)),
    12: ("quick_stop_active", [(575, 420), (575, 260), (410, 260), (410, 128), (250, 128)],
         (590, 340)),
    14: ("fault_reaction_active", [(575, 64), (575, 120)], (589, 96)),
    15: ("fault", [(480, 142), (440, 142), (440, 112), (180, 112), (180, 120)], (456, 136)),
}
EVENTS = ["0, 1  start-up, without a command", "2, 6, 8  Shutdown", "3  Switch on",
          "4, 16  Enable operation", "5  Disable operation", "7, 9, 10, 12  Disable voltage",
          "12  also the end of the quick stop", "11  Quick stop",
          "13  a fault in any state", "14  end of the reaction", "15  Fault reset"]


def edges_of_the_core():
    """@return number: (sources, target), taken from the tables of power_state_machine.cpp."""
    source = STATE_MACHINE.read_text(encoding="utf-8")
    table = source[source.index("kTargets{"):source.index("/// Up to three")]
    targets = {int(number): name for name, number in re.findall(r"(\w+),\s+// (\d+)", table)}
    names = {label: name for name, (_, _, label) in STATES.items()}
    edges = {}
    for label, row in re.findall(r"/\* ([A-Z][a-z ]+?) +\*/ \{(.*)\}", source):
        for path in re.findall(r"Path\{([\d, ]+)\}", row):
            state = names[label]
            for number in map(int, path.split(",")):
                edges.setdefault(number, (set(), targets[number]))[0].add(state)
                state = targets[number]
    return edges, targets


def power_states():
    edges, targets = edges_of_the_core()
    automatic = {1: "not_ready_to_switch_on", 14: "fault_reaction_active", 12: "quick_stop_active"}
    for number, state in automatic.items():
        edges.setdefault(number, (set(), targets[number]))[0].add(state)
    drawn = {number: ({source}, targets[number]) for number, (source, _, _) in TRANSITIONS.items()}
    if drawn != edges:
        sys.exit(f"pictures: the drawing has {drawn}, the core has {edges}")
    drawing = Drawing(800, 500, "Power state machine of CiA 402")
    for name, (x, y, label) in STATES.items():
        drawing.box(x, y, *BOX, [label], color=RED if "fault" in name else INK)
    for number, (_, points, at) in TRANSITIONS.items():
        drawing.arrow(points, str(number), at)
    drawing.arrow([(400, 42), (480, 42)], "13", (440, 36))
    drawing.text(396, 46, "any state", anchor="end", size=11, color=SOFT)
    for row, event in enumerate(EVENTS):
        drawing.text(620, 200 + 18 * row, event, anchor="start", size=10, color=SOFT)
    return str(drawing)


# ---- plots -----------------------------------------------------------------------------------------


def plot(arguments, move, title):
    """@return the picture that `vdrive plot` draws from a recorded move."""
    with tempfile.TemporaryDirectory() as directory:
        recording = pathlib.Path(directory) / "move.csv"
        with recording.open("wb") as file:
            subprocess.run([arguments.recorder, move], check=True, stdout=file)
        return subprocess.run(
            [arguments.tool, "plot", recording, "--output", "-", "--title", title, "--width", "740"],
            check=True, capture_output=True, text=True).stdout


# ---- figures of the benchmarks over the number of axes ---------------------------------------------


PLOT = (70, 700)  # left and right edge [px]


def figures_of(name, most):
    """@return {axes: value} of a figure up to `most` axes; the first line for each number counts.
    """
    found = {}
    for line in FIGURES.read_text(encoding="utf-8").splitlines():
        figure = json.loads(line)
        if figure.get("figure") == name and figure["axes"] <= most:
            found.setdefault(figure["axes"], figure["value"])
    return dict(sorted(found.items()))


def diagram(title, unit, curves, most=16384):
    """Curves (figure, color, label) over the number of axes on a logarithmic scale."""
    drawing = Drawing(740, 360, title)
    drawing.text(370, 20, title, size=14, weight="bold")
    series = [(figures_of(name, most), color, label) for name, color, label in curves]
    axes = sorted({count for values, _, _ in series for count in values})
    top, height = 50, 260
    high = 1.1 * max(value for values, _, _ in series for value in values.values()) or 1
    low, span = math.log2(axes[0]), max(math.log2(axes[-1] / axes[0]), 1)

    def place(count, value):
        return (PLOT[0] + 15 + (PLOT[1] - PLOT[0] - 30) * (math.log2(count) - low) / span,
                top + height * (1 - value / high))

    drawing.add(f'<rect x="{PLOT[0]}" y="{top}" width="{PLOT[1] - PLOT[0]}" height="{height}" '
                f'fill="none" stroke="{SOFT}"/>')
    for value in fractions_of(high):
        y = place(axes[0], value)[1]
        drawing.add(f'<path d="M{PLOT[0]} {y:.1f}H{PLOT[1]}" stroke="{GRID}"/>')
        drawing.text(PLOT[0] - 6, round(y + 4, 1), f"{value:g}", anchor="end", size=10, color=SOFT)
    for count in axes:
        drawing.text(round(place(count, 0)[0], 1), top + height + 16, f"{count:,}", size=10,
                     color=SOFT)
    drawing.text((PLOT[0] + PLOT[1]) / 2, top + height + 36, "axes", size=11, color=SOFT)
    drawing.text(PLOT[0], top - 6, unit, anchor="start", size=12, weight="bold")
    x = PLOT[1]
    for values, color, label in reversed(series):
        drawing.text(x, top - 6, label, anchor="end", size=11, color=color)
        x -= 8 * len(label) + 8
        points = [place(count, value) for count, value in values.items()]
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        drawing.add(f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="1.4"/>')
        for point in points:
            drawing.add('<circle cx="{:.1f}" cy="{:.1f}" r="3" fill="{}"/>'.format(*point, color))
    return str(drawing)


def fractions_of(high):
    """@return about four round values from 0 to `high`."""
    power = 10 ** math.floor(math.log10(high / 4))
    step = next(power * factor for factor in (1, 2, 5, 10) if power * factor >= high / 4)
    return [step * n for n in range(math.floor(high / step) + 1)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--recorder", required=True)
    parser.add_argument("--tool", required=True)
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    pictures = {
        "house.svg": house(),
        "power_states.svg": power_states(),
        "absolute_forward.svg": plot(arguments, "forward",
                                     "The manual's forward example: 10000 UU at 1000 UU/s"),
        "blocked_load.svg": plot(arguments, "blocked",
                                 "The load is blocked at 1 s: fault 8611h, following error"),
        "ns_per_axis.svg": diagram(
            "One tick of the bank: time of an axis that moves", "ns an axis",
            [("axis_tick_ns", BLUE, "rigid"),
             ("axis_tick_two_inertia_ns", ORANGE, "two inertias")]),
        "status_loss.svg": diagram(
            "Status at 1 kHz: what one subscriber of all axes misses", "share of the ticks",
            [("status_missed_share", RED, "missed"),
             ("overrun_share", BLUE, "ticks that end late")],
            most=4096),  # the status of more axes is decimated
    }
    stale = []
    for name, text in pictures.items():
        file = IMAGES / name
        if not arguments.check:
            file.write_text(text, encoding="utf-8")
        elif not file.is_file() or file.read_text(encoding="utf-8") != text:
            stale.append(name)
    for name in stale:
        print(f"docs/images/{name} is not current; tests/documents/pictures.py --recorder "
              f"{arguments.recorder} --tool {arguments.tool} writes it")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
