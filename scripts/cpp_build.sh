#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
# Configures and builds the C++ core without Python: cpp_build.sh BUILD_FOLDER HEADER PACKAGE [CMAKE_OPTION ...]
# HEADER is what the build needs from the system, PACKAGE is where it comes from.
set -eu
cd "$(dirname "$0")/.."
PATH="$(cd "${VENV:-.venv}/bin" && pwd):$PATH"
build=$1 header=$2 package=$3
shift 3

echo "#include <$header>" | "${CXX:-c++}" -x c++ -std=c++17 -fsyntax-only - 2>/dev/null || {
  echo "edgefusion: $header is missing: sudo apt-get install $package" >&2
  exit 1
}
eigen=$(python -c "import sysconfig; print(sysconfig.get_paths()['purelib'] + '/cmeel.prefix')")
cmake -S . -B "$build" -G Ninja -Wno-dev -DEDGEFUSION_EIGEN_PREFIX="$eigen" "$@" >/dev/null
cmake --build "$build"
