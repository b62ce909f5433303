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
"$slipstack" node --can vcan0 --node 5 --effects viscous --strength 6 >/dev/null &
node=$!
await_frame() { for _ in $(seq 100); do grep -q "$1" dump.log && return; sleep 0.1; done; }
section() { sleep 0.3; echo "== $1"; cat dump.log; : >dump.log; echo "== $1 said"; cat said 2>/dev/null; rm -f said; }
send() { cansend vcan0 "$1"; sleep 0.05; }
little_endian() { for i in 0 8 16 24; do printf %02X $(($1 >> i & 255)); done; }
# A move: profile velocity (counts/s) and target (counts); bit 4 of the controlword down, then up.
go() {
  send 605#23816000$(little_endian "$2")
  send 305#0F00$(little_endian "$1")
  send 305#1F00$(little_endian "$1")
  sleep 0.3
}

await_frame '705#00'
send 605#4000100000000000
send 605#2B17100064000000
await_frame '705#7F'
# By hand, commands come later than every 50 ms.
send 605#2B03240000000000
send 000#0105
send 205#060008
send 205#070008
send 205#0F0008
await_frame '185#37'
send 305#0F00400D0300
send 080#
await_frame '285#'
send 205#000000
sleep 0.2
send 605#2B171000E8030000
send 000#8005
section bring_up
"$slipstack" deploy axis.toml --can vcan0 --node 5 >said
section deploy
send 000#0105
send 205#060001
send 205#070001
send 205#0F0001
await_frame '185#3706'
"$slipstack" record --can vcan0 --node 5 --seconds 12 --rate 500 --out log.csv >said &
recorder=$!
await_frame '385#'
# Small moves at several places, slow traverses, fast ones.
go 200060 2000
go 200000 1000
go 230000 100000
go 230080 1000
go 180000 200000
go 179900 500
go 190000 150000
go 182000 10000
go 250000 250000
go 249000 2000
go 160000 220000
go 180000 20000
kill -0 $recorder 2>/dev/null && all_moves=yes
wait $recorder
send 205#000000
"$slipstack" diagnose log.csv | head -2 >>said
"$slipstack" record --can vcan0 --node 5 --trace --out trace.csv >>said
"$slipstack" status --can vcan0 --node 5 >>said
section record
echo "== moves"; echo "all within the record: ${all_moves:-no}"
kill -TERM $node
wait $node
kill $dump
rm -rf "$here"
