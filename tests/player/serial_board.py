# SPDX-License-Identifier: Apache-2.0
"""A board as serial_hand.py has it, at a pseudo-terminal: for so many seconds it pokes, then it is unplugged.
   python3 serial_board.py SERIAL_HAND UDP_PORT SECONDS"""
import math, os, subprocess, sys, time, tty

script, port, seconds = sys.argv[1:]
master, slave = os.openpty()
tty.setraw(slave)
os.set_blocking(master, False)
bridge = subprocess.Popen([sys.executable, script, os.ttyname(slave), port], stderr=subprocess.PIPE, text=True)
os.close(slave)
start, most, forces, text = time.monotonic(), 0.0, 0, b""
for tick in range(int(float(seconds) * 1000)):
    line = b"nonsense\n" if tick % 1000 == 500 else b"0 0 %.5f 0\n" % (0.04 * math.cos(tick / 500))
    try:
        os.write(master, line)
        *lines, text = (text + os.read(master, 65536)).split(b"\n")
    except (BlockingIOError, OSError):
        lines = []
    for each in lines:
        most, forces = max(most, math.hypot(*map(float, each.split()))), forces + 1
    time.sleep(max(0, start + tick / 1000 - time.monotonic()))
os.close(master)
print(f"{forces} forces, largest force {most:.2f} N; the bridge: {bridge.communicate()[1].strip()}")
