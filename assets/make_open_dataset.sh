#!/usr/bin/env bash
# A small open dataset for `humanmaterial train`: labels, bakes and renders every labelled scan in a folder.
set -euo pipefail

if [ $# -lt 3 ] || [ "${1:-}" = "--help" ]; then
  cat <<'HELP'
usage: make_open_dataset.sh HUMANS DATASET ENVIRONMENT.exr... [-- RENDER_OPTIONS]

  HUMANS       folder with <name>/<name>_scan.obj and <name>_scan.labels.txt (one class index a face)
  DATASET      gets models/<name> and samples/<name>; existing models and views are kept, so it can be stopped
               and started again
  ENVIRONMENT  latitude-longitude maps: one relit image each
  options      of openhumanbrdf render; default: --views 24 --size 128 --spp 64

OPENHUMANBRDF names the program (default: build/release/bin/openhumanbrdf beside this script's folder,
otherwise the installed one).
HELP
  exit 2
fi

here=$(cd "$(dirname "$0")" && pwd)
program=$here/../build/release/bin/openhumanbrdf
[ -x "$program" ] || program=openhumanbrdf
program=${OPENHUMANBRDF:-$program}
humans=$1 dataset=$2
shift 2
environments=()
while [ $# -gt 0 ] && [ "$1" != "--" ]; do environments+=(--environment "$1"); shift; done
[ $# -eq 0 ] || shift
options=("$@")
[ ${#options[@]} -gt 0 ] || options=(--views 24 --size 128 --spp 64)

mkdir -p "$dataset/models" "$dataset/regions" "$dataset/samples"
for folder in "$humans"/*/; do
  name=$(basename "$folder")
  scan=$folder${name}_scan.obj
  [ -f "$scan" ] || continue
  if [ ! -f "$dataset/models/$name/model.xml" ]; then
    "$program" label "$scan" --faces "$folder${name}_scan.labels.txt" -o "$dataset/regions/$name"
    "$program" bake "$scan" --regions "$dataset/regions/$name" --size 1024 -o "$dataset/models/$name"
  fi
  "$program" render "$dataset/models/$name" "${environments[@]}" "${options[@]}" -o "$dataset/samples/$name"
done
