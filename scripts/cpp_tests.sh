#!/bin/sh
# Builds and runs the C++ tests: cpp_tests.sh BUILD_FOLDER SANITIZERS
set -eu
VENV=${VENV:-.venv}
PATH="$(cd "$VENV/bin" && pwd):$PATH"

echo '#include <doctest/doctest.h>' | "${CXX:-c++}" -x c++ -std=c++17 -fsyntax-only -DDOCTEST_CONFIG_DISABLE - 2>/dev/null || {
  echo "edgefusion: the C++ tests need doctest: sudo apt-get install doctest-dev" >&2
  exit 1
}
eigen=$(python -c "import sysconfig; print(sysconfig.get_paths()['purelib'] + '/cmeel.prefix')")
cmake -S . -B "$1" -G Ninja -Wno-dev -DCMAKE_BUILD_TYPE=RelWithDebInfo -DEDGEFUSION_TESTS=ON \
  -DEDGEFUSION_SANITIZE="$2" -DEDGEFUSION_EIGEN_PREFIX="$eigen" >/dev/null
cmake --build "$1"
echo "edgefusion: C++ tests under $2"
"$1/cpp/tests/edgefusion_tests"
