# SPDX-License-Identifier: Apache-2.0
"""Writes framesets for touchable touch|play --camera "pipe:python3 SENDER.py" (docs/streaming.md).
Whatever else a sender says goes to standard error: standard output has the framesets."""
import signal, struct, sys, zlib

signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))  # so that a sender lets its camera go

def send(depth, width, height, metres_per_unit, fx, fy, cx, cy, time_ns, number,
         colour=b"", colour_width=0, colour_height=0, registered=True, to=sys.stdout.buffer):
    """depth: rows of 16-bit little-endian numbers, 0 where nothing was measured; fx, fy, cx, cy: its lens,
    pixels; time_ns: when it was taken, by any clock that goes on (0: not known); number: counts up, so that
    what is missing was lost; colour: rows of R, G, B, as seen from where depth is seen from (registered)."""
    payload = bytes(depth) + bytes(colour)
    if len(payload) != 2 * width * height + 3 * colour_width * colour_height:
        sys.exit(f"depth and colour have {len(payload)} bytes, which is not what their sizes say")
    head = struct.pack("<8sIIQqIIdddddIIII", b"FRAMESET", 1, 100, number, time_ns, width, height,
                       metres_per_unit, fx, fy, cx, cy, colour_width, colour_height, int(registered),
                       zlib.crc32(payload))
    try:
        to.write(head + struct.pack("<I", zlib.crc32(head)) + payload)
        to.flush()
    except BrokenPipeError:  # the reader is gone
        sys.stderr.close()
        sys.exit(0)
