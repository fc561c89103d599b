# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs the add-on into the zip that Blender installs: python3 build_zip.py [-o human_material.zip]

One file for every Blender: before 4.2 as an add-on (Preferences > Add-ons > Install), from 4.2 as an extension
(Install from Disk). Equal sources give equal bytes.
"""
import argparse
import os
import zipfile

FOLDER = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "human_material")
LICENSE = os.path.join(os.path.dirname(FOLDER), "LICENSE")
EPOCH = (1980, 1, 1, 0, 0, 0)


def files():
    """(path, name in the zip), sorted."""
    found = [(LICENSE, "human_material/LICENSE")]
    for folder, folders, names in os.walk(FOLDER):
        folders[:] = [f for f in folders if f != "__pycache__"]
        found += [(os.path.join(folder, n), os.path.relpath(os.path.join(folder, n), os.path.dirname(FOLDER)))
                  for n in names if not n.endswith(".pyc")]
    return sorted(found, key=lambda pair: pair[1])


def build(output):
    with zipfile.ZipFile(output, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, name in files():
            info = zipfile.ZipInfo(name, EPOCH)
            info.external_attr = 0o644 << 16
            info.compress_type = zipfile.ZIP_DEFLATED
            with open(path, "rb") as file:
                archive.writestr(info, file.read())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", default="human_material.zip")
    build(parser.parse_args().output)
