#!/usr/bin/env bash
# What goes wrong around the program: it is killed or stopped, the disk is full or cannot be written, memory ends, nobody
# reads what it prints, two of it write to one place. No part of an output may be taken for a whole one, and every refusal
# is one line.
#   tests/tools/faults/faults.sh PROGRAM SCENES_DIR [KILLS]        (KILLS: of each command, at random moments; default 4)
set -uo pipefail
# What is mounted goes with the namespace, however the script ends.
if [ "$(id -u)" -eq 0 ] && [ -z "${in_namespace:-}" ] && unshare -m true 2>/dev/null; then
  in_namespace=1 exec unshare -m "$0" "$@"
fi
program=$(realpath "$1") scenes=$(realpath "$2") kills=${3:-4}
work=$(mktemp -d)
trap 'umount "$work/full" 2>/dev/null; rm -rf "$work"' EXIT
cd "$work"
failures=0
RANDOM=38

fail() { echo "FAILED: $*"; failures=$((failures + 1)); }

# The status of "$program" "$@", whose stdout and stderr go to the files `out` and `err`.
run() { "${under[@]}" "$program" "$@" >out 2>err </dev/null; }
under=()

# expect_refusal STATUS WHAT: the last run ended with 2 (or STATUS) and one line on stderr that holds WHAT.
expect_refusal() {
  local status=$1 what=$2 name=$3
  [ "$status" -eq 2 ] || fail "$name: status $status: $(head -c 300 err)"
  sed -i '/^dualpixel: warning: /d' err
  [ "$(wc -l <err)" -eq 1 ] && grep -q "^dualpixel: .*$what" err || fail "$name: not one line with '$what': $(head -c 300 err)"
}

# Everything under folder $1 is what it was under folder $2.
expect_same() { diff -r "$1" "$2" >difference || fail "$3: $(head -1 difference)"; }

tiny=(--set sensor.width_px=64 --set sensor.height_px=48 --set sensor.pixel_pitch_um=58.8 --set render.samples_per_pixel=16
      --set render.light_spacing_px=0)
once=(--set burst.frames=1 --set render.photograph_samples_per_pixel=4)
cat >recipe.json <<END
{"version": 1, "count": 4, "seed": 5, "scenes": [{"file": "$scenes/slanted_planes.json"}],
 "set": {"sensor.width_px": 64, "sensor.height_px": 48, "sensor.pixel_pitch_um": 58.8, "burst.frames": 1,
         "render.light_spacing_px": 0, "render.samples_per_pixel": 4, "render.photograph_samples_per_pixel": 2,
         "render.all_in_focus_samples_per_pixel": 2},
 "relations": {"focus": "surface"}, "layout": "npy", "keep": ["left", "right"]}
END

# What each command writes to folder $1; the same bytes every time, but for the times in a portrait's result.json.
simulate() { run simulate "$scenes/slanted_planes.json" -o "$1" "${tiny[@]}" "${once[@]}" --resume; }
portrait() { run portrait capture -o "$1"; }
calibrate() {
  run calibrate "$scenes/calibration_target.json" -o "$1" --focuses 2 --targets 3 --set sensor.width_px=128 \
    --set sensor.height_px=96 --set sensor.pixel_pitch_um=29.4 --set render.samples_per_pixel=16
}
people() { run people -o "$1" --count 3 --composites 2; }
dataset() { run dataset plan "$work/recipe.json" -o "$1" && run dataset render "$1"; }

# Whether folder $1 is what the program itself takes for a whole output.
whole() {
  case $2 in
    dataset) [ -d "$1" ] && run dataset verify "$1" && grep -q '^4 samples are there, 0 of them not' out ;;
    *) [ -d "$1" ] && run info "$1" ;;
  esac
}

echo "killed at $kills moments each"
simulate capture || fail "simulate: $(cat err)"
declare -A half_s
for command in simulate portrait calibrate people dataset; do
  started=$(date +%s%N)
  $command whole_$command || fail "$command: $(cat err)"
  took_ms=$((($(date +%s%N) - started) / 1000000))
  half_s[$command]=$(printf '%d.%03d' $((took_ms / 2000)) $((took_ms / 2 % 1000)))
  whole whole_$command $command || fail "$command: its own output is not whole: $(cat err)"
  rm -f whole_$command/result.json
  for ((kill_nr = 0; kill_nr < kills; ++kill_nr)); do
    moment_ms=$((RANDOM % (took_ms + 1)))
    (
      $command killed &
      sleep "$(printf '%d.%03d' $((moment_ms / 1000)) $((moment_ms % 1000)))"
      pkill -KILL -P $! 2>/dev/null
      kill -KILL $! 2>/dev/null
    ) 2>/dev/null
    wait
    if whole killed $command; then
      rm -f killed/result.json
      expect_same killed whole_$command "$command, killed after $moment_ms ms: taken for whole"
      rm -rf killed
    fi
    $command killed || fail "$command: does not go on after a kill at $moment_ms ms: $(cat err)"
    whole killed $command || fail "$command, gone on after a kill at $moment_ms ms: $(cat err)"
    rm -f killed/result.json
    find killed -name '.dualpixel-*.tmp' -exec rm -rf {} +  # as SECURITY.md says, a kill leaves them beside the rest
    expect_same killed whole_$command "$command, gone on after a kill at $moment_ms ms"
    rm -rf killed killed.resume .dualpixel-*
  done
done

echo "stopped by a signal"
stopped=0 which=0 signals=(TERM HUP QUIT INT XCPU)
for command in simulate portrait calibrate people dataset; do
  signal=${signals[$((which++ % ${#signals[@]}))]}
  $command stopped 2>/dev/null &
  sleep "${half_s[$command]}"
  pkill -$signal -P $!
  wait $!
  status=$?
  ended=$((128 + $(kill -l $signal)))
  [ $status -eq $ended ] && stopped=$((stopped + 1))
  [ $status -eq $ended ] || [ $status -eq 0 ] || fail "$command, stopped: status $status: $(cat err)"
  left=$(find . -name '.dualpixel-*')
  [ -z "$left" ] || fail "$command, stopped, leaves $left"
  $command stopped || fail "$command: does not go on after it was stopped: $(cat err)"
  whole stopped $command || fail "$command, gone on after it was stopped: $(cat err)"
  rm -rf stopped stopped.resume
done

[ $stopped -gt 0 ] || fail "no command was stopped before its end"

echo "disk full, read-only"
if mkdir full && mount -t tmpfs -o size=16k none full 2>/dev/null; then
  for command in simulate portrait calibrate people; do
    $command full/out
    expect_refusal $? full/out "$command on a full disk"
    rm -rf full/out full/out.resume
    [ -z "$(ls -A full)" ] || fail "$command on a full disk leaves $(ls -A full)"
  done
  dataset full/out  # its samples fail one by one
  status=$?
  [ $status -eq 5 ] && [ "$(wc -l <err)" -eq 1 ] || fail "dataset on a full disk: status $status: $(cat err)"
  whole full/out dataset && fail "dataset on a full disk: taken for whole"
  rm -rf full/out
  mount -o remount,ro full
  for command in simulate portrait calibrate people dataset; do
    $command full/out
    expect_refusal $? 'full/out' "$command on a read-only disk"
  done
  umount full
else
  echo "skipped: a small tmpfs needs root"
fi

# Where memory ends within a library, that may end the program; what the program finds itself is one line. It refuses limits
# below what it and its libraries take. Far below, they end before it begins; OpenBLAS, which OpenCV may bring, even hangs.
echo "out of memory"
by_signal=0
least_mb=$("$program" --max-memory 1 info capture 2>&1 | sed -n 's/.*must be at least \([0-9]*\) MB.*/\1/p')
[ -n "$least_mb" ] || { fail "--max-memory 1 does not name the least that is allowed"; exit 1; }
for command in simulate portrait calibrate people dataset; do
  for more_mb in -30 0 30 130 330 730 1830; do
    limit_mb=$((least_mb + more_mb))
    rm -rf short
    (
      ulimit -v $((limit_mb * 1024))
      under=(timeout -k 5 60)
      $command short
    ) 2>/dev/null
    status=$?
    if [ $status -eq 0 ]; then
      whole short $command || fail "$command in $limit_mb MB: not whole: $(head -c 300 err)"
    elif [ $status -eq 124 ] || [ $status -eq 137 ]; then
      fail "$command in $limit_mb MB: not done after a minute"
    elif [ $status -ge 126 ]; then
      by_signal=$((by_signal + 1))
    else
      # A warning may come before it.
      [ $status -eq 2 ] || [ "$command $status" = 'dataset 5' ] && [ "$(grep -vc '^dualpixel: warning: ' err)" -eq 1 ] ||
        fail "$command in $limit_mb MB: status $status, $(head -c 300 err)"
    fi
    [ $status -eq 0 ] || ! whole short $command || fail "$command in $limit_mb MB: status $status, and a whole output"
  done
done
echo "  $by_signal of 35 runs were ended by a library or before they began"

echo "nobody reads"
for command in 'info capture' 'info capture --json' '--help' 'portrait --options'; do
  "$program" $command >/dev/full 2>err
  [ $? -eq 1 ] && [ "$(wc -l <err)" -eq 1 ] || fail "$command to a full disk: $(cat err)"
  "$program" $command >&- 2>err
  [ $? -eq 1 ] && [ "$(wc -l <err)" -eq 1 ] || fail "$command without stdout: $(cat err)"
  "$program" $command >&- 2>&- <&-
  [ $? -eq 1 ] || fail "$command without any stream: status $?"
done

echo "two at once"
for command in simulate portrait calibrate people dataset; do
  rm -rf both
  for first_or_second in 1 2; do
    (
      mkdir -p run_$first_or_second && ln -sfn ../capture run_$first_or_second/capture && cd run_$first_or_second
      $command ../both
      status=$?
      [ $status -eq 0 ] || { [ $status -eq 2 ] && [ "$(wc -l <err)" -eq 1 ]; } || echo "$command: $status $(cat err)" >>../problems
    ) &
  done
  wait
  whole both $command || fail "two of $command at once: $(cat err)"
  rm -f both/result.json
  expect_same both whole_$command "two of $command at once"
done
[ ! -s problems ] || fail "two at once: $(cat problems)"

[ $failures -eq 0 ] && echo "all faults met" || exit 1
