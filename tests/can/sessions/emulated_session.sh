#!/usr/bin/env bash
# The real programs against the emulated controller on slcan0 (run by emulated_test.py through toolchain/with-can
# --serial): candump and cansend as peers, LSS, the commands of slipstack, a move of the axis. Prints what
# emulated_test.py looks at; the capture comes last.
#
#   emulated_session.sh SLIPSTACK MODEL MODEL_BYTES      the size of 2141h, as four bytes of a frame
set -u
slipstack=$1 model=$2 model_bytes=$3
here=$(mktemp -d)
candump -L slcan0 >"$here/dump.log" &
dump=$!
# Waits for a frame in the capture, at most 20 s.
heard() { for _ in $(seq 200); do grep -q "$1" "$here/dump.log" && return; sleep 0.1; done; }
section() { echo "== $1"; }

section lss
heard '705#7F'
cansend slcan0 7E5#0401000000000000
cansend slcan0 7E5#1106000000000000
heard '7E4#1100'
cansend slcan0 7E5#1700000000000000
heard '7E4#1700'
cansend slcan0 7E5#0400000000000000
cansend slcan0 000#8200
heard '706#00'
section status
"$slipstack" status --can slcan0 --node 6
section deploy
"$slipstack" deploy "$model" --can slcan0 --node 6
section move
# One after the other: a controlword that another overtakes before the next tick has not been there.
write() { cansend slcan0 "606#$1"; }
until_state() { for _ in $(seq 40); do "$slipstack" status --can slcan0 --node 6 | grep -q "$1" && return; sleep 0.1; done; }
write 2F60600001000000
write 2B40600006000000
until_state 'ready to switch on'
write 2B40600007000000
until_state 'switched on'
write 2B4060000F000000
until_state 'operation enabled'
write 237A600030750300
write 2B4060001F000000
until_state 'position   2266'
section trace
"$slipstack" record --can slcan0 --node 6 --trace --decimation 4 --out "$here/trace.csv"
head -5 "$here/trace.csv"
grep -c '^[0-9]' "$here/trace.csv"
section moved
"$slipstack" status --can slcan0 --node 6
section record
"$slipstack" record --can slcan0 --node 6 --seconds 2 --rate 100 --out "$here/log.csv"
grep -c '^[0-9]' "$here/log.csv"
section refused
"$slipstack" deploy "$model" --can slcan0 --node 6
echo "status $?"
write 2B40600000000000
until_state 'switch on disabled'
section foreign
cansend slcan0 606#R
cansend slcan0 12345678#1122334455667788
# A block download of the model begins, one segment, and the master is gone.
cansend slcan0 "606#C6412100$model_bytes"
cansend slcan0 606#0101020304050607
heard '586#8041210000000405'
"$slipstack" status --can slcan0 --node 6
kill $dump
section capture
cat "$here/dump.log"
rm -rf "$here"
