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
# Waits, at most a minute, until COMMAND is true: a machine under load answers late.
await() { for _ in $(seq 600); do "$@" && return; sleep 0.1; done; }
# Whether a frame WHAT (regular expressions of the capture) came after the first FROM.
came_after() { awk -v from="$1" -v what="$2" '$0 ~ from { on = 1; next } on && $0 ~ what { found = 1 } END { exit !found }' "$here/dump.log"; }
more_answers_than() { [ "$(grep -c 585# "$here/dump.log")" -gt "$1" ]; }
# Sends a frame of an SDO and waits for its answer.
sdo() {
  local answers
  answers=$(grep -c 585# "$here/dump.log")
  cansend vcan0 "$1"
  await more_answers_than "$answers"
}
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
section misused
refused() { "$@" >"$here/said" 2>&1; echo "status $? lines $(wc -l <"$here/said"): $(cat "$here/said")"; }
before=$("$slipstack" status --can vcan0 --node 5 | grep -E 'model|stored')
echo 'not = a model' >"$here/wrong.toml"
refused "$slipstack" deploy "$here/wrong.toml" --can vcan0 --node 5
refused "$slipstack" deploy "$here/none.toml" --can vcan0 --node 5
refused "$slipstack" deploy "$model" --can vcan0 --node 9
refused "$slipstack" record --can vcan0 --node 5 --seconds 1 --out "$here/none/log.csv"
refused "$slipstack" record --can vcan0 --node 9 --seconds 1 --out "$here/left.csv"
refused "$slipstack" record --can nonesuch0 --node 5 --seconds 1 --out "$here/left.csv"
refused "$slipstack" record --can vcan0 --node 5 --seconds 0 --out "$here/left.csv"
refused "$slipstack" record --can vcan0 --node 5 --seconds 1 --rate 5000 --out "$here/left.csv"
refused "$slipstack" node --can nonesuch0 --node 6
refused "$slipstack" node --can vcan0 --node 6 --effects nothing_known
refused "$slipstack" node --can vcan0 --node 6 --flash "$here/wrong.toml"
# Enabled, then locked.
for frame in 605#2F60600001 605#2B40600006 605#2B40600007 605#2B4060000F; do
  sdo "${frame}$(printf '%*s' $((20 - ${#frame})) '' | tr ' ' 0)"
  sleep 0.1
done
refused "$slipstack" deploy "$model" --can vcan0 --node 5
sdo 605#2B40600000000000
sleep 0.1
sdo 605#2F00240A01000000
sleep 0.1
refused "$slipstack" deploy "$model" --can vcan0 --node 5
"$slipstack" status --can vcan0 --node 5 | grep lock
[ "$before" = "$("$slipstack" status --can vcan0 --node 5 | grep -E 'model|stored')" ] && echo "model and store as before"
[ -e "$here/left.csv" ] || echo "no log left"
# The lock was not stored: gone with a reset.
cansend vcan0 000#8105
sleep 0.3
section foreign
sdo 605#4000100000000000
sdo 605#4012210100000000
cansend vcan0 000#0105
cansend vcan0 205#0600   # too short: EMCY 8210h
cansend vcan0 12345678#1122334455667788
cansend vcan0 605#R
# Error frames as a driver gives them (linux/can/error.h): bus-off, then restarted.
cansend vcan0 20000040#0000000000000000
sleep 0.3
cansend vcan0 20000100#0000000000000000
await came_after 085#4081 705#
kill -TERM $node
wait $node
echo "node ends with $?"
section stored
"$slipstack" node --can vcan0 --node 5 --flash "$here/flash" &
node=$!
sleep 1
"$slipstack" status --can vcan0 --node 5 | grep model
section workbench
ip link set lo up
repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../.." && pwd)
python3 -B "$repository/tests/can/sessions/workbench_session.py" "$slipstack" "$model" "$here/session" 2>&1
section update
update_file() {  # NAME BOARD FIRST: 30 KB for each slot that begin with FIRST
  for slot in 1 2; do { printf '%s%s' "$3" $slot; head -c 30000 /dev/urandom; } >"$here/slot$slot.bin"; done
  python3 -B "$repository/toolchain/make-update" --header "$repository/firmware/update/image_header.h" --board "$2" \
    --image 0x08007000 "$here/slot1.bin" --image 0x08047000 "$here/slot2.bin" --out "$here/$1" >/dev/null
}
update_file new.update HOST new
update_file other.update G474 new
update_file crash.update HOST crash
"$slipstack" update "$here/new.update" --can vcan0 --node 5
"$slipstack" update "$here/new.update" --can vcan0 --node 5
refused "$slipstack" update "$here/other.update" --can vcan0 --node 5
refused "$slipstack" update "$here/flash" --can vcan0 --node 5
refused "$slipstack" update "$here/none.update" --can vcan0 --node 5
refused "$slipstack" update "$here/new.update" --can vcan0 --node 9
refused "$slipstack" update "$here/crash.update" --can vcan0 --node 5
"$slipstack" update "$here/new.update" --can vcan0 --node 5
kill -TERM $node
wait $node
kill $dump
section capture
cat "$here/dump.log"
rm -rf "$here"
