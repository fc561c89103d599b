#!/usr/bin/env bash
# Does our render of baked maps equal Cycles' render of the scan itself? Bakes a scan with hard borders, and runs
# `validate` with a Blender that renders the scan as its own importer reads it (source_materials_scene.py): other mesh
# reader, other seams and padding, classes face by face. Pictures are decoded before they are filtered, as we do;
# OHB_ENCODED=1 leaves that to Cycles, which filters first (and is darker by it). Minutes; not part of ./test.
#   tests/acceptance/baked_equals_source.sh SCAN LABELS OUT [validate's options]
# SCAN: .glb or .obj of one mesh; LABELS: a class a line. ENVIRONMENT and SIZES ("0": the picture's) may be set.
set -euo pipefail
scan=$(readlink -f "$1") labels=$(readlink -f "$2") out=$3
shift 3
root=$(readlink -f "$(dirname "$0")/../..")
program=${PROGRAM:-$root/build/release/bin/openhumanbrdf}
environment=${ENVIRONMENT:-$root/assets/environments/studio.exr}
mkdir -p "$out"
out=$(readlink -f "$out")

cat >"$out/blender" <<'WRAPPER'
#!/usr/bin/env bash
# Blender, but with our scene builder in place of validation_scene.py.
arguments=()
for argument in "$@"; do
  case $argument in */validation_scene.py) argument=$OHB_ROOT/tests/acceptance/source_materials_scene.py ;; esac
  arguments+=("$argument")
done
exec blender "${arguments[@]}"
WRAPPER
chmod +x "$out/blender"

[ -d "$out/regions" ] || "$program" label "$scan" --faces "$labels" -o "$out/regions"
find "$out/regions" -name weights.exr -delete # hard borders: the classes of the faces
status=0
for size in ${SIZES:-0}; do
  option=()
  if [ "$size" != 0 ]; then option=(--size "$size"); fi
  model=$out/model_$size report=$out/report_$size
  [ -d "$model" ] || "$program" bake "$scan" --regions "$out/regions" "${option[@]}" -o "$model"
  echo "maps of ${size/#0/the picture\'s} px:"
  OHB_ROOT=$root OHB_SCAN=$scan OHB_LABELS=$labels OHB_MODEL=$model \
    "$program" validate "$model" --environment "$environment" --blender "$out/blender" "$@" -o "$report" || status=$?
done
exit $status
