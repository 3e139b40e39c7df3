#!/usr/bin/env bash
# Installs what is missing on Debian 12 or 13: sourced by demo.sh, test.sh and test_training.sh.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# openimageio-tools: libopenimageio-dev's CMake files name its programs, and fail where they are not installed.
packages=(
  g++ cmake ninja-build pkg-config
  libembree-dev libopenimageio-dev openimageio-tools libopenexr-dev libtiff-dev libraw-dev zlib1g-dev
  libtinygltf-dev libglm-dev libtbb-dev nlohmann-json3-dev libfmt-dev libcli11-dev libxxhash-dev
  libeigen3-dev libgtest-dev libvalijson-dev libdnnl-dev
  "$@"
)
missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
  as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    as_root=(sudo)
    if ! command -v sudo >/dev/null; then
      echo "not root, and no sudo; as root: apt-get install --no-install-recommends ${missing[*]}" >&2
      exit 2
    fi
  fi
  echo "Installing: ${missing[*]}" >&2
  "${as_root[@]}" apt-get update -q >&2
  DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -q --no-install-recommends "${missing[@]}" >&2
fi
