#!/usr/bin/env bash
# usage: count_tests.sh LastTest.log   What ctest does not say of the suites that it ran: how many tests they held, and which
# of these were skipped.
set -euo pipefail
awk '/^\[==========\] [0-9]+ tests? .* ran\./ { sum += $2 }
     /^\[  SKIPPED \] [A-Za-z0-9_\/]+\.[A-Za-z0-9_\/]+$/ { if (!($4 in seen)) { seen[$4] = 1; names = names "\n  " $4; ++skipped } }
     END { print "GoogleTest ran " sum + 0 " tests"; if (skipped) print "skipped among them: " skipped names }' "$1"
