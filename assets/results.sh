#!/usr/bin/env bash
# Writes docs/results.md (or another page): what weights score on people they have not seen, and where they break.
set -euo pipefail

if [ $# -lt 2 ] || [ "${1:-}" = "--help" ]; then
  cat <<'HELP'
usage: results.sh DATASET PAGE.md [RUN...]

  DATASET  samples of people whom the networks have not seen, as openhumanbrdf render or produce writes them
  PAGE.md  is written, with PAGE.stress.png beside it
  RUN      runs or weights files (default: assets/weights)

Runs humanmaterial evaluate and stress, whose folders are kept in $KEEP if that is set.
HELP
  exit 2
fi

here=$(cd "$(dirname "$0")" && pwd)
learner=${HUMANMATERIAL:-$here/../build/release/bin/humanmaterial}
data=$1 page=$2
shift 2
networks=("$@")
if [ $# -eq 0 ]; then networks=("$here"/weights/*.safetensors); fi
if [ -n "${KEEP:-}" ]; then work=$KEEP; mkdir -p "$work"; else work=$(mktemp -d); trap 'rm -rf "$work"' EXIT; fi

[ -d "$work/evaluation" ] || "$learner" evaluate "${networks[@]}" --data "$data" -o "$work/evaluation" >/dev/null
[ -d "$work/stress" ] || "$learner" stress "${networks[@]}" --data "$data" -o "$work/stress" >/dev/null
cp "$work/stress/chart.png" "${page%.md}.stress.png"
{
  echo "# What the weights score"
  echo
  echo "Made by \`assets/results.sh\`. What the columns are: [evaluate](commands/evaluate.md#the-table),"
  echo "[stress](commands/stress.md#what-is-measured). What it shows: [measurements](measurements/learner.md)."
  echo
  echo "## On people and lights that training did not see"
  echo
  cat "$work/evaluation/evaluation.md"
  echo "## Where they break"
  echo
  cat "$work/stress/stress.md"
  echo
  echo "![stress chart]($(basename "${page%.md}").stress.png)"
} >"$page.new"
mv "$page.new" "$page"
