#!/usr/bin/env bash
# How many times as long as ours does Cycles take to equal error? `chart speed-accuracy` of five humans, six lights each,
# and the median of each ratio. Takes half an hour on two cores and means something on an idle machine only.
#   [LIGHTS=1] tests/acceptance/five_humans_speed.sh MODELS OUT [--size PX] [--max-spp N] [--seeds K]
# LIGHTS: the first so many of the six alone. MODELS holds the folders that ten_scenes.sh bakes. Finished charts are
# kept: delete OUT to measure anew.
set -euo pipefail
models=$1 out=$2
shift 2
here=$(dirname "$0")/../..
bin=${BIN:-$here/build/release/bin}
world=$(dirname "$(dirname "$(readlink -f "$(command -v blender)")")")/share/blender/datafiles/studiolights/world
own=$here/assets/environments
environments=()
for file in "$own"/{overcast_street,sunset,studio}.exr "$world"/{forest,city,interior}.exr; do
  environments+=(--environment "$file")
done
environments=("${environments[@]:0:2*${LIGHTS:-6}}")
mkdir -p "$out"
for name in casual_scan tee_scan jacket_scan suit example; do
  [ -d "$out/$name" ] || "$bin/openhumanbrdf" chart speed-accuracy "$models/$name" "${environments[@]}" "$@" \
    -o "$out/$name" >"$out/$name.log"
  echo "$name" && grep "times as long" "$out/$name.log"
done
python3 - "$out" <<'PYTHON'
import json, pathlib, statistics, sys
ratios = {}
for file in sorted(pathlib.Path(sys.argv[1]).glob("*/chart.json")):
    for r in json.loads(file.read_text())["times_to_equal_error"]:
        ratios.setdefault((r["cycles"], r["ours"]), []).append((r["cycles_over_ours"], r["cycles_over_ours_without_loading"]))
for (cycles, ours), values in ratios.items():
    loaded, bare = (statistics.median(v) for v in zip(*values))
    print(f"median of {len(values)}: {cycles} takes {loaded:.2f} times as long as {ours} ({bare:.2f} without loading)")
PYTHON
