# SPDX-License-Identifier: GPL-3.0-or-later
"""maps.json: reading, checking and writing (docs/maps_json.md defines the format). No bpy."""
import json
import math
import os
from dataclasses import dataclass, field

from . import classes
from .errors import InputError

FILE_NAME = "maps.json"
FORMAT = "humanmaterial.maps"
VERSION = 1
MAX_BYTES = 1 << 20
MIN_SIZE_PX, MAX_SIZE_PX = 2, 4096
MAX_LENGTH_CM = 1e6

#: map -> (channels, {encoding: file kinds that can hold it}, needed)
MAPS = {
    "mask": (1, {"coverage": ("PNG", "EXR")}, True),
    "normal": (3, {"offset": ("PNG", "EXR"), "signed": ("EXR",)}, True),
    "diffuse": (3, {"srgb": ("PNG",), "linear": ("EXR",)}, True),
    "roughness": (1, {"value": ("PNG", "EXR")}, True),
    "specular": (1, {"srgb_f0": ("PNG", "EXR"), "disney08": ("PNG", "EXR"), "linear_f0": ("PNG", "EXR")}, True),
    "sss": (1, {"value": ("PNG", "EXR")}, True),
    "displacement": (1, {"offset": ("PNG", "EXR"), "signed_cm": ("EXR",)}, True),
    "classes": (len(classes.NAMES) - 1, {"shares": ("PNG", "EXR")}, False),
}


@dataclass(frozen=True)
class Camera:
    """The picture's camera, in cm (docs/maps_json.md, "Camera")."""
    type: str               # "perspective" or "orthographic"
    distance_cm: float = 0  # perspective
    half_width: float = 0   # perspective: tangent of half the horizontal field of view
    width_cm: float = 0     # orthographic
    center_y_cm: float = 0

    @property
    def frame_width_cm(self):
        """The frame's width at the centre plane."""
        return 2 * self.distance_cm * self.half_width if self.type == "perspective" else self.width_cm

    def scale_at(self, z_cm):
        """What x and y on the centre plane are multiplied by at depth z."""
        return (self.distance_cm - z_cm) / self.distance_cm if self.type == "perspective" else 1.0


@dataclass(frozen=True)
class MapFile:
    name: str       # of the map
    path: str
    encoding: str
    channels: int
    kinds: tuple    # file kinds that can hold the encoding
    r_cm: float = 0  # displacement "offset" only


@dataclass
class MapsInfo:
    folder: str
    width_px: int
    height_px: int
    camera: Camera
    maps: dict = field(default_factory=dict)   # name -> MapFile

    @property
    def name(self):
        return os.path.basename(os.path.normpath(self.folder)) or "maps"


def read(path):
    """MapsInfo of a maps folder, or of its maps.json. Throws InputError. Does not look at the images."""
    file = os.path.join(path, FILE_NAME) if os.path.isdir(path) else path
    document = _parse(file)
    _expect(document.get("format") == FORMAT, file, "format", 'is not "%s"' % FORMAT,
            "this is not a description of maps")
    version = document.get("version")
    _expect(_is_whole(version) and version == VERSION, file, "version",
            "%s is not known, only %d is" % (json.dumps(version), VERSION), "get an add-on that fits the file")
    _expect(document.get("unit") == "cm", file, "unit", 'is not "cm"', "convert the lengths to cm")
    width, height = _size(document, file)
    folder = os.path.dirname(os.path.abspath(file))
    info = MapsInfo(folder, width, height, _camera(document, file))
    entries = document.get("maps")
    _expect(isinstance(entries, dict), file, "maps", "is missing or not an object", "list the maps by name")
    for name, (channels, encodings, needed) in MAPS.items():
        if name in entries:
            info.maps[name] = _map_file(name, entries[name], channels, encodings, folder, file)
        else:
            _expect(not needed, file, "maps", "has no '%s'" % name, "add the map: all but classes are needed")
    return info


def document(size_px, camera, maps, source=None):
    """The JSON object of a maps folder. maps: name -> {"file":, "encoding":[, "r_cm":]}."""
    shape = {"type": camera.type}
    if camera.type == "perspective":
        shape.update(distance_cm=camera.distance_cm, half_width=camera.half_width)
    else:
        shape.update(width_cm=camera.width_cm)
    shape["center_y_cm"] = camera.center_y_cm
    result = {"format": FORMAT, "version": VERSION, "unit": "cm", "size_px": list(size_px), "camera": shape,
              "maps": maps, "conventions": CONVENTIONS}
    if source:
        result["source"] = source
    return result


def write(folder, content):
    """Writes maps.json whole or not at all."""
    target = os.path.join(folder, FILE_NAME)
    temporary = target + ".tmp"
    with open(temporary, "w", encoding="utf-8") as file:
        json.dump(content, file, indent=2, ensure_ascii=False)
        file.write("\n")
    os.replace(temporary, target)
    return target


CONVENTIONS = {
    "axes": "right-handed, +X right, +Y up, +Z to the viewer, soles at y = 0",
    "normal": "camera space: +X right, +Y up, +Z to the viewer; offset: (n + 1) / 2",
    "diffuse": "Rec. 709, sRGB-encoded in PNG, linear in EXR",
    "roughness": "perceptual; GGX alpha = roughness squared",
    "specular": "srgb_f0: F0 = sRGB_to_linear(S); disney08: F0 = 0.08 x; linear_f0: F0",
    "sss": "Principled subsurface; scattering radius = sss x (1.0, 0.2, 0.1) cm",
    "displacement": "signed cm from the plane z = 0, positive towards the camera; offset: 0.5 + d / (2 r_cm)",
    "mask": "share of the pixel that is covered; the other maps are averages over the covered part",
}


# Checks -------------------------------------------------------------------------------------------------

def _expect(condition, file, place, cause, mend):
    if not condition:
        raise InputError(file, place, cause, mend)


def _is_number(value):
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:   # a whole number beyond any float
        return False


def _is_whole(value):
    return isinstance(value, int) and not isinstance(value, bool)


def _parse(file):
    if not os.path.isfile(file):
        raise InputError(file, "", "there is no such file", "choose a folder with maps.json in it")
    try:
        with open(file, "rb") as stream:
            data = stream.read(MAX_BYTES + 1)
        _expect(len(data) <= MAX_BYTES, file, "", "is larger than 1 MiB", "this is not a description of maps")
        result = json.loads(data.decode("utf-8-sig"))
    except json.JSONDecodeError as error:
        raise InputError(file, "line %d, column %d" % (error.lineno, error.colno),
                         "is not JSON (%s)" % error.msg, "write the file again") from None
    except (UnicodeDecodeError, RecursionError, ValueError):
        raise InputError(file, "", "is not JSON in UTF-8", "write the file again") from None
    except OSError as error:
        raise InputError(file, "", "cannot be read (%s)" % error.strerror, "check its permissions") from None
    _expect(isinstance(result, dict), file, "", "is not a JSON object", "see docs/maps_json.md")
    return result


def _size(document, file):
    size = document.get("size_px")
    good = isinstance(size, list) and len(size) == 2 and all(
        _is_whole(n) and MIN_SIZE_PX <= n <= MAX_SIZE_PX for n in size)
    _expect(good, file, "size_px", "is not [width, height] with whole numbers from %d to %d"
            % (MIN_SIZE_PX, MAX_SIZE_PX), "write the size of the maps in pixels")
    return size[0], size[1]


def _length(owner, key, file, place):
    value = owner.get(key)
    _expect(_is_number(value) and 0 < value <= MAX_LENGTH_CM, file, place + "." + key,
            "is missing or not a number above 0", "see docs/maps_json.md")
    return float(value)


def _camera(document, file):
    camera = document.get("camera")
    _expect(isinstance(camera, dict), file, "camera", "is missing or not an object", "see docs/maps_json.md")
    center = camera.get("center_y_cm", 0)
    _expect(_is_number(center) and abs(center) <= MAX_LENGTH_CM, file, "camera.center_y_cm",
            "is not a number", "write cm above the ground")
    kind = camera.get("type")
    if kind == "perspective":
        return Camera(kind, distance_cm=_length(camera, "distance_cm", file, "camera"),
                      half_width=_length(camera, "half_width", file, "camera"), center_y_cm=float(center))
    _expect(kind == "orthographic", file, "camera.type", 'is neither "perspective" nor "orthographic"',
            "see docs/maps_json.md")
    return Camera(kind, width_cm=_length(camera, "width_cm", file, "camera"), center_y_cm=float(center))


def _map_file(name, entry, channels, encodings, folder, file):
    place = "maps." + name
    _expect(isinstance(entry, dict), file, place, "is not an object", 'write {"file": ..., "encoding": ...}')
    encoding = entry.get("encoding")
    _expect(isinstance(encoding, str) and encoding in encodings, file, place + ".encoding",
            "%s is not known" % json.dumps(encoding)[:80], "write " + " or ".join(encodings))
    relative = entry.get("file")
    _expect(isinstance(relative, str) and relative != "" and "\0" not in relative, file, place + ".file",
            "is missing or not a file name", "write the name of the image")
    path = os.path.normpath(os.path.join(folder, relative))
    inside = not os.path.isabs(relative) and os.path.realpath(path).startswith(os.path.realpath(folder) + os.sep)
    _expect(inside, file, place + ".file", "lies outside the folder", "put the image beside maps.json")
    _expect(os.path.isfile(path), path, "", "there is no such file (maps.%s)" % name,
            "write the map or correct its name in maps.json")
    r_cm = _length(entry, "r_cm", file, place) if (name, encoding) == ("displacement", "offset") else 0
    return MapFile(name, path, encoding, channels, encodings[encoding], r_cm)
