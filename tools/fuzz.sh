#!/usr/bin/env bash
# Builds the fuzzers with clang and sanitizers, and runs each for a while from its seeds: tests/fuzz, one reader each.
#   tools/fuzz.sh [SECONDS [NAME...]]        (SECONDS of each: 600)
# What they learn stays in build/fuzz/corpus; an input that breaks a reader is kept in build/fuzz/found, and ends the
# script with status 1.
seconds=${1:-600}
if ! [[ $seconds =~ ^[1-9][0-9]*$ ]]; then
  sed -n '2,5s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
  exit 2
fi
names=("${@:2}")
set --
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" clang

cmake --preset fuzz -DDUALPIXEL_TESTS=ON >/dev/null
if [ ${#names[@]} -eq 0 ]; then
  for source in tests/fuzz/*/*_fuzz.cpp; do names+=("$(basename "$source" _fuzz.cpp)"); done
fi
cmake --build --preset fuzz --target "${names[@]/#/fuzz_}"

mkdir -p build/fuzz/found
broken=0
for name in "${names[@]}"; do
  corpus=build/fuzz/corpus/$name
  mkdir -p "$corpus"
  dictionary=build/fuzz/$name.dict
  cat tests/fuzz/dictionaries/json.dict $(ls tests/fuzz/dictionaries/"$name".dict 2>/dev/null) >"$dictionary"
  # A leak's report would be OpenImageIO's own (tests/lsan_suppressions.txt); a picture may be of 2 GB.
  if ASAN_OPTIONS=detect_leaks=0 "build/fuzz/tests/fuzz_$name" "$corpus" "tests/fuzz/seeds/$name" -dict="$dictionary" \
    -max_total_time="$seconds" -timeout=20 -rss_limit_mb=6000 -malloc_limit_mb=3000 -max_len=65536 \
    -artifact_prefix="build/fuzz/found/$name-" -print_final_stats=1 >"build/fuzz/$name.log" 2>&1; then
    echo "$name: $(sed -n 's/^stat::number_of_executed_units: *//p' "build/fuzz/$name.log") inputs, nothing found"
  else
    broken=1
    echo "$name: broken; see build/fuzz/$name.log"
  fi
done
exit $broken
