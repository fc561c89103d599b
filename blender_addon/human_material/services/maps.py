# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads a maps folder: checked rasters of physical quantities. Leaves nothing behind in Blender."""
from array import array
from dataclasses import dataclass, field

import bpy

from . import classes, decode, image_header, maps_json
from .errors import InputError

GROW_PX = 2             # maps reach this far beyond the mask
COARSE_BITS = 8
WANTS_16_BITS = ("normal", "displacement")


@dataclass
class Maps:
    """Rasters in array('f'), row 0 at the bottom; they hold values where `known` is 1."""
    info: maps_json.MapsInfo
    mask: array               # coverage
    known: bytearray          # mask > 0, grown by GROW_PX
    normal: array             # 3, camera space, unit
    diffuse: array            # 3, linear Rec. 709
    roughness: array
    f0: array                 # normal-incidence reflectance
    sss: array
    displacement_cm: array
    shares: array             # one a class, in the order of classes.NAMES
    warnings: list = field(default_factory=list)

    @property
    def size(self):
        return self.info.width_px, self.info.height_px


def load(path):
    """Maps of a folder (or of its maps.json). Throws InputError before anything is changed."""
    info = maps_json.read(path)
    headers = {name: _checked_header(map_file, info) for name, map_file in info.maps.items()}
    rasters = {name: read_raster(map_file.path, map_file.channels, info.width_px, info.height_px)
               for name, map_file in info.maps.items()}
    warnings = ["%s has 8 bits a channel: write 16 or EXR for exact relighting" % info.maps[name].path
                for name in WANTS_16_BITS if headers[name].bits <= COARSE_BITS]
    return _decoded(info, rasters, warnings)


def _checked_header(map_file, info):
    header = image_header.read_header(map_file.path)
    if (header.width_px, header.height_px) != (info.width_px, info.height_px):
        raise InputError(map_file.path, "", "is %d x %d, maps.json says %d x %d"
                         % (header.width_px, header.height_px, info.width_px, info.height_px),
                         "all maps have one size")
    if header.kind not in map_file.kinds:
        raise InputError(map_file.path, "", "is %s, but the encoding '%s' needs %s"
                         % (header.kind, map_file.encoding, " or ".join(map_file.kinds)),
                         "correct maps.%s.encoding in maps.json" % map_file.name)
    is_fourth_in_alpha = map_file.channels == 4 and header.channels == 3 and header.has_alpha
    if header.channels < map_file.channels and not is_fourth_in_alpha:
        raise InputError(map_file.path, "", "has %d channel, %d are needed" % (header.channels, map_file.channels),
                         "write the map again")
    return header


def read_raster(path, channels, width, height):
    """The file's own numbers as array('f') of `channels` a pixel; alpha is the fourth of four, else ignored."""
    try:
        image = bpy.data.images.load(path, check_existing=False)
    except RuntimeError as error:
        raise InputError(path, "", "cannot be opened (%s)" % error, "write the image again") from None
    try:
        image.colorspace_settings.name = "Non-Color"   # before the pixels are read: it changes those of floats
        image.alpha_mode = "NONE" if channels < 4 else "CHANNEL_PACKED"
        if tuple(image.size) != (width, height):
            raise InputError(path, "", "cannot be decoded", "write the image again")
        stored = image.channels
        values = decode.zeros(width * height * stored)
        image.pixels.foreach_get(values)
    finally:
        bpy.data.images.remove(image)
    if stored == channels:
        return values
    result = decode.zeros(width * height * channels)
    for c in range(channels):
        result[c::channels] = values[min(c, stored - 1)::stored]
    return result


def _decoded(info, rasters, warnings):
    width, height = info.width_px, info.height_px
    path = {name: map_file.path for name, map_file in info.maps.items()}
    encoding = {name: map_file.encoding for name, map_file in info.maps.items()}
    mask = rasters["mask"]
    every = range(width * height)
    decode.check_finite(mask, 1, every, width, height, path["mask"])
    decode.clamp_unit(mask, 1, every, width, height, path["mask"])
    pixels = decode.covered_pixels(mask)
    if len(pixels) == 0:
        raise InputError(path["mask"], "", "covers nothing", "give the mask of the person, white on black")
    for name, values in rasters.items():
        decode.check_finite(values, info.maps[name].channels, pixels, width, height, path[name])
    for name in ("diffuse", "roughness", "specular", "sss", "classes"):
        if name in rasters:
            decode.clamp_unit(rasters[name], info.maps[name].channels, pixels, width, height, path[name])
    decode.decode_normals(rasters["normal"], pixels, encoding["normal"], path["normal"])
    decode.decode_displacement(rasters["displacement"], pixels, encoding["displacement"],
                               info.maps["displacement"].r_cm, info.camera, width, height, path["displacement"])
    decode.check_green_up(rasters["normal"], rasters["displacement"], pixels, decode.covered(mask), width, height,
                          path["normal"])
    if encoding["diffuse"] == "srgb":
        decode.decode_each(rasters["diffuse"], 3, pixels, decode.srgb_to_linear)
    decode.decode_each(rasters["specular"], 1, pixels, decode.F0_OF[encoding["specular"]])
    shares = _shares(rasters, pixels, width, height)
    known = _grown(rasters, shares, mask, info)
    return Maps(info, mask, known, rasters["normal"], rasters["diffuse"], rasters["roughness"],
                rasters["specular"], rasters["sss"], rasters["displacement"], shares, warnings)


def _shares(rasters, pixels, width, height):
    """Shares of the classes: from the map where there is one, else decoded from the materials."""
    if "classes" in rasters:
        return classes.shares_of_map(rasters["classes"], pixels)
    return classes.shares_of_materials(rasters["specular"], rasters["roughness"], rasters["sss"], pixels, width,
                                       height)


def _grown(rasters, shares, mask, info):
    """Carries every raster over the outline; returns where there are values now."""
    width, height = info.width_px, info.height_px
    for name, channels in (("normal", 3), ("diffuse", 3), ("roughness", 1), ("specular", 1), ("sss", 1),
                           (None, len(classes.NAMES))):
        known = decode.covered(mask)
        decode.grow(shares if name is None else rasters[name], channels, known, width, height, GROW_PX)
    known = decode.covered(mask)
    decode.mend_pits(rasters["displacement"], known, width, height)
    decode.grow_depth(rasters["displacement"], rasters["normal"], known, width, height, GROW_PX,
                      info.camera.frame_width_cm / width)
    decode.turn_away(rasters["normal"], mask, known)
    return known
