#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A small hand: it pokes at what is in front of it, and says what it felt.
   touchable touch CLIP --live --device network --force-on --max-force 1 --seconds 5
   python3 network_hand.py [SECONDS [PORT]]"""
import argparse, math, select, socket, struct, sys, time, zlib

words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
words.add_argument("seconds", nargs="?", type=float, default=5)
words.add_argument("port", nargs="?", type=int, default=5710)
words = words.parse_args()
hand = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
hand.connect(("127.0.0.1", words.port))
hand.setblocking(False)
head = struct.Struct("<4sBBBBIIQ")  # TCHD, version, kind, fingers, flags, sequence, buttons, time

def send(sequence, place, last=False):  # metres: x right, y up, z towards the person
    packet = head.pack(b"TCHD", 1, 1, 1, last, sequence, 0, time.monotonic_ns()) + struct.pack("<3d", *place)
    hand.send(packet + struct.pack("<I", zlib.crc32(packet)))

start, forces, trips, why = time.monotonic(), [], [], "there was no time for one"
for tick in range(1, int(words.seconds * 1000)):
    while (now := time.monotonic() - start) < tick / 1000:
        time.sleep(max(0.0, tick / 1000 - now - 0.0001))
    answer, refused = None, False
    try:
        send(tick, (0.01 * math.sin(now), 0.0, 0.04 * math.cos(2 * now)))
    except ConnectionRefusedError:  # an earlier packet was; answers may wait nevertheless
        refused = True
    while select.select([hand], [], [], 0 if answer or refused else 0.02)[0]:  # only the newest counts
        try:
            answer = hand.recv(1024)
        except ConnectionRefusedError:
            refused = True
        except BlockingIOError:
            break
    if not answer:  # a real device would be unpowered now
        why = ("no program listens there, or it has another hand" if refused else
               "no answer came: touchable says why (another number of fingers, another hand)")
        continue
    if len(answer) == 52 and zlib.crc32(answer[:-4]) == struct.unpack("<I", answer[-4:])[0]:
        forces.append(math.hypot(*struct.unpack_from("<3d", answer, head.size)))
        if not answer[7] & 2:  # sent while touchable stands still: zeros, no answer
            trips.append((time.monotonic_ns() - head.unpack_from(answer)[7]) / 1e6)
if not trips:
    sys.exit(f"no answer from UDP 127.0.0.1:{words.port}: {why}")
try:
    send(tick + 1, (0, 0, 0.1), last=True)
except ConnectionRefusedError:
    print("touchable ended first", file=sys.stderr)
trips.sort()
print(f"{len(trips)} answers, round trip {trips[len(trips) // 2]:.2f} ms median, "
      f"{trips[len(trips) * 99 // 100]:.2f} ms p99, largest force {max(forces):.2f} N")
