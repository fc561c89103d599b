"""Maps folders of a made-up person: a bump in the frame, its four quarters of the four classes."""
import json
import math
import os

from support import image_files

TABLE = ((0.184, 0.4, 0.08), (0.239, 0.5, 0.0), (0.263, 0.85, 0.0), (0.224, 0.25, 0.0))   # S, roughness, sss
COLORS = ((0.6, 0.4, 0.3), (0.12, 0.08, 0.05), (0.2, 0.3, 0.5), (0.3, 0.15, 0.1))
PERSPECTIVE = {"type": "perspective", "distance_cm": 400.0, "half_width": 0.2, "center_y_cm": 80.0}
ORTHOGRAPHIC = {"type": "orthographic", "width_cm": 160.0, "center_y_cm": 80.0}
RADIUS = 0.7    # of the person, in half frames


class Person:
    """Analytic maps, rows from the top. camera: the JSON object of maps.json."""

    def __init__(self, width=32, height=32, camera=PERSPECTIVE, flat=False):
        self.width, self.height, self.camera, self.flat = width, height, camera, flat
        self.frame_cm = (2 * camera["distance_cm"] * camera["half_width"] if camera["type"] == "perspective"
                         else camera["width_cm"])

    def place(self, x, y):
        """Of a pixel's centre, in half frame widths, +Y up."""
        return (2 * x + 1 - self.width) / self.width, (self.height - 2 * y - 1) / self.width

    def covered(self, x, y):
        return math.hypot(*self.place(x, y)) < RADIUS

    def depth_cm(self, x, y):
        u, v = self.place(x, y)
        return 0.0 if self.flat else 20.0 * math.cos(2 * u) * math.cos(2 * v)

    def normal(self, x, y):
        u, v = self.place(x, y)
        n = (0.0, 0.0, 1.0) if self.flat else (0.6 * u, 0.6 * v, 1.0)
        length = math.sqrt(sum(c * c for c in n))
        return tuple(c / length for c in n)

    def class_of(self, x, y):
        u, v = self.place(x, y)
        return (u > 0) + 2 * (v > 0)

    def raster(self, function):
        """Values of every pixel in one list; 0 where nothing is covered."""
        result = []
        for y in range(self.height):
            for x in range(self.width):
                value = function(x, y)
                value = value if isinstance(value, tuple) else (value,)
                result += value if self.covered(x, y) else (0.0,) * len(value)
        return result

    def maps(self):
        """name -> values, physical: normals signed, albedo linear, displacement in cm."""
        return {"mask": self.raster(lambda x, y: 1.0),
                "normal": self.raster(self.normal),
                "diffuse": self.raster(lambda x, y: COLORS[self.class_of(x, y)]),
                "roughness": self.raster(lambda x, y: TABLE[self.class_of(x, y)][1]),
                "specular": self.raster(lambda x, y: TABLE[self.class_of(x, y)][0]),
                "sss": self.raster(lambda x, y: TABLE[self.class_of(x, y)][2]),
                "displacement": self.raster(self.depth_cm)}


ENCODINGS = {"mask": "coverage", "normal": "signed", "diffuse": "linear", "roughness": "value",
             "specular": "srgb_f0", "sss": "value", "displacement": "signed_cm"}


def write(folder, person, changed=None):
    """A maps folder of EXR files. changed: map name -> values instead. Returns the content of maps.json."""
    os.makedirs(folder, exist_ok=True)
    entries = {}
    for name, values in {**person.maps(), **(changed or {})}.items():
        channels = "RGB" if name in ("normal", "diffuse", "classes") else "Y"
        image_files.exr(os.path.join(folder, name + ".exr"), person.width, person.height, values, channels)
        entries[name] = {"file": name + ".exr", "encoding": ENCODINGS.get(name, "shares")}
    content = {"format": "humanmaterial.maps", "version": 1, "unit": "cm",
               "size_px": [person.width, person.height], "camera": person.camera, "maps": entries}
    write_json(folder, content)
    return content


def write_png(folder, person, r_cm=100.0, bits=16):
    """The same in PNG, as an estimate writes it."""
    os.makedirs(folder, exist_ok=True)
    top = (1 << bits) - 1
    to_code = {"normal": lambda v: (v + 1) / 2, "displacement": lambda v: 0.5 + v / (2 * r_cm),
               "diffuse": lambda v: v * 12.92 if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055}
    entries = {}
    for name, values in person.maps().items():
        code = to_code.get(name, lambda v: v)
        image_files.png(os.path.join(folder, name + ".png"), person.width, person.height,
                        [round(top * code(v)) for v in values], 3 if name in ("normal", "diffuse") else 1, bits)
        entries[name] = {"file": name + ".png",
                         "encoding": {"normal": "offset", "diffuse": "srgb", "displacement": "offset"}.get(
                             name, ENCODINGS[name])}
    entries["displacement"]["r_cm"] = r_cm
    content = {"format": "humanmaterial.maps", "version": 1, "unit": "cm",
               "size_px": [person.width, person.height], "camera": person.camera, "maps": entries}
    write_json(folder, content)
    return content


def write_json(folder, content):
    with open(os.path.join(folder, "maps.json"), "w", encoding="utf-8") as file:
        json.dump(content, file)


def environment(path, direction=None, width=64, sky=0.0, peak=1000.0):
    """An environment that is `sky` all over, with one bright texel towards a direction (our axes)."""
    height = width // 2
    values = [sky] * (3 * width * height)
    if direction is not None:
        x, y, z = direction
        u, v = 0.5 + math.atan2(z, x) / (2 * math.pi), math.acos(y) / math.pi
        at = 3 * (min(height - 1, int(v * height)) * width + int(u * width) % width)
        values[at:at + 3] = [peak] * 3
    image_files.exr(path, width, height, values)
