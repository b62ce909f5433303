#!/usr/bin/env bash
# The three worked sessions of docs/can-sessions.md on a real CAN socket (run by documented_sessions.py through
# toolchain/with-can): a capture and what the commands say, by section.
#
#   documented_sessions.sh SLIPSTACK MODEL
set -u
slipstack=$1 model=$2
here=$(mktemp -d)
cp "$model" "$here/axis.toml"
cd "$here" || exit 1
candump -L vcan0 >dump.log &
dump=$!
"$slipstack" node --can vcan0 --node 5 >/dev/null &
node=$!
heard() { for _ in $(seq 100); do grep -q "$1" dump.log && return; sleep 0.1; done; }
section() { sleep 0.3; echo "== $1"; cat dump.log; : >dump.log; echo "== $1 said"; cat said 2>/dev/null; rm -f said; }
send() { cansend vcan0 "$1"; sleep 0.05; }

heard '705#00'
send 605#4000100000000000
send 605#2B17100064000000
heard '705#7F'
send 000#0105
send 205#060008
send 205#070008
send 205#0F0008
heard '185#37'
send 305#0F00400D0300
send 080#
heard '285#'
send 205#000000
sleep 0.2
send 605#2B171000E8030000
send 000#8005
section bring_up
"$slipstack" deploy axis.toml --can vcan0 --node 5 >said
section deploy
"$slipstack" record --can vcan0 --node 5 --seconds 1 --rate 200 --out log.csv >said
"$slipstack" record --can vcan0 --node 5 --trace --out trace.csv >>said
"$slipstack" status --can vcan0 --node 5 >>said
section record
kill -TERM $node
wait $node
kill $dump
rm -rf "$here"
