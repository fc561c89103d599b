# SPDX-License-Identifier: GPL-3.0-or-later
"""REGIONS of a labelled scan: the command line's own result for its strokes. No bpy."""
import os
import shutil
import tempfile
import zlib

from . import jobs
from .errors import InputError
from .labelling import UNLABELLED

HEAD = '<?xml version="1.0"?>\n<strokes schema="1.0" scan_sha256="%s">\n'


def strokes_xml(strokes, sha256):
    """As `--serve` saves them."""
    lines = [HEAD % sha256]
    for time_s, stroke in enumerate(strokes):
        lines.append('  <stroke class="%s" radius_cm="%r" time_s="%d">\n'
                     % (stroke["class"], stroke["radius_cm"], time_s))
        lines += ['    <point face="%d" at="%s"/>\n' % (p[0], ",".join(repr(c) for c in p[1:]))
                  for p in stroke["points"]]
        lines.append("  </stroke>\n")
    return "".join(lines) + "</strokes>\n"


def write_strokes(path, strokes, sha256):
    """Whole or not at all. Gives the file's print_of."""
    try:
        handle, part = tempfile.mkstemp(dir=os.path.dirname(os.path.abspath(path)), suffix=".part")
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(strokes_xml(strokes, sha256))
        os.chmod(part, 0o644)
        os.replace(part, path)
        return print_of(path)
    except OSError as error:
        raise InputError(path, "", "cannot be written (%s)" % error.strerror, "choose another folder") from None


def print_of(path):
    """Tells whether a file is the one that was written."""
    with open(path, "rb") as file:
        return "%08x" % zlib.crc32(file.read())


def saving(program, scan, strokes, sha256, options, output, finish):
    """The job of `openhumanbrdf label --strokes`."""
    folder = tempfile.mkdtemp(prefix="hm_label")
    file = os.path.join(folder, "strokes.xml")
    try:
        write_strokes(file, strokes, sha256)
    except InputError:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    command = [program, "label", scan, "--strokes", file, "-o", output]
    for option, value in options.items():
        command += ["--" + option, value] if value else []
    return jobs.Job("label", "Saving", command, finish, scratch=folder)


def classes_of(output):
    """The class of each face in a REGIONS folder."""
    path = os.path.join(output, "faces.txt")
    try:
        with open(path, encoding="ascii") as file:
            values = [int(line) for line in file]
    except (OSError, ValueError):
        raise InputError(path, "", "is no list of classes") from None
    return [value if 0 <= value < 4 else UNLABELLED for value in values]
