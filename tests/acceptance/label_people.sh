#!/usr/bin/env bash
# usage: label_people.sh HUMANS ASSETS FUSE.py OUT
# How well `label` does without a stroke, as docs/measurements/label.md has it. HUMANS: folders of NAME_scan.obj with
# NAME_scan.labels.txt; ASSETS: what `people` makes people of; FUSE.py: a script for Blender that turns a labelled scan into
# one closed surface (SCAN LABELS PREFIX). Makes the twins and the generated people (half an hour on two cores; what is there
# stays), then OUT/fit.txt (the scans, each by what the others and 124 generated people teach) with OUT/label_model.json, and
# OUT/trust.txt (91 other generated people, by the installed weights).
set -euo pipefail
humans=$(realpath "$1") assets=$(realpath "$2") fuse=$(realpath "$3")
here=$(realpath "$(dirname "$0")/../..")
bin=${BIN:-$here/build/release/bin}
mkdir -p "$4/fused"
cd "$4"
for scan in "$humans"/*/*_scan.obj; do
  twin=fused/$(basename "${scan%_scan.obj}")_fused
  [ -f "$twin.obj" ] || blender -b -noaudio --factory-startup --python "$fuse" -- "$scan" "${scan%.obj}.labels.txt" "$twin" >>log
done
"$bin/openhumanbrdf" people --assets "$assets" --count 60 --seed 901 -o p901
"$bin/openhumanbrdf" people --assets "$assets" --count 60 --seed 911 -o p911
"$bin/openhumanbrdf" people --assets "$assets" --count 85 --seed 977 -o p977
"$bin/openhumanbrdf" people --assets "$assets" --count 10 --seed 902 --fused -o p902
fused=(p902/*/*.obj)
"$bin/label_robot" --fit label_model.json "$humans"/*/*_scan.obj fused/*.obj p901/*/*.obj p911/*/*.obj "${fused[@]:0:4}" | tee fit.txt
"$bin/label_robot" --trust --leather-share 0.24 p977/*/*.obj "${fused[@]:4}" | tee trust.txt
