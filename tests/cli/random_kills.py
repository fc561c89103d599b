"""Kills commands at random moments and gives the same command again: equal bytes, and nothing left behind.

usage: random_kills.py OPENHUMANBRDF HUMANMATERIAL [--kills N] [--seed S] [--no-blender] [--only COMMAND]

Each command runs to its end twice first. Files that differ between the two (times are in them) are compared by name,
all others by their bytes. Then each kill (SIGKILL, at a moment between the start and a little after the usual end) is
followed by a look at what is there (an output of one step is whole or absent), by the same command, and by a
comparison of the whole folder, hidden files and the temporary folder included. Half of the kills meet an output of an
earlier run. All 200 kills take about half an hour on two cores.
"""
import argparse
import hashlib
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from small_scene import write_hdr, write_scan  # noqa: E402

SOURCE = Path(__file__).parents[2]
DONE, DIFFERENCE, UNDECIDED = 0, 1, 3    # the last two are verdicts of validate


class Command:
    """weight: its share of the kills. in_one_step: its output appears whole (others grow, view by view). timed: times
    are in all its files."""
    def __init__(self, name, weight, arguments, needs_blender=False, in_one_step=True, timed=False):
        self.timed = timed
        self.name, self.weight, self.arguments = name, weight, [str(a) for a in arguments]
        self.needs_blender, self.in_one_step = needs_blender, in_one_step
        self.digest, self.varying, self.seconds = {}, set(), 0.0


def commands_of(program, learner, folder, out):
    scan, grey = folder / "scan.obj", folder / "grey.hdr"
    weights = sorted((SOURCE / "assets" / "weights").glob("*.safetensors"))
    photo = folder / "samples" / "ada" / "previews"
    estimate = [learner, "estimate", photo / "view_000.relit.grey.png", "--mask", photo / "view_000.mask.png", "--weights",
                *weights, "--size", 64, "-o"]
    return [
        Command("label", 30, [program, "label", scan, "-o", out / "regions"]),
        Command("bake", 30, [program, "bake", scan, "--regions", folder / "regions", "--size", 256, "-o", out / "model"]),
        Command("render", 35, [program, "render", folder / "model", "--environment", grey, "--size", 48, "--spp", 8, "--views", 6,
                               "-o", out / "samples"], in_one_step=False),
        Command("chart bake", 20, [program, "chart", "bake", scan, "--regions", folder / "regions", "--environment", grey,
                                   "--size", 32, "--spp", 8, "--map-sizes", 32, 16, "-o", out / "chart"], timed=True),
        Command("chart speed-accuracy", 5, [program, "chart", "speed-accuracy", folder / "model", "--environment", grey, "--size",
                                            16, "--max-spp", 4, "--seeds", 2, "-o", out / "speed"], needs_blender=True,
                timed=True),
        Command("validate", 8, [program, "validate", folder / "model", "--environment", grey, "--size", 16, "--spp", 4,
                                "--seeds", 2, "--focus", 1, "-o", out / "validation"], needs_blender=True),
        Command("train", 27, [learner, "train", "rss", "--data", folder / "samples", "--size", 16, "--width", 0.125, "--steps", 20,
                              "--checkpoint-every", 4, "--threads", 1, "--resume", "-o", out / "run"], in_one_step=False),
        Command("estimate", 20, estimate + [out / "maps"]),
        Command("evaluate", 15, [learner, "evaluate", *weights, "--data", folder / "samples", "--size", 16, "--relight-views", 1,
                                 "--relight-spp", 1, "-o", out / "evaluation"]),
        Command("relight", 10, [learner, "relight", folder / "maps", "--point", "100,200,300,5", "--spp", 1, "-o",
                                out / "relit.png"], needs_blender=True),
    ], estimate + [folder / "maps"]


def digest(out):
    found = {}
    for path in sorted(out.rglob("*")):
        name = str(path.relative_to(out))
        found[name] = hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else "folder"
    return found


def run(arguments, environment):
    result = subprocess.run([str(a) for a in arguments], capture_output=True, text=True, env=environment, timeout=600)
    if result.returncode not in (DONE, DIFFERENCE, UNDECIDED):
        sys.exit("%s: exit code %d: %s" % (" ".join(map(str, arguments)), result.returncode, result.stderr[-500:]))


def is_temporary(name):
    return any(part.startswith(".") and (".tmp" in part or part.endswith(".old")) for part in Path(name).parts)


def differences(found, command, only_whole=False):
    """Names that should not be there, that are missing, or whose bytes differ."""
    if only_whole:   # after a kill: nothing yet, or all of it, beside temporaries
        found = {name: value for name, value in found.items() if not is_temporary(name)}
        if not found:
            return []
    names = found.keys() ^ command.digest.keys()
    return sorted(names | {n for n in found.keys() & command.digest.keys()
                           if n not in command.varying and found[n] != command.digest[n]})


def prepare(program, learner, folder, environment):
    scan = write_scan(folder)
    grey = write_hdr(folder / "grey.hdr")
    run([program, "label", scan, "-o", folder / "regions"], environment)
    for name in ("model", "bob"):
        run([program, "bake", scan, "--regions", folder / "regions", "--size", 64, "--name", name, "-o", folder / name], environment)
    for name, model in (("ada", "model"), ("bob", "bob")):
        run([program, "render", folder / model, "--environment", grey, "--size", 48, "--spp", 4, "--views", 2, "-o",
             folder / "samples" / name], environment)


def measure(command, out, environment):
    digests = []
    for _ in range(2):
        empty(out)
        start = time.monotonic()
        run(command.arguments, environment)
        command.seconds = time.monotonic() - start
        digests.append(digest(out))
    command.digest = digests[0]
    if digests[0].keys() != digests[1].keys():
        sys.exit("%s: two runs differ in their files" % command.name)
    command.varying = {name for name in digests[0] if command.timed or digests[0][name] != digests[1][name]}


def empty(out):
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()


def kill_once(command, out, environment, random_source):
    """True if the kill met the command alive."""
    meets_an_output = command.in_one_step and random_source.random() < 0.5
    if not meets_an_output:
        empty(out)
    elif digest(out).keys() != command.digest.keys():
        run(command.arguments, environment)
    process = subprocess.Popen(command.arguments, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(random_source.uniform(0, 1.05) * command.seconds)
    was_alive = process.poll() is None
    process.send_signal(signal.SIGKILL)
    process.wait()
    time.sleep(0.3)   # its children are ended by the kernel
    if command.in_one_step and (wrong := differences(digest(out), command, only_whole=True)):
        sys.exit("%s, killed: neither whole nor absent: %s" % (command.name, wrong[:5]))
    run(command.arguments, environment)
    if wrong := differences(digest(out), command):
        sys.exit("%s, killed and run again: differs in %s" % (command.name, wrong[:5]))
    return was_alive


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("learner")
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--no-blender", action="store_true")
    parser.add_argument("--only", help="the command of this name")
    options = parser.parse_args()
    random_source = random.Random(options.seed)
    folder = Path(tempfile.mkdtemp(prefix="ohb-kills-"))
    temporary, out = folder / "tmp", folder / "out"
    temporary.mkdir()
    environment = {**os.environ, "TMPDIR": str(temporary)}
    program, learner = os.path.abspath(options.program), os.path.abspath(options.learner)
    try:
        prepare(program, learner, folder, environment)
        commands, estimate = commands_of(program, learner, folder, out)
        if options.no_blender:
            commands = [c for c in commands if not c.needs_blender]
        else:
            run(estimate, environment)
        if options.only:
            commands = [c for c in commands if c.name == options.only]
        chosen = random_source.choices(commands, weights=[c.weight for c in commands], k=options.kills)
        if options.kills >= len(commands):
            chosen[:len(commands)] = commands   # each at least once
        chosen.sort(key=lambda c: c.name)
        kills, alive = Counter(), Counter()
        for command in chosen:
            if not kills[command.name]:
                measure(command, out, environment)
            alive[command.name] += kill_once(command, out, environment, random_source)
            kills[command.name] += 1
            print("%s: %d kills" % (command.name, kills[command.name]), file=sys.stderr, flush=True)
        if left := [p.name for p in temporary.iterdir()]:
            sys.exit("left in the temporary folder: %s" % left[:5])
        for name in kills:
            print("%-22s %3d kills, %3d while it was at work" % (name, kills[name], alive[name]))
        print("%d kills: the same command gave the same files, and nothing was left behind" % sum(kills.values()))
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
