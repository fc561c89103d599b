"""From a scan to Blender and back: a person is labelled, baked and rendered, and the sample's maps, relit in Blender,
are the sample's picture to at least 29 dB (docs/measurements/blender.md has the exact figures, with less noise).

    python3 round_trip_test.py PROGRAM BLENDER HUMANS ENVIRONMENT FOLDER

Exits 77 (skipped) where the humans or oiiotool are not there.
"""
import os
import shutil
import subprocess
import sys

SKIPPED = 77
LEAST_DB = 29
PEOPLE = ("f25_casual", "m48_suit")
SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "blender", "round_trip.py")


def run(*command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        print(done.stdout)
        sys.exit("failed (%d): %s" % (done.returncode, " ".join(command)))
    return done.stdout


def round_trip(person, program, blender, humans, environment, folder):
    scan = os.path.join(humans, person, person + "_scan.obj")
    regions, model, samples = (os.path.join(folder, person, name) for name in ("regions", "model", "samples"))
    run(program, "label", scan, "--faces", scan[:-4] + ".labels.txt", "--classes", "skin,hair,fabric,leather",
        "-o", regions)
    run(program, "bake", scan, "--regions", regions, "--size", "1024", "-o", model)
    run(program, "render", model, "--environment", environment, "--size", "256", "--spp", "96", "-o", samples)
    text = run(blender, "-b", "-noaudio", "--factory-startup", "--python-exit-code", "1", "--python", SCRIPT, "--",
               os.path.join(samples, "view_000.exr"), environment, "--spp", "64", "--least", str(LEAST_DB),
               "-o", os.path.join(folder, person, "relit"))
    print(person, *[line for line in text.splitlines() if line.startswith("round trip")])


def main(program, blender, humans, environment, folder):
    if not os.path.isdir(humans) or shutil.which("oiiotool") is None:
        print("skipped: %s or oiiotool is not there" % humans)
        return SKIPPED
    shutil.rmtree(folder, ignore_errors=True)
    for person in PEOPLE:
        round_trip(person, program, blender, humans, environment, folder)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
