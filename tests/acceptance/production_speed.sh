#!/usr/bin/env bash
# How fast are whole sets: six maps, mask and six lit images of 512 px at 64 paths, files on disk, bakes included?
# `produce` of two people by one worker on one core and by two on two; and what Cycles takes to the error of our lit
# images (`chart speed-accuracy`), its maps not counted. Takes a quarter of an hour and means something on an idle
# machine only.
#   tests/acceptance/production_speed.sh SCAN REGIONS ENVIRONMENTS OUT
# SCAN: as label took it; REGIONS: the folder that label wrote; ENVIRONMENTS: a folder of six or more. What is in OUT
# is kept: delete it to measure anew.
set -euo pipefail
scan=$(realpath "$1") regions=$(realpath "$2") lights=$(realpath "$3") out=$4
here=$(realpath "$(dirname "$0")/../..")
program=${BIN:-$here/build/release/bin}/openhumanbrdf
mkdir -p "$out"
cat >"$out/plan.xml" <<PLAN
<?xml version="1.0"?>
<plan schema="1" name="speed" seed="1">
  <maps size_px="2048"/>
  <person id="a" scan="$scan" regions="$regions" split="train"/>
  <person id="b" scan="$scan" regions="$regions" split="train"/>
  <environments id="lights" folder="$lights"/>
  <views split="train" count="6" size_px="512" spp="64"><lights from="lights" count="6"/></views>
</plan>
PLAN
for workers in 1 2; do
  [ -f "$out/$workers.json" ] && continue
  rm -rf "$out/dataset"
  /usr/bin/time -f "%e %U %S" -o "$out/$workers.time" "$program" produce "$out/plan.xml" --workers $workers \
    --threads $workers --json -o "$out/dataset" >"$out/part.json"
  mv "$out/part.json" "$out/$workers.json"
done
if [ ! -f "$out/chart/chart.json" ]; then
  mapfile -t files < <(find -L "$lights" -name '*.exr' | sort | head -n 6)
  "$program" chart speed-accuracy "$out/dataset/humans/a/model" "${files[@]/#/--environment=}" --size 512 --max-spp 64 \
    --seeds 2 -o "$out/chart" >"$out/chart.log"
fi
python3 - "$out" <<'PYTHON'
import json, pathlib, sys
out = pathlib.Path(sys.argv[1])
wall = {n: float((out / f"{n}.time").read_text().split()[0]) for n in (1, 2)}
chart = json.loads((out / "chart/chart.json").read_text())
print(f"12 sets: {wall[1]:.1f} s by one worker, {wall[2]:.1f} s by two: {wall[1] / wall[2]:.2f} times as fast")
for ratio in chart["times_to_equal_error"]:
    if "lights" in ratio["ours"]:
        point = max((p for p in chart["points"] if p["series"] == ratio["ours"]), key=lambda p: p["spp"])
        cycles_s = ratio["cycles_over_ours"] * (point["load_s"] + point["wall_s"])
        print(f"a set: {wall[2] / 12:.2f} s here; {cycles_s:.1f} s for the lit images alone by {ratio['cycles']} at the "
              f"error of {ratio['ours']}: {cycles_s / (wall[2] / 12):.1f} times as long")
PYTHON
