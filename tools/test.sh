#!/usr/bin/env bash
# Installs, builds with warnings as errors, and runs everything that must hold: format, lint, unit tests, end to end.
#   tools/test.sh [--fast]            (--fast: the tests labeled fast only, no lint)
fast=false
if [ "${1:-}" = --fast ]; then
  fast=true
elif [ $# -gt 0 ]; then
  sed -n '2,3s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
  exit 2
fi
set --
browser=()  # Ubuntu has Chromium as a snap alone
if grep -qx 'ID=debian' /etc/os-release; then browser=(chromium); fi
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" clang-format clang-tidy libraw-bin \
  pybind11-dev python3-dev python3-pip python3-numpy python3-pytest python3-matplotlib python3-opencv parallel dpkg-dev \
  file help2man pandoc doxygen "${browser[@]}"

sources() { git ls-files '*.h' '*.cpp'; }
if [[ $(clang-format --version) == *" 14."* ]]; then  # Debian 12's; later ones break other lines
  sources | xargs clang-format --dry-run --Werror
else
  echo "format: skipped, needs clang-format 14" >&2
fi

cmake --preset release -DDUALPIXEL_TESTS=ON -DDUALPIXEL_WERROR=ON -DDUALPIXEL_TRAINER=OFF -DDUALPIXEL_ONNX=OFF >/dev/null
cmake --build --preset release

if ! $fast && [[ $(clang-tidy --version) != *" 14."* ]]; then
  echo "lint: skipped, needs clang-tidy 14" >&2  # later ones have further checks
elif ! $fast; then
  # Lint what changed since the main branch last landed; the last commit where that is unknown. The consumer is a project of
  # its own; fuzzers, training and the ONNX exporter are not built here, and clang 14 cannot read LibTorch's headers as C++20.
  linted=('*.cpp' ':!tools/train_segmentation' ':!tools/export_onnx' ':!tests/training' ':!tests/onnx' ':!tests/consumer' ':!tests/fuzz')
  base=$(git merge-base HEAD origin/main 2>/dev/null || true)
  if [ -n "$base" ] && [ "$base" != "$(git rev-parse HEAD)" ]; then
    changed=$(git diff --name-only --diff-filter=d "$base" -- "${linted[@]}")
  else
    changed=$(git diff-tree --root --no-commit-id --name-only --diff-filter=d -r HEAD -- "${linted[@]}")
  fi
  if [ -n "$changed" ]; then
    # clang-tidy reads one file at a time, without GCC's precompiled headers.
    cmake --preset release -B build/lint -DDUALPIXEL_TESTS=ON -DDUALPIXEL_TRAINER=OFF -DDUALPIXEL_ONNX=OFF \
      -DCMAKE_UNITY_BUILD=OFF -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON >/dev/null
    echo "$changed" | xargs -P "$(nproc)" -n 1 clang-tidy -p build/lint --quiet --warnings-as-errors='*'
  fi
fi

label=()
if $fast; then label=(-L fast); fi
# One more than cores: some tests wait for programs that they kill or ask.
export OMP_WAIT_POLICY=passive  # waiting threads leave the cores to others
ctest --test-dir build/release --output-on-failure -j "$(($(nproc) + 1))" "${label[@]}"
