#!/usr/bin/env python3
"""Where training breaks: geometry priors with larger and larger learning rates, sharper control roughness, other batches.

usage: training_stress.py DATASET TEST OUT [STEPS]

DATASET is trained on, the people of TEST (who are not in it) are estimated. Each run sees 2 x STEPS (400) samples at width 0.25 and
128 pixels by one thread, two runs at a time; what is in OUT already is kept. Writes OUT/training_stress.md and .svg.
A run has learnt nothing if its normals are hardly nearer to the truth (5 %) than one constant direction is; "gave up" is exit code 2.
Programs are those of build/release/bin, or $HUMANMATERIAL; gnuplot draws.
"""
import concurrent.futures
import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("HUMANMATERIAL", str(ROOT / "build/release/bin/humanmaterial"))
RATE, BATCH, ROUGHNESS, WEIGHT = 5e-4, 2, 0.2, 1
DEFAULTS = {"learning-rate": RATE, "batch": BATCH, "control-roughness": ROUGHNESS, "render-weight": WEIGHT}
FACTORS = (0.1, 1, 10, 30, 100)
# Title, option, its usual value, what is tried, and what goes with it.
SERIES = (
    ("learning rate", "learning-rate", RATE, [RATE * f for f in FACTORS], ()),
    ("learning rate, without the rendering loss", "learning-rate", RATE, [RATE * f for f in FACTORS[1:]], ("--render-weight", "0")),
    ("control roughness", "control-roughness", ROUGHNESS, [0.8, 0.4, 0.2, 0.05, 0.02], ()),
    ("control roughness, linear loss", "control-roughness", ROUGHNESS, [0.8, 0.2, 0.02], ("--linear-render-loss",)),
    ("weight of the rendering loss", "render-weight", WEIGHT, [1, 10, 100], ()),
    ("batch, as many samples", "batch", BATCH, [1, 2, 4, 8], ()),
)


def run(*words):
    environment = dict(os.environ, OMP_NUM_THREADS="1", OMP_WAIT_POLICY="passive")
    return subprocess.run([PROGRAM, *map(str, words), "--threads", "1"], capture_output=True, text=True, env=environment, check=False)


def scores(folder, test):
    """(degrees, dB) of the run and of the constant."""
    if not (folder / "report/evaluation.json").exists():
        done = run("evaluate", folder, "--data", test, "--no-relight", "-o", folder / "report")
        if done.returncode != 0:
            sys.exit(done.stderr)
    rows = {row["name"]: row["mean"] for row in json.loads((folder / "report/evaluation.json").read_text())["rows"]}
    return [(rows[name]["measures"]["N mean deg"], rows[name]["N"]["masked"]) for name in ("priors", "constant")]


def measured(data, test, out, steps, option, value, extra):
    """Trains and evaluates one run, or finds it there: (degrees, dB, largest gradient norm, skipped steps, constant's degrees)."""
    options = {**DEFAULTS, option: value}
    folder = out / "_".join([f"{name}={v:.3g}" for name, v in options.items()] + [w.strip("-") for w in extra])
    words = [w for name, v in options.items() if "--" + name not in extra for w in ("--" + name, f"{v:.3g}")]
    trained = run("train", "geometry", "--data", data, "--size", 128, "--steps", steps * BATCH // options["batch"], "--cosine", "--mirror",
                  "--resume", "-o", folder, *words, *extra)
    log = [json.loads(line) for line in (folder / "log.jsonl").read_text().splitlines()]
    norm = max((event.get("gradient_norm", 0) for event in log), default=0)
    skipped = sum(event["event"] == "skipped" for event in log if "event" in event)
    if trained.returncode not in (0, 2):
        sys.exit(trained.stderr)
    if trained.returncode == 2:
        print(trained.stderr.strip().splitlines()[-1])
        return None, None, norm, skipped, None
    ours, constant = scores(folder, test)
    return (*ours, norm, skipped, constant[0])


def key_of(option, value, extra):
    """One run may belong to several series."""
    return (*{**DEFAULTS, option: value}.values(), *extra)


def table(results):
    lines = ["| | | N, degrees | N, dB | largest gradient | steps skipped | |", "|---|---:|---:|---:|---:|---:|---|"]
    for (title, _, usual, values, _), row in zip(SERIES, results):
        for value, (deg, decibels, norm, skipped, constant) in zip(values, row):
            end = "gave up" if deg is None else "nothing learnt" if deg > 0.95 * constant else "usual" if value == usual else ""
            score = "- | -" if deg is None else f"{deg:.1f} | {decibels:.2f}"
            lines.append(f"| {title} | {value:.3g} | {score} | {norm:.3g} | {skipped} | {end} |")
    return "\n".join(lines) + "\n"


def chart(results, file):
    constant = max(r[4] for row in results for r in row if r[4] is not None)
    text = f"set terminal svg size 1080,600 font 'sans,11' background 'white'\nset output '{file}'\nset multiplot layout 2,3\n"
    text += "set logscale x\nset yrange [15:40]\nset grid lc rgb '#dddddd'\nset ylabel 'normals, degrees'\nset key off\n"
    for (title, option, usual, values, _), row in zip(SERIES, results):
        points = "\n".join(f"{v:.6g} {r[0] if r[0] is not None else 40}" for v, r in zip(values, row))
        text += f"$d << EOD\n{points}\nEOD\nset title '{title}'\nset xlabel '--{option}' noenhanced\n"
        text += f"set arrow 1 from {usual}, graph 0 to {usual}, graph 1 nohead dt 3 lc rgb '#999999'\n"
        text += f"plot [{min(values) / 1.3:g}:{max(values) * 1.3:g}] {constant} dt 2 lc rgb '#cc3333', $d with linespoints pt 7 lc rgb '#226699'\n"
    subprocess.run(["gnuplot"], input=text + "unset multiplot\n", text=True, check=True)


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    data, test, out = map(Path, sys.argv[1:4])
    steps = int(sys.argv[4]) if len(sys.argv) > 4 else 400
    out.mkdir(parents=True, exist_ok=True)
    wanted = {key_of(option, value, extra): (option, value, extra) for _, option, _, values, extra in SERIES for value in values}
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        runs = {key: pool.submit(measured, data, test, out, steps, *run) for key, run in wanted.items()}
        results = [[runs[key_of(option, value, extra)].result() for value in values] for _, option, _, values, extra in SERIES]
    (out / "training_stress.md").write_text(table(results))
    chart(results, out / "training_stress.svg")
    print(table(results))


if __name__ == "__main__":
    main()
