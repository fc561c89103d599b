#!/usr/bin/env bash
# Every human through inspect, label, bake and render, and one picture of them all: the relit frontal view and
# the six maps of each, a row a human. Needs oiiotool (package openimageio-tools).
#   tests/acceptance/contact_sheet.sh HUMANS OUT [HEAD.obj]
# HUMANS holds a folder a human with <name>.obj and <name>_scan.obj (+ .labels.txt); HEAD is a scan in cm with
# labels beside it. SIZE, SPP and ENVIRONMENT may be set.
set -euo pipefail
humans=$1 out=$2 head=${3:-}
root=$(dirname "$0")/../..
program=$root/build/release/bin/openhumanbrdf
environment=${ENVIRONMENT:-$root/assets/environments/overcast_street.exr}
size_px=${SIZE:-256} spp=${SPP:-64}
mkdir -p "$out"

# one SCAN UNIT_OPTION...: all commands; fails with the first that fails.
one() {
  local scan=$1 name labels=()
  shift
  name=$(basename "$scan" .obj)
  if [ -f "${scan%.obj}.labels.txt" ]; then labels=(--faces "${scan%.obj}.labels.txt"); fi
  "$program" inspect "$scan" "$@" --json >"$out/$name.inspect.json"
  "$program" label "$scan" "${labels[@]}" "$@" -o "$out/$name.regions" >/dev/null
  "$program" bake "$scan" --regions "$out/$name.regions" "$@" -o "$out/$name.model" >"$out/$name.bake.txt"
  "$program" render "$out/$name.model" --environment "$environment" --size "$size_px" --spp "$spp" -o "$out/$name.samples" >/dev/null
  echo "$name: inspect, label, bake, render done"
}

rows=()
for folder in "$humans"/*/; do
  for scan in "$folder"/*.obj; do one "$scan"; rows+=("$(basename "$scan" .obj)"); done
done
if [ -n "$head" ]; then one "$head" --unit cm; rows+=("$(basename "$head" .obj)"); fi

cells=()
for name in "${rows[@]}"; do
  for part in "relit.$(basename "$environment" .exr)" normal diffuse roughness specular sss displacement; do
    cells+=("$out/$name.samples/previews/view_000.$part.png")
  done
done
oiiotool "${cells[@]}" --mosaic:pad=2 "7x${#rows[@]}" -o "$out/sheet.png"
echo "$out/sheet.png: ${#rows[@]} scans"
