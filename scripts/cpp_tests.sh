#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
# Builds and runs the C++ tests: cpp_tests.sh BUILD_FOLDER SANITIZERS
set -eu
"$(dirname "$0")/cpp_build.sh" "$1" doctest/doctest.h doctest-dev \
  -DCMAKE_BUILD_TYPE=RelWithDebInfo -DEDGEFUSION_TESTS=ON -DEDGEFUSION_SANITIZE="$2"
echo "edgefusion: C++ tests under $2"
"$1/cpp/tests/edgefusion_tests"
