#!/usr/bin/env bash
# usage: count_tests.sh LastTest.log   What ctest does not say of the suites that it ran: how many tests they held, and which
# of these were skipped.
set -euo pipefail
grep -a '^\[==========\] [0-9]* tests\? .* ran\.' "$1" |
  awk '{ sum += $2 } END { print "GoogleTest ran " sum " tests" }'
grep -aoP '^\[  SKIPPED \] \K[\w/]+\.[\w/]+$' "$1" | sort -u |
  awk '{ names = names "\n  " $0 } END { if (NR) print "skipped among them: " NR names }'
