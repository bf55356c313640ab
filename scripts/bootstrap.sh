#!/bin/sh
# Creates the virtual environment, or says in one line what is missing and how to get it.
set -eu
PYTHON=${PYTHON:-python3}
VENV=${VENV:-.venv}

missing() {
  echo "edgefusion: $1" >&2
  exit 1
}

command -v "$PYTHON" >/dev/null ||
  missing "no $PYTHON on this machine: sudo apt-get install python3 python3-venv, or PYTHON=/path/to/python make"
"$PYTHON" -c 'import sys; sys.exit(sys.version_info < (3, 8))' ||
  missing "Python 3.8 or newer is needed, $PYTHON is $("$PYTHON" -V 2>&1): PYTHON=python3.8 make"
"$PYTHON" -c 'import ensurepip, venv' 2>/dev/null ||
  missing "$PYTHON has no venv module: sudo apt-get install python3-venv"
command -v "${CXX:-c++}" >/dev/null || command -v g++ >/dev/null || command -v clang++ >/dev/null ||
  missing "no C++ compiler on this machine: sudo apt-get install g++"

"$PYTHON" -m venv "$VENV"
"$VENV/bin/python" -m pip install -q --upgrade 'pip>=22'
