#!/usr/bin/env bash
# `slipstack commission` on a real CAN socket, beside the node that is its drive (run by commission_session_test.py
# through toolchain/with-can): in time with the clock, so for some minutes.
#
#   commission_session.sh SLIPSTACK PERIOD_MS PACE
set -u
slipstack=$1 period=$2 pace=$3
here=$(mktemp -d)
"$slipstack" node --can vcan0 --node 5 --seed 4 --effects viscous --strength 6 --reversed motor --pace "$pace" --flash "$here/flash" &
node=$!
sleep 1
commission() { "$slipstack" commission --can vcan0 --node 5 --period "$period" --from 0 --to 400 --out "$here/axis" 2>&1; echo "status $?"; }
echo "== killed"
"$slipstack" commission --can vcan0 --node 5 --period "$period" --from 0 --to 400 --out "$here/axis" >/dev/null 2>&1 &
killed=$!
for _ in $(seq 600); do grep -q '"feedback"' "$here/axis/stages.json" 2>/dev/null && break; sleep 0.1; done
kill -KILL $killed
wait $killed 2>/dev/null
sleep 1
echo "== commission"
commission
kill -TERM $node
wait $node
echo "== stored"
"$slipstack" node --can vcan0 --node 5 --seed 4 --effects viscous --strength 6 --reversed motor --pace "$pace" --flash "$here/flash" &
node=$!
sleep 1
"$slipstack" status --can vcan0 --node 5
"$slipstack" object --can vcan0 --node 5 2500:02
kill -TERM $node
wait $node
rm -rf "$here"
