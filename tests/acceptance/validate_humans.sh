#!/usr/bin/env bash
# The proof on real humans: labels, bakes and validates each against Cycles under two of Blender's environments.
# Takes hours; what is finished is kept, so it can be stopped and started again. Not part of ./test.
#   tests/acceptance/validate_humans.sh HUMANS OUT [MODEL...]
# HUMANS holds a folder a human with <name>.obj and <name>_scan.obj (+ .labels.txt); MODEL is <name> or
# <name>_scan (default: three humans, both variants, and one whose hair has copies of faces). ENVIRONMENTS and
# OPTIONS may be set.
set -euo pipefail
humans=$1 out=$2
shift 2
models=("$@")
if [ ${#models[@]} -eq 0 ]; then
  models=(m48_suit m48_suit_scan f25_casual f25_casual_scan m35_tee m35_tee_scan f40_skirt)
fi
program=${PROGRAM:-$(dirname "$0")/../../build/release/bin/openhumanbrdf}
world=$(dirname "$(dirname "$(readlink -f "$(command -v blender)")")")/share/blender/datafiles/studiolights/world
environments=${ENVIRONMENTS:-$world/sunset.exr $world/forest.exr}
# shellcheck disable=SC2206
options=(${OPTIONS:---size 256 --spp 128 --seeds 8 --focus 1500 --subsurface diffuse})
mkdir -p "$out"

make_model() {
  local model=$1 human=${1%_scan}
  [ -d "$out/$model" ] && return
  local scan=$humans/$human/$model.obj labels=()
  if [ -f "$humans/$human/$model.labels.txt" ]; then labels=(--faces "$humans/$human/$model.labels.txt"); fi
  "$program" label "$scan" "${labels[@]}" -o "$out/$model.regions"
  "$program" bake "$scan" --regions "$out/$model.regions" -o "$out/$model"
}

failed=0
for model in "${models[@]}"; do
  make_model "$model"
  for environment in $environments; do
    report=$out/$model.$(basename "$environment" .exr)
    if [ ! -d "$report" ]; then
      "$program" validate "$out/$model" --environment "$environment" "${options[@]}" -o "$report" || [[ $? =~ ^[13]$ ]]
    fi
    verdict=$(sed -n 's/^ "verdict": "\(.*\)",$/\1/p' "$report/validate.json")
    echo "$(basename "$report"): $verdict"
    if [ "$verdict" != pass ]; then failed=1; fi
  done
done
exit $failed
