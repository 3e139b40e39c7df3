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

# Builds the distribution's TBB with the thread sanitizer, which otherwise sees none of its synchronization and takes every
# parallel loop for a race; prints the folder of the library.
tbb_with_thread_sanitizer() {
  local folder=$PWD/build/tsan/tbb
  if ! compgen -G "$folder/source/onetbb-*" >/dev/null; then
    mkdir -p "$folder/apt/sources" "$folder/apt/lists/partial" "$folder/source"
    for list in /etc/apt/sources.list /etc/apt/sources.list.d/*; do
      if [ -e "$list" ]; then sed 's/^Types: .*/Types: deb-src/; s/^deb /deb-src /' "$list" >"$folder/apt/sources/${list##*/}"; fi
    done
    local apt=(apt-get -q -o "Dir::Etc::SourceParts=$folder/apt/sources" -o Dir::Etc::SourceList=/dev/null
               -o "Dir::State::Lists=$folder/apt/lists")
    (cd "$folder/source" && "${apt[@]}" update && "${apt[@]}" source libtbb12) >&2
  fi
  cmake -S "$folder"/source/onetbb-*/ -B "$folder/build" -G Ninja -DCMAKE_CXX_COMPILER=clang++ \
    -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_SANITIZE=thread -DTBB_TEST=OFF -DTBBMALLOC_BUILD=OFF -DTBB_STRICT=OFF \
    -DTBB_DISABLE_HWLOC_AUTOMATIC_SEARCH=ON >&2
  cmake --build "$folder/build" >&2
  dirname "$folder"/build/*/libtbb.so
}

cmake "${configure[@]}" -DDUALPIXEL_TESTS=ON >/dev/null
if [ ${#names[@]} -eq 0 ]; then names=(capture simulator pipeline scenes datasets evaluation tools); fi
cmake --build "build/$check" --target "${names[@]/#/test_}"
if [ "$check" = tsan ]; then
  LD_LIBRARY_PATH=$(tbb_with_thread_sanitizer)
  export LD_LIBRARY_PATH
fi
for name in "${names[@]}"; do
  if [ "$check" = valgrind ]; then
    valgrind -q --error-exitcode=1 "build/valgrind/tests/test_$name" --gtest_filter='-Slow*:Sweep*'
  else
    ctest --test-dir "build/$check" -L fast -R "^$name\\." --output-on-failure
  fi
done
