#!/usr/bin/env bash
# Runs the tests. Those that start no processes fill the pauses of the others, unless
# some are chosen: scripts/test.sh PYTHON [PYTEST-ARGUMENT ...]
set -u
python=$1
shift
for argument in "$@"; do
  if [ -e "${argument%%::*}" ]; then exec "$python" -m pytest "$@"; fi
done

maths="tests/estimation tests/robot_model tests/robot_sim tests/experiments"
others=$(ls -d tests/*/ | sed 's:/$::' | grep -vxE "${maths// /|}|tests/(data|soak|__pycache__)")
log=$(mktemp)
trap 'kill "$beside" 2>/dev/null; rm -f "$log"' EXIT
nice -n 10 "$python" -m pytest -o timeout=900 "$@" $maths >"$log" 2>&1 &
beside=$!
"$python" -m pytest "$@" $others
first=$?
wait "$beside"
second=$?
cat "$log"
nothing=5  # pytest's status where no test was chosen, by -k for instance
if [ "$first" = $nothing ]; then exit "$second"; fi
if [ "$second" = $nothing ]; then second=0; fi
exit $((first ? first : second))
