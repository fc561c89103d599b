#!/usr/bin/env bash
# usage: tests/fuzz.sh [INPUTS] [SEED]
# Builds the readers' fuzzing with the address and undefined behaviour sanitizers and runs it over INPUTS (default
# 5000) damaged files, a function of SEED (default 1) alone. Ends with 0 and says nothing but its table if all is well;
# else build/asan/fuzz_input names what was being read: repeat it with OHB_FUZZ_ONLY=Reader:number.
set -euo pipefail
cd "$(dirname "$0")/.."
cmake --preset asan -DOHB_BUILD_TESTS=ON >/dev/null
targets=(fuzz_test)
# Not grep -q: it would end the pipe early, which pipefail takes for a failure.
if ninja -C build/asan -t targets all | grep '^fuzz_weights_test: phony' >/dev/null; then targets+=(fuzz_weights_test); fi
cmake --build --preset asan --target "${targets[@]}"
export OHB_FUZZ_INPUTS="${1:-5000}" OHB_FUZZ_SEED="${2:-1}" OHB_FUZZ_JOURNAL="$PWD/build/asan/fuzz_input"
export ASAN_OPTIONS="detect_leaks=1:allocator_may_return_null=1:max_allocation_size_mb=6000"
export UBSAN_OPTIONS="halt_on_error=1:print_stacktrace=1" LSAN_OPTIONS="suppressions=$PWD/tests/lsan_suppressions.txt"
for target in "${targets[@]}"; do
  build/asan/bin/"$target" --gtest_brief=1 || { echo "while reading $(cat "$OHB_FUZZ_JOURNAL")" >&2; exit 1; }
done
