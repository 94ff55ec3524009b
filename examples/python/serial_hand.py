#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A board at a serial port is the hand. It sends 1000 lines a second, "x y z buttons" (metres to the right, up and
towards the person; a number with a bit for each button), and gets lines "fx fy fz" (newtons). If no line came for
20 ms, it has to let go of the handle by itself.
   touchable touch CLIP --live --device network --max-force 1
   python3 serial_hand.py /dev/ttyACM0 [UDP_PORT]"""
import os, select, socket, struct, sys, termios, time, tty, zlib

if len(sys.argv) < 2:
    sys.exit(__doc__)
board = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
tty.setraw(board)
mode = termios.tcgetattr(board)
mode[4] = mode[5] = termios.B1000000  # bits a second; boards with a USB port of their own take any
termios.tcsetattr(board, termios.TCSANOW, mode)
hand = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
hand.connect(("127.0.0.1", int(sys.argv[2]) if len(sys.argv) > 2 else 5710))
hand.setblocking(False)
sequence, heard, damaged, text = 0, 0.0, 0, b""

def send(place, buttons, last=False):
    packet = struct.pack("<4sBBBBIIQ3d", b"TCHD", 1, 1, 1, last, sequence, buttons, time.monotonic_ns(), *place)
    try:
        hand.send(packet + struct.pack("<I", zlib.crc32(packet)))
    except OSError:
        pass  # touchable does not run yet, or no more

def write(force):
    try:
        os.write(board, b"%.3f %.3f %.3f\n" % force)
    except BlockingIOError:
        pass  # the board does not read, and lets go by itself

try:
    while True:
        ready = select.select([board, hand], [], [], 0.02)[0]
        if board in ready:
            got = os.read(board, 4096)
            if not got:
                raise OSError("it was unplugged")
            *lines, text = (text + got).split(b"\n")
            try:
                if lines:  # only the newest counts
                    x, y, z, buttons = lines[-1].split()
                    place, pressed, sequence = (float(x), float(y), float(z)), int(buttons), sequence + 1
                    send(place, pressed)
            except ValueError:
                damaged += 1
        force = None
        try:
            while hand in ready:  # until all that came is read
                answer = hand.recv(1024)
                if len(answer) == 52:
                    force, heard = struct.unpack_from("<3d", answer, 24), time.monotonic()
        except (BlockingIOError, ConnectionRefusedError):
            pass
        if force:
            write(force)
        elif hand not in ready and time.monotonic() - heard > 0.02:
            write((0, 0, 0))
except (OSError, KeyboardInterrupt) as end:
    send((0, 0, 0), 0, last=True)
    if isinstance(end, KeyboardInterrupt):
        write((0, 0, 0))
    sys.exit(f"{sys.argv[1]}: {end or 'stopped'}; {sequence} places sent, {damaged} lines damaged")
