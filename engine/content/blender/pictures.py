# SPDX-License-Identifier: Apache-2.0
# Pictures as files, to the bit: Blender's own image files dither and convert colours. No bpy here.
"""Reads the uncompressed OpenEXR that Blender writes; writes OpenEXR of floats, and PNG of 8 and 16 bits."""

import struct
import zlib

import numpy

from .faults import Fault

HALF, FLOAT = 1, 2
SAMPLE_TYPES = {0: numpy.dtype("<u4"), HALF: numpy.dtype("<f2"), FLOAT: numpy.dtype("<f4")}


class Unreadable(Fault):
    """A picture that is not what Blender was asked to write."""


def _until_zero(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode("utf-8", "replace"), end + 1


def _attributes(data, at):
    """The header that begins at `at`, as {name: bytes}, and where it ends; empty: no header."""
    attributes = {}
    while data[at]:
        name, at = _until_zero(data, at)
        _, at = _until_zero(data, at)
        size, = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def _channels(header):
    """(name, type of its samples) of each channel, in the order in which a line has them."""
    data, at, channels = header["channels"], 0, []
    while data[at]:
        name, at = _until_zero(data, at)
        kind, = struct.unpack_from("<i", data, at)
        channels.append((name, SAMPLE_TYPES[kind]))
        at += 16
    return channels


def read_exr(path):
    """{channel: float32 array of rows from the top} of an uncompressed file in lines, of one part or of several."""
    with open(path, "rb") as file:
        data = file.read()
    try:
        return _read_all(path, data)
    except (IndexError, ValueError, struct.error):
        raise Unreadable(f"{path}: ends too early; the disk may be full") from None


def _read_all(path, data):
    if len(data) < 8:
        raise ValueError("shorter than its first words")
    if data[:4] != b"\x76\x2f\x31\x01":
        raise Unreadable(f"{path}: is no OpenEXR file")
    is_of_parts = struct.unpack_from("<i", data, 4)[0] & 0x1000
    headers, at = [], 8
    while True:
        header, at = _attributes(data, at)
        if header:
            headers.append(header)
        if not is_of_parts or not header:
            break
    planes = {}
    for header in headers:
        at = _read_part(path, data, at, header, is_of_parts, planes)
    return planes


def _read_part(path, data, at, header, is_of_parts, planes):
    """Adds the channels of one part, whose table of lines is at `at`; returns where the next part's table is."""
    if header["compression"] != b"\0":
        raise Unreadable(f"{path}: is compressed, and was asked for without compression")
    left, top, right, bottom = struct.unpack("<4i", header["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    line = numpy.dtype([(name, kind, (width,)) for name, kind in _channels(header)])
    rows = numpy.empty(height, line)
    part_number = 4 if is_of_parts else 0
    for offset in struct.unpack_from(f"<{height}Q", data, at):
        row, = struct.unpack_from("<i", data, offset + part_number)
        rows[row - top] = numpy.frombuffer(data, line, 1, offset + part_number + 8)[0]
    prefix = header["name"].decode() + "." if is_of_parts and "name" in header else ""
    for name in line.names:
        whole = name if name.startswith(prefix) or name.count(".") > 1 else prefix + name
        planes[whole] = rows[name].astype(numpy.float32)
    return at + 8 * height


def write_float_exr(path, plane, channel="Z"):
    """One channel of 32-bit floats, in lines that are each compressed by themselves (ZIPS)."""
    height, width = plane.shape

    def attribute(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = b"\x76\x2f\x31\x01" + struct.pack("<i", 2) + b"".join((
        attribute("channels", "chlist", channel.encode() + b"\0" + struct.pack("<iB3xii", FLOAT, 0, 1, 1) + b"\0"),
        attribute("compression", "compression", b"\x02"),
        attribute("dataWindow", "box2i", window),
        attribute("displayWindow", "box2i", window),
        attribute("lineOrder", "lineOrder", b"\0"),
        attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
        attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        attribute("screenWindowWidth", "float", struct.pack("<f", 1)))) + b"\0"
    lines = []
    for y, row in enumerate(plane.astype("<f4")):
        packed = _zips(row.tobytes())
        lines.append(struct.pack("<ii", y, len(packed)) + packed)
    offset, offsets = len(header) + 8 * height, []
    for line in lines:
        offsets.append(offset)
        offset += len(line)
    with open(path, "wb") as file:
        file.write(header + struct.pack(f"<{height}Q", *offsets) + b"".join(lines))


def _zips(line):
    """A line as OpenEXR packs it: even bytes before odd ones, each as the difference from the one before, deflated."""
    data = numpy.frombuffer(line, numpy.uint8)
    apart = numpy.concatenate((data[0::2], data[1::2])).astype(numpy.int16)
    steps = apart.copy()
    steps[1:] = apart[1:] - apart[:-1] + 128
    packed = zlib.compress(steps.astype(numpy.uint8).tobytes(), 4)
    return packed if len(packed) < len(line) else line


def write_png(path, samples):
    """Rows of grey (height x width) or RGB (height x width x 3), uint8 or uint16, every value as it is."""
    height, width = samples.shape[:2]
    depth = 8 * samples.dtype.itemsize
    colour = 2 if samples.ndim == 3 else 0
    rows = samples.astype(samples.dtype.newbyteorder(">")).reshape(height, -1).view(numpy.uint8)
    bytes_per_pixel = samples.dtype.itemsize * (3 if colour else 1)
    filtered = numpy.empty((height, rows.shape[1] + 1), numpy.uint8)
    filtered[:, 0] = 2  # each row less the one above
    filtered[0, 0] = 1  # the first less the pixel to its left
    filtered[0, 1:] = rows[0]
    filtered[0, 1 + bytes_per_pixel:] -= rows[0, :-bytes_per_pixel]
    filtered[1:, 1:] = rows[1:] - rows[:-1]

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(filtered.tobytes(), 4)) + chunk(b"IEND", b""))
