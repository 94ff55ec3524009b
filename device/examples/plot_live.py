#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Plots forces while they are felt, from a pipe (needs python3-matplotlib):
   touchable touch CLIP --live --device network --device-log - | python3 plot_live.py [PICTURE.png]
The last ten seconds are shown until the input ends. With PICTURE they are saved there then, and no window is opened."""
import collections, csv, signal, sys, threading

times, newtons = collections.deque(maxlen=10_000), collections.deque(maxlen=10_000)
lock = threading.Lock()

def read():  # as fast as rows come, independent of drawing: a slow reader loses ticks
    for row in csv.DictReader(sys.stdin):
        if row["finger"] != "0":
            continue
        force = sum(float(row[axis]) ** 2 for axis in ("fx", "fy", "fz")) ** 0.5
        with lock:
            times.append(float(row["time_s"]))
            newtons.append(force)

signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the run, and with it the input
reader = threading.Thread(target=read, daemon=True)
reader.start()  # first, because matplotlib takes seconds to load
import matplotlib
if len(sys.argv) > 1:
    matplotlib.use("Agg")
import matplotlib.pyplot as plot

figure, axes = plot.subplots(figsize=(9, 3), layout="constrained")
line, = axes.plot([], [])
axes.set(xlabel="time, s", ylabel="force, N")
axes.grid(alpha=0.3)

def draw():
    with lock:
        line.set_data(list(times), list(newtons))
    axes.relim()
    axes.autoscale_view()

if len(sys.argv) > 1:
    reader.join()
    draw()
    figure.savefig(sys.argv[1])
else:
    while reader.is_alive() and plot.fignum_exists(figure.number):
        draw()
        plot.pause(0.03)
    reader.join()  # keep the run's pipe open after the window is closed
