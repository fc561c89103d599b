#!/usr/bin/env bash
# Do --error and --quality auto keep their promises? Ten scenes: humans, the example human and a head scan under varied
# lights and materials, four of them without skin. Takes an hour; not part of ./test. What is baked is kept.
#   tests/acceptance/ten_scenes.sh DATA OUT --error 0.01|--tolerance 0.02 [--size PX]
# DATA holds humans/ and scans/. Prints one line a scene.
set -euo pipefail
data=$1 out=$2
shift 2
here=$(dirname "$0")/../..
bin=${BIN:-$here/build/release/bin}
world=$(dirname "$(dirname "$(readlink -f "$(command -v blender)")")")/share/blender/datafiles/studiolights/world
own=$here/assets/environments
mkdir -p "$out"

# make NAME SCAN LABELS: bakes. LABELS is a file of classes, a class number for all faces, or empty.
make() {
  local name=$1 scan=$2 labels=$3
  [ -d "$out/$name" ] && return
  case $labels in
    "") set -- ;;
    [0-3])
      awk -v class="$labels" '/^f / { print class }' "$scan" >"$out/$name.labels.txt"
      set -- --faces "$out/$name.labels.txt" --classes skin,hair,fabric,leather
      ;;
    *) set -- --faces "$labels" ;;
  esac
  "$bin/openhumanbrdf" label "$scan" --unit cm "$@" -o "$out/$name.regions"
  "$bin/openhumanbrdf" bake "$scan" --unit cm --regions "$out/$name.regions" -o "$out/$name"
}
human() { echo "$data/humans/${1%_scan}/$1.$2"; }
head=$data/scans/lee_perry_smith/lee_perry_smith
example=$here/assets/example_human/example_human
make example $example.glb $example.labels.txt
make suit "$(human m48_suit obj)" ""
make casual_scan "$(human f25_casual_scan obj)" "$(human f25_casual_scan labels.txt)"
make tee_scan "$(human m35_tee_scan obj)" "$(human m35_tee_scan labels.txt)"
make jacket_scan "$(human f33_leatherjacket_scan obj)" "$(human f33_leatherjacket_scan labels.txt)"
make head "$head.obj" "$head.labels.txt"
make head_of_leather "$head.obj" 3
make suit_of_fabric "$(human m48_suit_scan obj)" 2
make jacket_of_leather "$(human f33_leatherjacket_scan obj)" 3
make striped_of_fabric "$(human m30_striped_scan obj)" 2

# scene NAME MODEL VIEW/COUNT LIGHT...
scene() { OHB_MODELS=$out "$bin/promise_bench" "${options[@]}" "$@"; }
options=("$@")
scene example-sunset example 0/8 "$own/sunset.exr"
scene example-two-lights example 1/8 "$own/studio.exr" 80,150,150,2
scene suit-three-lights suit 0/8 "$own/overcast_street.exr" "$own/sunset.exr" "$own/studio.exr"
scene casual-forest casual_scan 7/8 "$world/forest.exr"
scene tee-behind-sunset tee_scan 4/8 "$world/sunset.exr"
scene head-sunset head 0/8 "$own/sunset.exr"
scene head-of-leather-sunset head_of_leather 0/8 "$own/sunset.exr"
scene suit-of-fabric-forest suit_of_fabric 1/8 "$world/forest.exr"
scene jacket-of-leather-studio jacket_of_leather 0/8 "$own/studio.exr" -60,200,120,3
scene striped-of-fabric-overcast striped_of_fabric 2/8 "$own/overcast_street.exr"
