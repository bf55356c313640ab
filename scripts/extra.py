# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Prints the requirements of one extra of pyproject.toml, to install them without building the project again."""

import sys
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    from pip._vendor import tomli as tomllib

project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
print(" ".join(project["optional-dependencies"][sys.argv[1]]))
