#!/usr/bin/env bash
# usage: same_bytes.sh BIN_FOLDER OUTPUT [SCAN...]   ; then: diff before/hashes after/hashes
# Whether a change of the code changed what users get: the SHA-256 of what label, bake, render, train and estimate write
# for the example human and each scan, in OUTPUT/hashes. Run it with the programs of before and of after.
set -euo pipefail
bin=$(realpath "$1"); out=$(realpath -m "$2"); shift 2
here=$(cd "$(dirname "$0")/../.." && pwd)
light="$here/assets/environments/studio.exr"
mkdir -p "$out"; cd "$out"
: > times
ohb() { local begin; begin=$(date +%s.%N); "$bin/openhumanbrdf" "$@" >/dev/null 2>>log || [ $? -eq 1 ] || [ $? -eq 3 ]
        echo "$(echo "$(date +%s.%N) - $begin" | bc) $*" >>times; }
for scan in "$here/assets/example_human/example_human.glb" "$@"; do
  name=$(basename "${scan%.*}")
  labels="${scan%.*}.labels.txt"
  mkdir -p "$name"; cd "$name"
  ohb label "$scan" --automatic -o automatic
  ohb label "$scan" --faces "$labels" -o regions
  ohb bake "$scan" --regions regions --size 512 -o model
  views="--environment $light --point 100,220,200,5 --views 8:1 --size 128 --spp 16"
  # shellcheck disable=SC2086
  { ohb render model $views -o v1
    ohb render model $views --model v2 -o v2
    ohb render model $views --subsurface diffuse -o diffuse
    ohb render model $views --sampling even -o even
    ohb render model $views --quality auto --tolerance 0.05 -o auto
    ohb render model --environment "$light" --views 1 --size 96 --error 0.05 --max-spp 256 -o error; }
  cd ..
done
if [ -x "$bin/humanmaterial" ]; then
  human() { "$bin/humanmaterial" "$@" >/dev/null 2>>log; }
  example="$here/assets/example_human/example_human.glb"
  for person in one two; do
    ohb bake "$example" --regions example_human/regions --size 256 --name $person -o "$person"
    ohb render "$person" --environment "$light" --views 4 --size 64 --spp 4 -o "people/$person"
  done
  for task in geometry albedo rss; do
    human train $task --data people --hold-out two --size 64 --steps 100 -o "run_$task"
  done
  shown=example_human/v1/previews/view_001
  human estimate $shown.relit.studio.png --mask $shown.mask.png --weights "$here"/assets/weights/*.safetensors -o maps
fi
# Reports hold times and the program's version.
find . -type f -not -path '*/previews/*' \( -name '*.exr' -o -name '*.png' -o -name '*.obj' -o -name 'faces.txt' -o -name '*.xml' -o -name '*.safetensors' -o -name '*.faces' -o -name '*.u8' \) \
  -print0 | sort -z | xargs -0 sha256sum > hashes
wc -l hashes
