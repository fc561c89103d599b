#!/usr/bin/env python3
# Six maps from a high-resolution source: our bake beside Blender's six bakes of the same pair, in one run, and how
# far both normal maps are from the source.
#   tests/bench/bake_bench.py --program build/release/bin/openhumanbrdf [--size 4096] [--threads 2] [--scan SCAN]
#                             [--blender PATH] [--folder KEEP]
# Prints seconds of the whole processes (wall and CPU of all threads), their ratios and the angular errors. Needs an idle machine for wall times; CPU times bear some load.
import argparse
import os
import resource
import subprocess
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
EXTRUSION_CM = 2


def timed(label, command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.time()
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    wall = time.time() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        raise SystemExit(f"{label} failed:\n{done.stdout[-2000:]}")
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    print(f"{label}: {wall:.1f} s, CPU {cpu:.1f} s", flush=True)
    return wall, cpu, done.stdout


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    parser.add_argument("--blender", default="blender")
    parser.add_argument("--size", default="4096")
    parser.add_argument("--threads", default="2", help="of either program")
    parser.add_argument("--scan", help="default: the example human")
    parser.add_argument("--folder", help="keep the pair and the maps here")
    options = parser.parse_args()
    temporary = tempfile.TemporaryDirectory()
    folder = options.folder or temporary.name
    # Debian's Blender takes the first python3 in PATH for its own: it must be Debian's, which has numpy.
    os.environ["PATH"] = "/usr/bin:" + os.environ["PATH"]
    blender = [options.blender, "-b", "-noaudio", "--factory-startup", "--python-exit-code", "1", "--python"]
    low, high = os.path.join(folder, "low.obj"), os.path.join(folder, "high.obj")
    if not os.path.exists(high):
        pair = [os.path.join(HERE, "make_bake_pair.py"), "--", folder] + ([options.scan] if options.scan else [])
        subprocess.run(blender + pair, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with open(low, encoding="utf-8") as file:
        faces = sum(line.startswith("f ") for line in file)
    classes = os.path.join(folder, "classes.txt")
    with open(classes, "w", encoding="utf-8") as file:
        file.write("2\n" * faces)
    work = tempfile.mkdtemp(dir=folder)
    regions, model = os.path.join(work, "regions"), os.path.join(work, "model")
    subprocess.run([options.program, "label", low, "--faces", classes, "-o", regions], check=True,
                   stdout=subprocess.DEVNULL)
    bake = [options.program, "bake", low, "--regions", regions, "--source", high, "--unit", "cm", "--size", options.size,
            "--threads", options.threads, "-o", model]
    # Before and after, since what else the machine does changes within minutes.
    before = timed("ours", bake)
    theirs = timed("Blender, six bakes", blender[:1] + ["-t", options.threads] + blender[1:] + [
        os.path.join(HERE, "blender_bakes.py"), "--", low, high, options.size, str(EXTRUSION_CM), work])
    after = timed("ours", bake)
    ours = [(b + a) / 2 for b, a in zip(before[:2], after[:2])]
    print(f"Blender over ours: {theirs[0] / ours[0]:.1f} in wall time, {theirs[1] / ours[1]:.1f} in CPU time")
    found = next(os.path.join(base, "normal.exr") for base, _, files in os.walk(os.path.join(model, "maps"))
                 if "normal.exr" in files)
    _, _, error = timed("angular errors", blender + [
        os.path.join(HERE, "normal_error.py"), "--", low, high, found + ":signed",
        os.path.join(work, "normal.exr") + ":encoded"])
    print("".join(line + "\n" for line in error.splitlines() if line.startswith("angular error")), end="")


if __name__ == "__main__":
    main()
