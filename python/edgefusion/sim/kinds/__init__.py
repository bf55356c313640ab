# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What may stand in a world: one module per family of objects."""
