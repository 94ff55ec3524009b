#!/usr/bin/env python3
"""Plots forces while they are felt, from a pipe (needs python3-matplotlib):
   touchable touch CLIP --live --device network --device-log - | python3 plot_live.py [PICTURE.png]
With PICTURE the last ten seconds are saved there at the end, and no window is opened."""
import collections, csv, sys

import matplotlib
if len(sys.argv) > 1:
    matplotlib.use("Agg")
import matplotlib.pyplot as plot

times, newtons = collections.deque(maxlen=10_000), collections.deque(maxlen=10_000)
figure, axes = plot.subplots(figsize=(9, 3), layout="constrained")
line, = axes.plot([], [])
axes.set(xlabel="time, s", ylabel="force, N")
axes.grid(alpha=0.3)

def draw():
    line.set_data(times, newtons)
    axes.relim()
    axes.autoscale_view()

for number, row in enumerate(csv.DictReader(sys.stdin)):
    if row["finger"] != "0":
        continue
    times.append(float(row["time_s"]))
    newtons.append(sum(float(row[axis]) ** 2 for axis in ("fx", "fy", "fz")) ** 0.5)
    if len(sys.argv) == 1 and number % 50 == 0:
        draw()
        plot.pause(0.001)
draw()
if len(sys.argv) > 1:
    figure.savefig(sys.argv[1])
else:
    plot.show()
