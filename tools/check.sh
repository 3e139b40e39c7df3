#!/usr/bin/env bash
# The tests labeled fast, built with a sanitizer or run by valgrind.
#   tools/check.sh asan|ubsan|tsan|valgrind [TEST...]        (TEST: a folder of tests, such as capture; all of them)
check=${1:-}
names=("${@:2}")
set --
packages=(clang)  # compiles with sanitizers in a fifth of GCC's time
case $check in
  asan) configure=(--preset asan) ;;  # undefined behavior, too
  ubsan) configure=(--preset asan -B build/ubsan -DDUALPIXEL_SANITIZE=undefined) ;;
  tsan)
    configure=(--preset tsan)
    packages=(clang dpkg-dev)
    ;;
  valgrind)
    configure=(--preset debug -B build/valgrind -DCMAKE_BUILD_TYPE=RelWithDebInfo)
    packages=(valgrind)
    ;;
  *)
    echo "tools/check.sh: '$check': must be asan, ubsan, tsan or valgrind" >&2
    exit 2
    ;;
esac
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" "${packages[@]}"

# The distribution's TBB, built with the thread sanitizer, which otherwise sees none of its synchronization and takes every
# parallel loop for a race. Tests and programs load it from here on.
use_tbb_with_thread_sanitizer() {
  local folder list version
  version=$(dpkg-query -W -f='${Version}' libtbb12)
  folder=$PWD/build/tsan/tbb-${version//[^A-Za-z0-9.]/-}
  if [ ! -d "$folder/source" ]; then
    rm -rf "$folder"
    mkdir -p "$folder/apt/sources" "$folder/apt/lists/partial" "$folder/unpacked"
    for list in /etc/apt/sources.list /etc/apt/sources.list.d/*; do
      if [ -e "$list" ]; then sed 's/^Types: .*/Types: deb-src/; s/^deb /deb-src /' "$list" >"$folder/apt/sources/${list##*/}"; fi
    done
    local apt=(apt-get -q -o "Dir::Etc::SourceParts=$folder/apt/sources" -o Dir::Etc::SourceList=/dev/null
               -o "Dir::State::Lists=$folder/apt/lists")
    (cd "$folder/unpacked" && "${apt[@]}" update && "${apt[@]}" source "$(dpkg-query -W -f='${source:Package}=${source:Version}' libtbb12)")
    mv "$folder"/unpacked/onetbb-*/ "$folder/source"
  fi
  cmake -S "$folder/source" -B "$folder/build" -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    -DTBB_OUTPUT_DIR_BASE=tbb -DTBB_SANITIZE=thread -DTBB_TEST=OFF -DTBBMALLOC_BUILD=OFF -DTBB_STRICT=OFF \
    -DTBB_DISABLE_HWLOC_AUTOMATIC_SEARCH=ON
  cmake --build "$folder/build"
  export LD_LIBRARY_PATH=$folder/build/tbb_relwithdebinfo
  ls "$LD_LIBRARY_PATH/libtbb.so.12" >/dev/null
  # Locks are taken in libraries that the sanitizer does not see release them; some tests fork.
  export TSAN_OPTIONS="${TSAN_OPTIONS:+$TSAN_OPTIONS:}suppressions='$PWD/tests/tsan_suppressions.txt':detect_deadlocks=0:die_after_fork=0"
}
if [ "$check" = tsan ]; then use_tbb_with_thread_sanitizer; fi

cmake "${configure[@]}" -DDUALPIXEL_TESTS=ON >/dev/null
if [ ${#names[@]} -eq 0 ]; then names=(capture simulator pipeline scenes datasets evaluation tools); fi
cmake --build "build/$check" --target "${names[@]/#/test_}"
for name in "${names[@]}"; do
  if [ "$check" = valgrind ]; then
    valgrind -q --error-exitcode=1 "build/valgrind/tests/test_$name" --gtest_filter='-Slow*:Sweep*'
  else
    ctest --test-dir "build/$check" -L fast -R "^$name\\." --output-on-failure
  fi
done
