# %% [markdown]
# SPDX-License-Identifier: Apache-2.0
#
# # A move, plotted
#
# A script in cells: run it cell by cell in an editor, or as a whole:
#
#     plot_a_move.py [FILE.svg]
#
# It creates its own bench, records a free move and one against a load, and plots both. In lock-step
# each run gives the same file.

# %%
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import vdrive

# The file must not depend on the time and the machine.
matplotlib.rcParams["svg.hashsalt"] = "vdrive"
matplotlib.rcParams["font.family"] = "DejaVu Sans"

# %% A private bench with two axes.
bench = vdrive.Bench()
session = bench.session()
free, loaded = session.axis("1.1"), session.axis("1.2")

# %% From the middle of the move, the second axis has a load of 1.5 N.m.
for axis in (free, loaded):
    axis.enable()
    axis.start_move(8192, velocity=20000, acceleration=100000, deceleration=60000)
first = session.record([free, loaded], ticks=300)
loaded.disturb("load_torque", -1500)
second = session.record([free, loaded], ticks=500)

# %% Recordings are numpy arrays: a row per tick, a column per axis.
milliseconds = list(range(800))


def column(field, axis):
    return [*first[field][:, axis], *second[field][:, axis]]


figure, plots = plt.subplots(3, 1, sharex=True, figsize=(8, 7), layout="constrained")
plots[0].plot(milliseconds, column("demand", 0), "k--", linewidth=1, label="demand")
for axis, name in enumerate(("free", "loaded from 300 ms on")):
    plots[0].plot(milliseconds, column("position", axis), label=name)
    plots[1].plot(milliseconds, column("following_error", axis))
    plots[2].plot(milliseconds, [value / 10 for value in column("torque", axis)])
plots[0].set_ylabel("position (UU)")
plots[1].set_ylabel("following error (UU)")
plots[2].set_ylabel("torque (% of rated)")
plots[2].set_xlabel("drive time (ms)")
plots[0].legend()
for plot in plots:
    plot.grid(alpha=0.3)

# %%
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "move.svg", metadata={"Date": None})
session.close()
bench.close()
