# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What edgefusion raises for input that it refuses."""


class RefusedError(ValueError):
    """Bad input: one line that names the thing, what was expected and what came. The commands exit with 2."""
