#!/usr/bin/env bash
# The real programs on a real CAN socket (run by socketcan_test.py through toolchain/with-can): the node, the
# commands, candump and cansend. Prints what socketcan_test.py looks at; the capture comes last.
#
#   socketcan_session.sh SLIPSTACK MODEL
set -u
slipstack=$1 model=$2
here=$(mktemp -d)
candump -L vcan0 >"$here/dump.log" &
dump=$!
"$slipstack" node --can vcan0 --node 5 --flash "$here/flash" &
node=$!
for _ in $(seq 50); do grep -q '705#00' "$here/dump.log" && break; sleep 0.1; done

section() { echo "== $1"; }
section status
"$slipstack" status --can vcan0 --node 5
section deploy
"$slipstack" deploy "$model" --can vcan0 --node 5
section record
"$slipstack" record --can vcan0 --node 5 --seconds 1 --rate 500 --out "$here/log.csv"
grep -c '^[0-9]' "$here/log.csv"
section trace
"$slipstack" record --can vcan0 --node 5 --trace --out "$here/trace.csv"
grep -c '^[0-9]' "$here/trace.csv"
section refused
"$slipstack" status --can vcan0 --node 9
echo "status $?"
"$slipstack" status --can nonesuch0 --node 5
echo "status $?"
section foreign
cansend vcan0 605#4000100000000000
cansend vcan0 605#4012210100000000
sleep 0.2
cansend vcan0 000#0105
cansend vcan0 205#0600   # too short: EMCY 8210h
cansend vcan0 12345678#1122334455667788
cansend vcan0 605#R
# Error frames as a driver gives them (linux/can/error.h): bus-off, then restarted.
cansend vcan0 20000040#0000000000000000
sleep 0.3
cansend vcan0 20000100#0000000000000000
sleep 0.5
kill -TERM $node
wait $node
echo "node ends with $?"
section stored
"$slipstack" node --can vcan0 --node 5 --flash "$here/flash" &
node=$!
sleep 1
"$slipstack" status --can vcan0 --node 5 | grep model
kill -TERM $node
wait $node
kill $dump
section capture
cat "$here/dump.log"
rm -rf "$here"
