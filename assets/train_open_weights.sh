#!/usr/bin/env bash
# Trains the weights of assets/weights and writes the tables of docs/measurements/learner.md.
set -euo pipefail

if [ $# -lt 3 ] || [ "${1:-}" = "--help" ]; then
  cat <<'HELP'
usage: train_open_weights.sh HUMANS OUT ENVIRONMENT.exr...

  HUMANS       folder with <name>/<name>_scan.obj and <name>_scan.labels.txt
  OUT          gets open/ (the dataset), runs/, report/ and results.md; stopped and started again it goes on
  ENVIRONMENT  latitude-longitude maps that the training views are lit by

24 views x 128 x 128 px x 64 paths a person and light; every fourth person is held out. Three priors and the finetuning
model at a quarter of the paper's width: 2.3 hours when it was measured (docs/measurements/learner.md: one thread a run, on two busy
cores), and the rendering before. THREADS (default: all) must stay the same for a resumed run to equal an
uninterrupted one bit for bit.
HELP
  exit 2
fi

here=$(cd "$(dirname "$0")" && pwd)
learner=$here/../build/release/bin/humanmaterial
[ -x "$learner" ] || learner=humanmaterial
learner=${HUMANMATERIAL:-$learner}
humans=$1 out=$2
shift 2
"$here/make_open_dataset.sh" "$humans" "$out/open" "$@" -- --views 24 --size 128 --spp 64 --subsurface diffuse
common=(--data "$out/open/samples" --size 128 --width 0.25 --cosine --mirror --threads "${THREADS:-0}" --resume)
priors=()
train() {  # MODEL STEPS BATCH RATE OPTIONS...
  local model=$1 steps=$2 batch=$3 rate=$4
  shift 4
  if [ "$(tail -n 1 "$out/runs/$model/log.jsonl" 2>/dev/null | grep -c "\"done\".*\"step\":$steps}")" = 0 ]; then
    "$learner" train "$model" "${common[@]}" --steps "$steps" --batch "$batch" --learning-rate "$rate" "$@" -o "$out/runs/$model"
  fi
}
train geometry 6000 2 5e-4
train albedo 6000 2 5e-4
train rss 6000 2 5e-4 --recolour --balanced
for prior in geometry albedo rss; do priors+=("$out/runs/$prior"); done
train finetune 1500 1 5e-4 --warmup 100 --recolour --balanced --guidance priors --priors "${priors[@]}"
"$learner" evaluate "${priors[@]}" "$out/runs/finetune" --data "$out/open/samples" -o "$out/report"
{
  cat "$out/report/evaluation.md"
  printf '| run | steps | loss at first | loss at last | hours |\n|---|---:|---:|---:|---:|\n'
  for model in geometry albedo rss finetune; do
    python3 - "$model" "$out/runs/$model/log.jsonl" <<'TABLE'
import json, sys
lines = [json.loads(line) for line in open(sys.argv[2], encoding="utf-8")]
steps = [line for line in lines if "loss" in line]
mean = lambda some: sum(line["loss"] for line in some) / len(some)
hours = sum(line.get("seconds", 0) for line in lines if line.get("event") == "done") / 3600
print(f"| {sys.argv[1]} | {steps[-1]['step']} | {mean(steps[:20]):.4f} | {mean(steps[-20:]):.4f} | {hours:.2f} |")
TABLE
  done
} >"$out/results.md"
echo "$out/results.md"
