#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
# Builds and runs the C++ benchmark: cpp_bench.sh BUILD_FOLDER [OPTION_OF_GOOGLE_BENCHMARK ...]
set -eu
build=$1
shift
"$(dirname "$0")/cpp_build.sh" "$build" benchmark/benchmark.h libbenchmark-dev -DEDGEFUSION_BENCH=ON
"$build/cpp/bench/edgefusion_bench" "$@"
