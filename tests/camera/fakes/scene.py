# SPDX-License-Identifier: Apache-2.0
"""What the fakes see: a ball that comes nearer and goes away before a wall, 100 times a second."""
import math, struct, time

width, height = 64, 48

def depth_of(number, per_metre=1000):
    nearer = 0.1 * math.sin(0.2 * number)
    values = []
    for y in range(height):
        for x in range(width):
            inside = 400 - (x - 32) ** 2 - (y - 24) ** 2
            values.append(int(per_metre * (0.9 - nearer - (0.01 * math.sqrt(inside) if inside > 0 else 0))))
    return struct.pack(f"<{width * height}H", *values)

pictures = {}

def picture(number, per_metre=1000):
    """The same 32 again and again: they take long to paint."""
    number %= 32
    if number not in pictures:
        pictures[number] = depth_of(number, per_metre)
    return pictures[number]

def wait():
    time.sleep(0.01)

class Array:
    """What of a NumPy array the senders use."""
    def __init__(self, data, shape):
        self.data, self.shape = data, shape

    def tobytes(self):
        return self.data

    def __getitem__(self, key):
        assert key == (slice(None), slice(None), slice(2, None, -1)), key  # BGRA to RGB
        pixels = self.shape[0] * self.shape[1]
        return Array(b"".join(self.data[4 * k:4 * k + 3][::-1] for k in range(pixels)), self.shape[:2] + (3,))
