#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
# The whole suite as the Jetson TX2 runs it: Python 3.8 and ONNX Runtime 1.11, from a wheel, not from the sources.
set -euo pipefail
cd "$(dirname "$0")/.."

find_python38() {
  local candidate
  for candidate in python3.8 "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.8.*/bin/python3.8; do
    if "$candidate" -c '' 2>/dev/null; then
      echo "$candidate"
      return
    fi
  done
}

python38=$(find_python38)
if [ -z "$python38" ]; then
  echo 'skipped: no Python 3.8 on this machine (neither on PATH nor from pyenv)'
  exit 0
fi

venv=${TX2_VENV:-.venv-tx2}
"$python38" -m venv --clear "$venv"
"$venv/bin/python" -m pip install -q --upgrade 'pip>=22'
"$venv/bin/python" -m pip install -q -r requirements-tx2.txt '.[cpu,sim,test]'
"$venv/bin/python" -m pip list 2>/dev/null | grep -iE '^(numpy|onnxruntime|eclipse-zenoh|edgefusion) '
"$venv/bin/python" -m pytest
