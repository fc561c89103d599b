"""Folders of samples: one that `render` wrote, a folder of such, or a dataset that `produce` wrote."""
import hashlib
import json
import os
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path, PurePosixPath

from .exr import DatasetError, read_attributes, read_sample

VIEW = re.compile(r"view_\d{3,}\.exr")
SCHEMA = 1


class Sample(dict):
    """{map: array}, with the pictures as `lights` {name: array}, and person, split, view, file and attributes."""

    def __init__(self, arrays, lights, attributes, entry):
        super().__init__(arrays)
        self.lights, self.attributes = lights, attributes
        self.person, self.split, self.file = entry.person, entry.split, entry.file
        self.view = _number_of(entry.file.name)

    def __repr__(self):
        maps = ", ".join("%s %s" % (name, array.shape) for name, array in self.items())
        return "Sample(%s, view %d: %s; lights: %s)" % (self.person, self.view, maps, ", ".join(self.lights))


class Entry:
    def __init__(self, file, person, split):
        self.file, self.person, self.split = file, person, split


def _number_of(name):
    return int(name[len("view_"):-len(".exr")])


def _read_json(file):
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise DatasetError("%s: is damaged (%s); render the folder again" % (file, error)) from None


def _listing(folder):
    """(identity, settings, file names) that render.json states."""
    file = folder / "render.json"
    if not file.is_file():
        raise DatasetError("%s: has no render.json: rendering was not finished, or it is no folder of samples; "
                           "give the render command again" % folder)
    listing = _read_json(file)
    try:
        views = sorted(view["file"] for view in listing["views"])
        identity, settings = listing["identity"], dict(listing["settings"])
    except (KeyError, TypeError, ValueError):
        raise DatasetError("%s: does not say which views it has; render the folder again" % file) from None
    if len(set(views)) != len(views):
        raise DatasetError("%s: lists a view twice; render the folder again" % file)
    for name in views:
        if not isinstance(name, str) or not VIEW.fullmatch(name):
            raise DatasetError("%s: lists '%s', which is no view; render the folder again" % (file, name))
    return identity, settings, views


def identity_of(attributes):
    """SHA-256 of the settings that all views of a folder share, as the C++ reader computes it."""
    own = ("ohb:view", "ohb:turn_deg", "ohb:identity")
    found = ("ohb:reached.", "ohb:needs.", "ohb:set.")
    shared = sorted((name, value) for name, value in attributes.items() if name not in own and not name.startswith(found))
    return hashlib.sha256("".join("%s=%s\n" % pair for pair in shared).encode("utf-8", "surrogateescape")).hexdigest()


def _check_whole(folder, views):
    """Every listed view is there, and no other."""
    there = {file.name for file in folder.iterdir() if VIEW.fullmatch(file.name)}
    missing, strays = sorted(set(views) - there), sorted(there - set(views))
    if missing:
        raise DatasetError("%s: %d of its views are missing, first %s; render it again" % (folder, len(missing), missing[0]))
    if strays:
        raise DatasetError("%s: holds %s, which render.json does not list: rendering was not finished, or views of other "
                           "settings are mixed in; finish it, or move them away" % (folder, strays[0]))


def _dataset_people(root):
    """(id, split, folder of views, whether it is finished) of each person in dataset.xml."""
    file = root / "dataset.xml"
    try:
        tree = ElementTree.parse(file).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise DatasetError("%s: is damaged (%s); run produce again" % (file, error)) from None
    if tree.tag != "dataset" or not re.fullmatch("[0-9]{1,9}", tree.get("schema", "")):
        raise DatasetError("%s: is no list of a dataset; give the folder that produce wrote" % file)
    if int(tree.get("schema")) > SCHEMA:
        raise DatasetError("%s: is of schema %s, newer than %d; use a newer openhumanbrdf package" % (file, tree.get("schema"), SCHEMA))
    for person in tree.iter("person"):
        try:
            name, views = person.attrib["id"], PurePosixPath(person.attrib["views"])
            missing = int(person.attrib["planned_sets"]) - int(person.attrib["sets"])
        except (KeyError, ValueError):
            raise DatasetError("%s: a person lacks id, views, sets or planned_sets; run produce again" % file) from None
        if views.is_absolute() or ".." in views.parts:
            raise DatasetError("%s: the views of '%s' lie outside of the dataset: %s; do not use it" % (file, name, views))
        yield name, person.get("split", ""), root / views, missing


def _names(given):
    """Names as a list, which may be gone through again and again: a single one, a generator; None stays."""
    return [given] if isinstance(given, str) else None if given is None else list(given)


class Dataset:
    """The samples below a folder, ordered by person and view: dataset[i] is a Sample, dataset[i:k] a list of them.

    split: "train", "val" or "test" of a dataset that produce wrote; None: all.
    people: ids; None: all. maps, lights: names to read; None: all that a sample has.
    unfinished: take the sets that are there of people whom produce has not finished.

    Only views that render.json lists are used. Throws DatasetError for folders that are not finished, or hold views of
    several settings.
    """

    def __init__(self, path, split=None, people=None, maps=None, lights=None, unfinished=False):
        if not path:
            raise DatasetError("the name of the folder is empty; give one that render or produce wrote")
        self.path, self.maps, self.lights = Path(os.fsdecode(path)), _names(maps), _names(lights)
        self.entries = []
        try:
            self._add_all(split, _names(people), unfinished)
        except OSError as error:
            raise DatasetError("%s: cannot be read (%s); check the path and its permissions" % (self.path, error)) from None

    def _add_all(self, split, people, unfinished):
        if not self.path.is_dir():
            raise DatasetError("%s: no such folder; give one that render or produce wrote" % self.path)
        there = set()
        for name, of_split, folder in self._folders(unfinished):
            there.add(name)
            if (split is None or of_split == split) and (people is None or name in people):
                self._add(folder, name, of_split)
        unknown = sorted(set(people or ()) - there)
        if unknown:
            raise DatasetError("%s: has no samples of '%s'; people says whose are wanted" % (self.path, unknown[0]))
        if not self.entries:
            raise DatasetError("%s: holds no samples%s; write them with openhumanbrdf render or produce" %
                               (self.path, "" if split is None and people is None else " of that split or of these people"))

    def _folders(self, unfinished):
        if (self.path / "dataset.xml").is_file():
            for name, split, folder, missing in _dataset_people(self.path):
                if missing > 0 and not unfinished:
                    raise DatasetError("%s: '%s' lacks %d sets: give the produce command again, or read what is there with "
                                       "unfinished=True" % (self.path, name, missing))
                if (folder / "render.json").is_file() or missing <= 0:
                    yield name, split, folder
            return
        if any(VIEW.fullmatch(file.name) for file in self.path.iterdir()) or (self.path / "render.json").is_file():
            yield self._person_of(self.path), "", self.path
            return
        for folder in sorted({file.parent for file in self.path.rglob("view_*.exr") if VIEW.fullmatch(file.name)}):
            yield self._person_of(folder), "", folder

    @staticmethod
    def _person_of(folder):
        return _listing(folder)[1].get("ohb:human", folder.name)

    def _add(self, folder, name, split):
        identity, settings, views = _listing(folder)
        if identity_of(settings) != identity:
            raise DatasetError("%s: its settings are not those of its identity: it was changed; render the folder again" %
                               (folder / "render.json"))
        _check_whole(folder, views)
        for view in views:
            found = read_attributes(folder / view)
            if found.get("ohb:identity") != identity or identity_of(found) != identity:
                raise DatasetError("%s: is of other settings than render.json beside it states; keep views of one setting in "
                                   "a folder" % (folder / view))
            number = str(_number_of(view))
            if found.get("ohb:view", number) != number:
                raise DatasetError("%s: is view %s by what it holds: it was renamed or copied; render the folder again" %
                                   (folder / view, found["ohb:view"]))
        self.entries += [Entry(folder / view, name, split) for view in views]

    def __len__(self):
        return len(self.entries)

    def __getitem__(self, index):
        if isinstance(index, slice):
            return [self[i] for i in range(len(self))[index]]
        entry = self.entries[index]
        return Sample(*read_sample(entry.file, self.maps, self.lights), entry)

    @property
    def people(self):
        return sorted({entry.person for entry in self.entries})

    def __repr__(self):
        return "Dataset(%s: %d samples of %d people)" % (self.path, len(self), len(self.people))
