# SPDX-License-Identifier: GPL-3.0-or-later
"""What the programs are asked for by the panels Bake, Produce and Validate, and what they bring. No bpy."""
import json
import os

from . import jobs
from .errors import InputError

VERDICTS = (0, 1, 3)   # exit codes of `validate` that come with a report: pass, difference, undecided
MADE = (0, 1)          # of `produce`: all, or all but those that it names


def expect(path, name, is_there=os.path.isdir):
    """Raises InputError where a field is empty or names nothing."""
    if not path:
        raise InputError("", name, "is empty", "choose one")
    if not is_there(path):
        raise InputError(path, name, "is not there", "choose another")
    return path


def output(path, name):
    """A folder that can be made."""
    if not path:
        raise InputError("", name, "is empty", "choose where to write")
    path = os.path.abspath(path)
    expect(os.path.dirname(path), "the folder around " + os.path.basename(path))
    return path


def bake(program, scan, regions, model, size_px=0, delight=False):
    command = [program, "bake", expect(scan, "Scan", os.path.isfile), "--regions", expect(regions, "Regions"),
               *(["--size", size_px] if size_px else []), *(["--delight"] if delight else []),
               "-o", output(model, "Model")]
    return jobs.Job("bake", "Baking", command, lambda _: "Baked %s" % os.path.basename(model))


def produce(program, plan, dataset, workers=1):
    command = [program, "produce", expect(plan, "Plan", os.path.isfile), "--workers", workers,
               "-o", output(dataset, "Dataset")]
    return jobs.Job("produce", "Producing", command, lambda said: first_line(said) or "Produced", accepted=MADE)


def forecast(program, plan):
    command = [program, "produce", expect(plan, "Plan", os.path.isfile), "--dry-run"]
    return jobs.Job("produce", "Trying out", command, lambda said: " ".join(said.split()))


def page(program, dataset, finish):
    """Thumbnails of a dataset beside it; finish(folder) -> words."""
    folder = page_of(dataset)
    command = [program, "export", expect(dataset, "Dataset"), "--page", "-o", folder]
    return jobs.Job("produce", "Gathering samples", command, lambda _: finish(folder))


def page_of(dataset):
    return os.path.abspath(dataset) + ".page"


def validate(program, model, environment, report, options):
    """options: those of the command by their names; empty ones are left out."""
    command = [program, "validate", expect(model, "Model"), "--environment",
               expect(environment, "Environment", os.path.isfile), "--keep-scene"]
    for option, value in options.items():
        command += ["--" + option, value] if value else []
    folder = output(report, "Report")
    return jobs.Job("validate", "Comparing", command + ["-o", folder], lambda _: verdict_of(folder),
                    accepted=VERDICTS)


def verdict_of(report):
    """What validate.json says, in its sentence."""
    path = os.path.join(report, "validate.json")
    try:
        with open(path, encoding="utf-8") as file:
            report = json.load(file)
        return "%s: %s" % (report["verdict"].capitalize(), report["sentence"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise InputError(path, "", "is no report of validate",
                         "choose the program of the add-on's version") from None


def first_line(text):
    return next((line.strip() for line in text.splitlines() if line.strip()), "")
