#!/usr/bin/env bash
# Runs the tests in four sets beside each other, because most of them wait: for leases,
# back-offs and robots in slow motion. Those that choose files run by themselves:
# scripts/test.sh PYTHON [PYTEST-ARGUMENT ...]
set -u
python=$1
shift
for argument in "$@"; do
  if [ -e "${argument%%::*}" ]; then exec "$python" -m pytest "$@"; fi
done

maths="tests/estimation tests/robot_model tests/robot_sim tests/experiments"  # no processes
bus="tests/bus"
alone="tests/services/robot_sim tests/services/estimators"
demo="tests/deploy/test_demo.py"
robots="$alone tests/browser tests/system $demo"  # parts and whole robots, one after the other
network="tests/multihost"  # after those: counts seconds of a cable that is out
named="$maths $bus $robots $network tests/services tests/data tests/soak"
services=$(ls -d tests/*/ tests/services/*/ | sed 's:/$::' | grep -vxE "(${named// /|}|.*/__pycache__)")
status=5  # pytest's where no test was chosen, by -k for instance
logs=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$logs"' EXIT

note() {  # STATUS: keeps the first failure of all sets
  if [ "$1" != 5 ] && { [ "$status" = 5 ] || [ "$status" = 0 ]; }; then status=$1; fi
}

finish() {  # PID LOG: waits for a set in the background
  wait "$1"
  note $?
  cat "$logs/$2"
}

nice -n 19 "$python" -m pytest -o timeout=900 "$@" $maths >"$logs/maths" 2>&1 &
maths_pid=$!
"$python" -m pytest "$@" $bus >"$logs/bus" 2>&1 &
bus_pid=$!
"$python" -m pytest "$@" $services --ignore="$demo" >"$logs/services" 2>&1 &
services_pid=$!
"$python" -m pytest "$@" $robots
note $?
finish "$bus_pid" bus
finish "$services_pid" services
"$python" -m pytest "$@" $network
note $?
finish "$maths_pid" maths
exit "$status"
