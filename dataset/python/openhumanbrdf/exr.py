"""One sample: a multi-part EXR with a mask, its maps, the classes and one picture a light (docs/commands/render.md)."""
import json
import os
from pathlib import Path
from typing import NamedTuple

import numpy as np


class DatasetError(ValueError):
    """A file or folder that cannot be read as a dataset: one line that says where, what and what to do."""

    def __init__(self, words):
        super().__init__(" ".join(words.splitlines()))     # names of files may have several


class Field(NamedTuple):
    channels: tuple     # in the order of the array's last axis
    unit: str
    meaning: str


LIGHT = "relit."
# Written by `dump_sample --fields` from the table that the C++ programs use.
_STORED = json.loads((Path(__file__).parent / "fields.json").read_text(encoding="utf-8"))
FIELDS = {name: Field(tuple(field["channels"]), field["unit"], field["meaning"]) for name, field in _STORED.items()}


def _openexr():
    try:
        import OpenEXR
    except ImportError as error:
        raise ImportError("openhumanbrdf reads EXR files with the OpenEXR package: pip install 'OpenEXR>=3.3' "
                          "(Debian 12 has none that reads several parts)") from error
    if not hasattr(OpenEXR, "File"):
        raise ImportError("this OpenEXR package reads one part of a file only: pip install 'OpenEXR>=3.3'")
    return OpenEXR


def _parts(path, header_only):
    openexr, path = _openexr(), os.fsdecode(path)
    if not os.path.isfile(path):    # a pipe would be waited for
        raise DatasetError("%s: no such file; check the path" % path)
    try:
        return openexr.File(path, separate_channels=True, header_only=header_only).parts
    except Exception as error:      # the package throws whatever the library did
        raise DatasetError("%s: is no sample that can be read: %s; render it again" % (path, str(error).splitlines()[0])) from None


def _attributes(part):
    return {name: value for name, value in part.header.items() if name.startswith("ohb:") and isinstance(value, str)}


def read_attributes(path):
    """The header's ohb:... attributes as {name: text}, without the pixels."""
    return _attributes(_parts(path, header_only=True)[0])


def _array(part, field, path, name):
    planes = []
    for channel in field.channels:
        if channel not in part.channels:
            raise DatasetError("%s: part '%s' has no channel '%s'; render it again" % (path, name, channel))
        planes.append(np.asarray(part.channels[channel].pixels, np.float32))
    array = planes[0] if len(planes) == 1 else np.stack(planes, -1)
    if not np.isfinite(array).all():
        raise DatasetError("%s: part '%s' has values that are NaN or infinite; render it again" % (path, name))
    return array


def read_sample(path, maps=None, lights=None):
    """({map: array}, {light: array}, attributes) of one file.

    Arrays are float32 with row 0 at the top: (height, width) for one channel, else (height, width, channels) in the
    order of FIELDS. `maps` and `lights` choose by name; None: all. Throws DatasetError.
    """
    parts = {part.name(): part for part in _parts(path, header_only=False)}
    wanted = [name for name in FIELDS if name != "relit"] if maps is None else list(maps)
    arrays = {}
    for name in wanted:
        if name not in FIELDS or name == "relit":
            raise DatasetError("'%s' is no map: choose from %s" % (name, ", ".join(n for n in FIELDS if n != "relit")))
        if name not in parts:
            raise DatasetError("%s: part '%s' is missing; render it again" % (path, name))
        arrays[name] = _array(parts[name], FIELDS[name], path, name)
    there = [name[len(LIGHT):] for name in parts if name.startswith(LIGHT)]
    chosen = there if lights is None else list(lights)
    for name in chosen:
        if name not in there:
            raise DatasetError("%s: has no light '%s': it has %s" % (path, name, ", ".join(there) or "none"))
    relit = {name: _array(parts[LIGHT + name], FIELDS["relit"], path, LIGHT + name) for name in chosen}
    sizes = {array.shape[:2] for array in [*arrays.values(), *relit.values()]}
    if len(sizes) > 1:
        raise DatasetError("%s: its parts have several sizes; render it again" % path)
    return arrays, relit, _attributes(next(iter(parts.values())))
