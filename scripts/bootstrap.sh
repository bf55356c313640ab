#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
# Creates the virtual environment, or says in one line what is missing and how to get it.
set -eu
PYTHON=${PYTHON:-python3}
VENV=${VENV:-.venv}

missing() {
  echo "edgefusion: $1" >&2
  exit 1
}

command -v "$PYTHON" >/dev/null ||
  missing "no $PYTHON on this machine: sudo apt-get install python3 python3-venv python3-dev, or make PYTHON=/path/to/python"
version=$("$PYTHON" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
"$PYTHON" -c 'import sys; sys.exit(sys.version_info < (3, 8))' ||
  missing "Python 3.8 or newer is needed, $PYTHON is $version: make PYTHON=python3.8"
"$PYTHON" -c 'import ensurepip, venv' 2>/dev/null ||
  missing "$PYTHON has no venv module: sudo apt-get install python$version-venv"
"$PYTHON" -c 'import os, sys, sysconfig; sys.exit(not os.path.exists(os.path.join(sysconfig.get_paths()["include"], "Python.h")))' ||
  missing "$PYTHON has no headers (Python.h): sudo apt-get install python$version-dev"
command -v "${CXX:-c++}" >/dev/null || command -v g++ >/dev/null || command -v clang++ >/dev/null ||
  missing "no C++ compiler on this machine: sudo apt-get install g++"

"$PYTHON" -m venv "$VENV"
"$VENV/bin/python" -m pip install -q --upgrade 'pip>=22'
