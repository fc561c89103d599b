# SPDX-License-Identifier: GPL-3.0-or-later
"""Relights many persons under many lights in one Blender, without a window.

    blender -b -noaudio --factory-startup [-t THREADS] --python-exit-code 1 --python relight_batch.py -- \\
        MAPS... --environment E.exr [--environment F.exr]... [--rotation A,B,...] [--format png|exr] \\
        [options of relight.py: --strength --edit --size --spp --seed --background --subsurface --jump ...] -o FOLDER

MAPS...         maps folders; their names must differ
-o              folder for the pictures, made if need be: MAPS_ENVIRONMENT_ROTATION.png. Pictures that are there already
                are left, so that a batch that was stopped goes on

A person that cannot be read is said and left out; the others are rendered. Exit codes: 0 all pictures are there; 2 bad
usage, or at least one picture is not; 75 the disk is full; 70 a bug.
"""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import relight  # noqa: E402


def split(arguments):
    """(maps folders, environments, rotations, format, output folder, what goes on to relight.py)."""
    maps, environments, rotations, kind, output, rest = [], [], [0.0], "png", None, []
    left = list(arguments)
    while left:
        word = left.pop(0)
        if word in ("-o", "--output", "--environment", "--rotation", "--format"):
            if not left:
                raise relight.InputError("", word, "has no value", "see the head of relight_batch.py")
            value = left.pop(0)
            if word == "--environment":
                environments.append(value)
            elif word == "--rotation":
                rotations = numbers(value)
            elif word == "--format":
                kind = value
            else:
                output = value
        elif word.startswith("-"):
            rest += [word, *left[:1]]
            del left[:1]
        else:
            maps.append(word)
    if not maps or not environments or output is None or kind not in ("png", "exr"):
        raise relight.InputError("", "relight_batch", "needs MAPS..., --environment and -o FOLDER",
                                 "see the head of relight_batch.py")
    return maps, environments, rotations, kind, output, rest


def numbers(text):
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise relight.InputError("", "--rotation " + text, "are no numbers", "write degrees: 0,90,180") from None


def stem(path):
    return os.path.splitext(os.path.basename(os.path.normpath(path)))[0]


def jobs(maps, environments, rotations, kind, output):
    """(maps, environment, rotation, picture), in the order of the maps."""
    found = [(m, e, r, os.path.join(output, "%s_%s_%g.%s" % (stem(m), stem(e), r, kind)))
             for m in maps for e in environments for r in rotations]
    pictures = [job[3] for job in found]
    double = next((p for p in pictures if pictures.count(p) > 1), None)
    if double is not None:
        raise relight.InputError(double, "", "would be written twice", "give maps and environments names that differ")
    return found


def main(arguments):
    try:
        maps, environments, rotations, kind, output, rest = split(arguments)
        found = jobs(maps, environments, rotations, kind, output)
        os.makedirs(output, exist_ok=True)
    except (relight.InputError, OSError) as error:
        relight.say(str(error))
        return relight.BAD_INPUT
    missing = 0
    for k, (folder, environment, rotation, picture) in enumerate(found):
        if os.path.exists(picture):
            continue
        status = relight.main([folder, "--environment", environment, "--rotation", str(rotation), *rest, "-o", picture])
        if status in (relight.TRY_AGAIN, relight.BUG):
            return status
        missing += status != relight.DONE
        relight.say("%d of %d: %s" % (k + 1, len(found), picture if status == relight.DONE else "left out"))
    return relight.BAD_INPUT if missing else relight.DONE


if __name__ == "__main__":
    sys.exit(main(relight.own_arguments()))
