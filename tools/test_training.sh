#!/usr/bin/env bash
# Installs LibTorch, ONNX and OpenCV, builds the trainer and the ONNX exporter in build/release, and runs their tests,
# slow ones included. tools/test.sh leaves them out: these libraries are large, and nothing else needs them.
#   tools/test_training.sh [gtest arguments]
arguments=("$@")
set --
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" libtorch-dev libonnx-dev libprotobuf-dev libopencv-dev

cmake --preset release -DDUALPIXEL_TESTS=ON -DDUALPIXEL_WERROR=OFF -DDUALPIXEL_TRAINER=ON -DDUALPIXEL_ONNX=ON >/dev/null
cmake --build --preset release --target test_training test_onnx dualpixel_train dualpixel_export_onnx

export OMP_WAIT_POLICY=passive  # waiting threads leave the cores to others
build/release/tests/test_training "${arguments[@]}"
build/release/tests/test_onnx "${arguments[@]}"
