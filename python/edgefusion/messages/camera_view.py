# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Where the camera sees what the laser has measured."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from edgefusion.types import Detection, read_only

Matrix = npt.NDArray[np.float64]


@dataclass(frozen=True)
class CameraView:
    """T_camera_laser, T_base_laser [4, 4]: a calibration's. bearing_sigma: of a detection's bearing [rad].

    T_camera_base [4, 4]: maps base_link's coordinates into the camera's.
    """

    T_camera_laser: Matrix
    T_base_laser: Matrix
    bearing_sigma: float
    T_camera_base: Matrix = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        T = np.asarray(self.T_camera_laser, float) @ np.linalg.inv(np.asarray(self.T_base_laser, float))
        object.__setattr__(self, "T_camera_base", read_only(T))

    def position_m(self, detection: Detection) -> Matrix:
        """The nearest point of the object, in camera_optical, [3]: as high as the laser is."""
        x_m, y_m = detection.position_m
        seen: Matrix = self.T_camera_base @ np.array([x_m, y_m, self.T_base_laser[2, 3], 1.0])
        return seen[:3]

    def covariance(self, detection: Detection) -> Matrix:
        """Of that position [m^2], [3, 3]: along the beam by the range's sigma, across it by the bearing's."""
        c, s = np.cos(detection.bearing), np.sin(detection.bearing)
        R = self.T_camera_base[:3, :3]
        along = R @ np.array([c, s, 0.0]) * detection.distance_sigma_m
        across = R @ np.array([-s, c, 0.0]) * (detection.distance_m * self.bearing_sigma)
        return np.outer(along, along) + np.outer(across, across)
