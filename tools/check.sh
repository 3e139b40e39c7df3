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
  tsan) configure=(--preset tsan) ;;
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
