# SPDX-License-Identifier: GPL-3.0-or-later
"""Environments that were used last, and those of a folder. No bpy."""
import json
import os

MOST = 12
KINDS = (".exr", ".hdr")


def read(file):
    """Paths that are still there, the last first."""
    try:
        with open(file, encoding="utf-8") as stream:
            found = json.load(stream)
    except (OSError, ValueError):
        return []
    return [p for p in found if isinstance(p, str) and os.path.isfile(p)] if isinstance(found, list) else []


def add(file, path):
    """Notes a path; a file that cannot be written is no matter."""
    paths = [path] + [p for p in read(file) if p != path]
    try:
        os.makedirs(os.path.dirname(file), exist_ok=True)
        with open(file, "w", encoding="utf-8") as stream:
            json.dump(paths[:MOST], stream)
    except OSError:
        pass


def of_folder(folder):
    try:
        names = sorted(os.listdir(folder)) if folder else []
    except OSError:
        return []
    return [os.path.join(folder, name) for name in names if name.lower().endswith(KINDS)]
