# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Prints requirements of pyproject.toml, to install them without building the project: those of an extra, or of Eigen.

usage: requirements.py EXTRA | eigen
"""

import sys
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    from pip._vendor import tomli as tomllib

content = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
if sys.argv[1] == "eigen":
    print(*(each for each in content["build-system"]["requires"] if each.startswith("cmeel-eigen")))
else:
    print(*content["project"]["optional-dependencies"][sys.argv[1]])
