#!/usr/bin/env bash
# usage: every_command.sh PREFIX OUT   (an empty or new folder)
# Runs every command of the programs installed in PREFIX on the human installed there, small; the first that does not
# end as it should ends this with its words. Commands that need Blender are left out where it is not installed.
set -euo pipefail
prefix=$1 out=$2
share=$prefix/share/openhumanbrdf
human=$share/assets/example_human/example_human.glb
sky=$share/assets/environments/studio.exr
mkdir -p "$out"
cd "$out"
installed() { find "$share" -printf '%P %s\n' | sort; }
installed >installed.txt

# answers CODES COMMAND...: the command ends with one of these exit codes.
answers() {
  local codes=$1 code=0
  shift
  "$@" >log.txt 2>&1 || code=$?
  if [[ " $codes " != *" $code "* ]]; then
    tail -n 20 log.txt >&2
    echo "exit code $code of: $*" >&2
    exit 1
  fi
  printf '%s %s: %s\n' "$(basename "$1")" "$2" "$code"
}
# Exit codes 1 and 3 are findings of so few paths, not failures of the installation.
openhumanbrdf() { answers "0" "$prefix/bin/openhumanbrdf" "$@"; }
finds() { answers "0 1 3" "$prefix/bin/openhumanbrdf" "$@"; }

openhumanbrdf --version
openhumanbrdf inspect "$human"
openhumanbrdf label "$human" --automatic -o regions
openhumanbrdf bake "$human" --regions regions --size 256 -o model
openhumanbrdf render model --environment "$sky" --views 2 --size 64 --spp 4 --subsurface diffuse -o samples
openhumanbrdf export samples --png -o pictures
openhumanbrdf export samples --page -o page
openhumanbrdf environments synthesise --count 3 --width 64 -o lights
openhumanbrdf environments import "$sky" --licence CC0-1.0 -o lights
openhumanbrdf environments list lights
finds chart stress --case roughness --no-cycles --size 8 --spp 2 --seeds 2 -o stress
finds chart bake-stress --case "flipped UVs" -o bake_stress
finds chart bake "$human" --regions regions --environment "$sky" --map-sizes 64 --size 32 --spp 2 --seeds 2 -o chart_bake
if command -v blender >/dev/null; then
  finds validate model --environment "$sky" --size 32 --spp 4 --seeds 2 --focus 1 -o report
  finds chart speed-accuracy model --environment "$sky" --size 16 --max-spp 4 --seeds 2 -o chart
fi

if [ -x "$prefix/bin/humanmaterial" ]; then
  humanmaterial() { answers "0" "$prefix/bin/humanmaterial" "$@"; }
  openhumanbrdf bake "$human" --regions regions --size 64 --name two -o model_two
  openhumanbrdf render model --environment "$sky" --views 2 --size 64 --spp 4 --subsurface diffuse -o data/one
  openhumanbrdf render model_two --environment "$sky" --views 2 --size 64 --spp 4 --subsurface diffuse -o data/two
  for model in geometry albedo rss; do
    humanmaterial train "$model" --data data --hold-out two --size 64 --steps 2 -o "runs/$model"
  done
  humanmaterial evaluate runs/* --data data --no-relight -o evaluation
  humanmaterial estimate samples/previews/view_000.relit.studio.png --mask samples/previews/view_000.mask.png \
    --weights "$share"/assets/weights/*.safetensors -o maps
  if command -v blender >/dev/null; then
    humanmaterial relight maps --environment "$sky" --edit fabric:red --size 64 --spp 2 -o relit.png
  fi
fi
answers "0" python3 "$share/blender_addon/tools/build_zip.py" -o human_material.zip
answers "0 2" "$share/assets/train_open_weights.sh" --help
installed | diff installed.txt - || { echo "the commands changed $share" >&2; exit 1; }
echo "every command answers"
