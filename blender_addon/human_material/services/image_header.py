# SPDX-License-Identifier: GPL-3.0-or-later
"""What an image file says about itself, read without decoding it. No bpy.

Blender opens broken and foreign files without a word (a cut-off PNG is a picture of size 0, a multi-part EXR is
empty): so each file is looked at here first. Throws InputError.
"""
import os
import struct
from dataclasses import dataclass

from .errors import InputError

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
PNG_END = b"\x00\x00\x00\x00IEND\xaeB`\x82"
PNG_CHANNELS = {0: 1, 2: 3, 3: 3, 4: 1, 6: 3}   # colour type -> channels without alpha
PNG_WITH_ALPHA = (4, 6)
EXR_MAGIC = b"\x76\x2f\x31\x01"
EXR_TILED, EXR_DEEP, EXR_MULTI_PART = 0x200, 0x800, 0x1000
EXR_LINES_PER_CHUNK = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16, 6: 32, 7: 32, 8: 32, 9: 256}
EXR_HEADER_LIMIT = 1 << 20


@dataclass(frozen=True)
class Header:
    kind: str          # "PNG" or "EXR"
    width_px: int
    height_px: int
    channels: int      # without alpha
    bits: int          # of a channel
    has_alpha: bool = False


def read_header(path):
    try:
        size = os.path.getsize(path)
        with open(path, "rb") as file:
            start = file.read(8)
            file.seek(0)
            if start == PNG_SIGNATURE:
                return _png(file, path, size)
            if start[:4] == EXR_MAGIC:
                return _exr(file, path, size)
    except (OSError, struct.error, ValueError, IndexError) as error:
        raise InputError(path, "", "has a broken header (%s)" % error, "write the image again") from None
    raise InputError(path, "", "is empty" if size == 0 else "is neither PNG nor OpenEXR",
                     "write the map as PNG or EXR")


def _png(file, path, size):
    data = file.read(33)
    length, name, width, height, bits, colour = struct.unpack(">I4sIIBB", data[8:26])
    if name != b"IHDR" or length != 13 or colour not in PNG_CHANNELS:
        raise ValueError("no IHDR")
    if bits not in (8, 16) or colour == 3 and bits != 8:
        raise InputError(path, "", "has %d bits a channel" % bits, "write it with 8 or 16")
    file.seek(max(0, size - len(PNG_END)))
    if file.read() != PNG_END:
        raise InputError(path, "", "is cut off (a PNG ends with IEND)", "write the image again")
    return Header("PNG", width, height, PNG_CHANNELS[colour], bits, colour in PNG_WITH_ALPHA)


def _exr(file, path, size):
    data = file.read(EXR_HEADER_LIMIT)
    version = struct.unpack_from("<I", data, 4)[0]
    for flag, what in ((EXR_MULTI_PART, "multi-part"), (EXR_DEEP, "deep"), (EXR_TILED, "tiled")):
        if version & flag:
            raise InputError(path, "", "is a %s EXR, which is not read" % what,
                             "write one part with scan lines a file (sample_to_maps.py splits samples)")
    attributes, end = _exr_attributes(data, 8)
    window = struct.unpack("<4i", attributes["dataWindow"])
    if window != struct.unpack("<4i", attributes["displayWindow"]):
        raise InputError(path, "", "is cropped (data window differs from display window)",
                         "write the whole picture")
    channels = _exr_channels(attributes["channels"])
    width, height = window[2] - window[0] + 1, window[3] - window[1] + 1
    if width < 1 or height < 1:
        raise ValueError("window")
    _check_offsets(file, path, size, end, height, attributes["compression"][0])
    names = {name.split(".")[-1].upper() for name in channels}
    if {"R", "G", "B"} <= names:
        count = 3
    elif "Y" in names:
        count = 1
    else:
        raise InputError(path, "", "has the channels %s" % ", ".join(sorted(channels))[:100],
                         "name them R, G, B or Y")
    return Header("EXR", width, height, count, 16 if 1 in channels.values() else 32, "A" in names)


def _exr_attributes(data, at):
    attributes = {}
    while data[at] != 0:
        name_end = data.index(b"\0", at)
        type_end = data.index(b"\0", name_end + 1)
        length = struct.unpack_from("<i", data, type_end + 1)[0]
        begin = type_end + 5
        if length < 0 or begin + length >= len(data):
            raise ValueError("attributes")
        attributes[data[at:name_end].decode("latin-1")] = data[begin:begin + length]
        at = begin + length
    for needed in ("channels", "compression", "dataWindow", "displayWindow"):
        if needed not in attributes:
            raise ValueError("no " + needed)
    return attributes, at + 1


def _exr_channels(data):
    """Channel name -> pixel type (0 uint, 1 half, 2 float)."""
    channels, at = {}, 0
    while data[at] != 0:
        end = data.index(b"\0", at)
        channels[data[at:end].decode("latin-1")] = struct.unpack_from("<i", data, end + 1)[0]
        at = end + 17
    return channels


def _check_offsets(file, path, size, table_at, height, compression):
    """The line offset table of an EXR that was cut off is zero or points beyond the end."""
    count = -(-height // EXR_LINES_PER_CHUNK.get(compression, 1))
    file.seek(table_at)
    table = file.read(8 * min(count, 1 << 16))
    offsets = struct.unpack("<%dQ" % (len(table) // 8), table[:len(table) // 8 * 8])
    good = len(offsets) == min(count, 1 << 16) and all(table_at < offset < size - 8 for offset in offsets)
    if good:
        file.seek(max(offsets))
        good = max(offsets) + 8 + struct.unpack("<ii", file.read(8))[1] <= size
    if not good:
        raise InputError(path, "", "is cut off", "write the image again")
