#!/usr/bin/env bash
# Makes the weights of assets/weights from nothing but free assets: people, lights, samples, networks, tables.
set -euo pipefail

if [ $# -lt 2 ] || [ "${1:-}" = "--help" ]; then
  cat <<'HELP'
usage: train_open_weights.sh ASSETS OUT [ENVIRONMENT.exr...]

  ASSETS       folder of MakeHuman's assets, as openhumanbrdf people takes it
  OUT          gets people, lights, samples, runs/, report/ and results.md; stopped and started again it goes on
  ENVIRONMENT  latitude-longitude maps to train under beside the synthetic ones

308 people to train on (24 of them one closed surface with shading in the picture) and 36 others to test on, who share
neither people nor lights with them; 8 views a person, of 198 at 128 x 128 under 4 lights, of the others at 256 x 256
under 2, for half bodies and closer. Three priors at a quarter of the paper's width. Hours: docs/measurements/learner.md.
THREADS (default: all) must stay the same for a resumed run to equal an uninterrupted one bit for bit.
HELP
  exit 2
fi

here=$(cd "$(dirname "$0")" && pwd)
find_program() { if [ -x "$here/../build/release/bin/$1" ]; then echo "$here/../build/release/bin/$1"; else echo "$1"; fi; }
maker=${OPENHUMANBRDF:-$(find_program openhumanbrdf)}
learner=${HUMANMATERIAL:-$(find_program humanmaterial)}
assets=$1 out=$2
shift 2
mkdir -p "$out/lights_train" "$out/lights_test"

# People: the second and third group leave out whoever has the name of one in a group before.
people() { "$maker" people --assets "$assets" --balanced --atlas 1024 --count "$2" --seed "$3" "${@:4}" -o "$out/$1"; }
people people_b 84 202
people people_c 24 304 --fused --baked-shading
people people_d 96 404
people people_e 112 505
people people_test 36 101
plan_people() {  # the <person> elements of a group; names used before are left out, and those of who is tested
  for folder in "$out/$1"/p*/; do
    name=$(basename "$folder")
    [ "$3" = test ] || [ ! -d "$out/people_test/$name" ] || continue
    grep -q "id=\"$name\"" "$2" || echo "  <person id=\"$name\" split=\"$3\" scan=\"$1/$name/${name}_scan.obj\" labels=\"$1/$name/${name}_scan.labels.txt\" licence=\"CC0-1.0\"/>" >>"$2"
  done
}

# Lights: every fourth synthetic one is for testing alone.
"$maker" environments synthesise --count 80 --seed 21 --width 512 -o "$out/lights"
number=0
for file in "$out"/lights/envmaps/*.exr; do
  number=$((number + 1))
  ln -sfr "$file" "$out/lights_$([ $((number % 4)) = 0 ] && echo test || echo train)/"
done
for file in "$@"; do ln -sf "$(realpath "$file")" "$out/lights_train/bl_$(basename "$file")"; done

# Samples.
sample() {  # NAME SEED SPLIT MAPS_PX VIEWS_ATTRIBUTES LIGHTS GROUP...
  local plan=$out/$1.new
  echo "<plan schema=\"1\" name=\"$1\" seed=\"$2\"><maps size_px=\"$4\"/>" >"$plan"
  for group in "${@:7}"; do plan_people "$group" "$plan" "$3"; done
  echo "  <environments id=\"lights\" folder=\"lights_$3\"/>
  <views split=\"$3\" $5><lights from=\"lights\" count=\"$6\"/></views></plan>" >>"$plan"
  cmp -s "$plan" "$out/$1.xml" || cp "$plan" "$out/$1.xml"
  mkdir -p "$out/samples_$3"
  "$maker" produce "$out/$1.xml" --workers 2 -o "$out/samples_$3/$1"
}
sample far 1 train 512 'count="8" size_px="128" spp="16"' 4 people_c people_b people_d
sample near 3 train 1024 'count="8" size_px="256" spp="12"' 2 people_e
sample people 2 test 512 'count="4" size_px="128" spp="48"' 3 people_test

common=(--data "$out/samples_train" --preset best --size 128 --width 0.25 --cosine --hold-out p0000_f25_asian --threads "${THREADS:-0}" --resume)
priors=()
train() {  # MODEL STEPS OPTIONS...
  if [ "$(tail -n 1 "$out/runs/$1/log.jsonl" 2>/dev/null | grep -c "\"done\".*\"step\":$2}")" = 0 ]; then
    "$learner" train "$1" "${common[@]}" --steps "$2" "${@:3}" -o "$out/runs/$1"
  fi
}
train geometry 20000
train albedo 28000
train rss 28000
for prior in geometry albedo rss; do priors+=("$out/runs/$prior"); done
HUMANMATERIAL="$learner" KEEP="$out/report" "$here/results.sh" "$out/samples_test" "$out/results.md" "${priors[@]}"
echo "$out/results.md"
