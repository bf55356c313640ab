# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""ROS 2's sensor_msgs, those that are on the bus."""

from dataclasses import dataclass, field

from edgefusion.messages.idl import Message, float32, float64, float64x9, float64x12, sequence, uint8, uint32
from edgefusion.messages.std_msgs import Header


def _zeros9() -> float64x9:
    return [0.0] * 9


def _zeros12() -> float64x12:
    return [0.0] * 12


@dataclass(frozen=True)
class LaserScan(Message, typename="sensor_msgs/msg/LaserScan"):
    """One sweep; header.stamp: when the first beam was measured. Ranges [m] as in REP 117."""

    header: Header = field(default_factory=Header)
    angle_min: float32 = 0.0
    angle_max: float32 = 0.0
    angle_increment: float32 = 0.0
    time_increment: float32 = 0.0
    scan_time: float32 = 0.0
    range_min: float32 = 0.0
    range_max: float32 = 0.0
    ranges: sequence[float32] = field(default_factory=list)
    intensities: sequence[float32] = field(default_factory=list)


@dataclass(frozen=True)
class CompressedImage(Message, typename="sensor_msgs/msg/CompressedImage"):
    """format: as "jpeg" or "bgr8; jpeg compressed bgr8". data: the file."""

    header: Header = field(default_factory=Header)
    format: str = ""
    data: bytes = b""


@dataclass(frozen=True)
class Image(Message, typename="sensor_msgs/msg/Image"):
    """encoding: as "bgr8". step: bytes from one row of data to the next."""

    header: Header = field(default_factory=Header)
    height: uint32 = 0
    width: uint32 = 0
    encoding: str = ""
    is_bigendian: uint8 = 0
    step: uint32 = 0
    data: bytes = b""


@dataclass(frozen=True)
class RegionOfInterest(Message, typename="sensor_msgs/msg/RegionOfInterest"):
    """Of an image [px]; all zero: the whole of it."""

    x_offset: uint32 = 0
    y_offset: uint32 = 0
    height: uint32 = 0
    width: uint32 = 0
    do_rectify: bool = False


@dataclass(frozen=True)
class CameraInfo(Message, typename="sensor_msgs/msg/CameraInfo"):
    """d: distortion; k, r, p: intrinsics [3, 3], rectification [3, 3], projection [3, 4], row by row."""

    header: Header = field(default_factory=Header)
    height: uint32 = 0
    width: uint32 = 0
    distortion_model: str = ""
    d: sequence[float64] = field(default_factory=list)
    k: float64x9 = field(default_factory=_zeros9)
    r: float64x9 = field(default_factory=_zeros9)
    p: float64x12 = field(default_factory=_zeros12)
    binning_x: uint32 = 0
    binning_y: uint32 = 0
    roi: RegionOfInterest = field(default_factory=RegionOfInterest)


@dataclass(frozen=True)
class BatteryState(Message, typename="sensor_msgs/msg/BatteryState"):
    """V, degrees Celsius, A (negative while it is discharged), Ah; percentage from 0 to 1. NaN: not measured."""

    POWER_SUPPLY_STATUS_UNKNOWN = 0
    POWER_SUPPLY_STATUS_CHARGING = 1
    POWER_SUPPLY_STATUS_DISCHARGING = 2
    POWER_SUPPLY_STATUS_NOT_CHARGING = 3
    POWER_SUPPLY_STATUS_FULL = 4
    POWER_SUPPLY_HEALTH_UNKNOWN = 0
    POWER_SUPPLY_HEALTH_GOOD = 1
    POWER_SUPPLY_HEALTH_OVERHEAT = 2
    POWER_SUPPLY_HEALTH_DEAD = 3
    POWER_SUPPLY_HEALTH_OVERVOLTAGE = 4
    POWER_SUPPLY_HEALTH_UNSPEC_FAILURE = 5
    POWER_SUPPLY_HEALTH_COLD = 6
    POWER_SUPPLY_HEALTH_WATCHDOG_TIMER_EXPIRE = 7
    POWER_SUPPLY_HEALTH_SAFETY_TIMER_EXPIRE = 8
    POWER_SUPPLY_TECHNOLOGY_UNKNOWN = 0
    POWER_SUPPLY_TECHNOLOGY_NIMH = 1
    POWER_SUPPLY_TECHNOLOGY_LION = 2
    POWER_SUPPLY_TECHNOLOGY_LIPO = 3
    POWER_SUPPLY_TECHNOLOGY_LIFE = 4
    POWER_SUPPLY_TECHNOLOGY_NICD = 5
    POWER_SUPPLY_TECHNOLOGY_LIMN = 6

    header: Header = field(default_factory=Header)
    voltage: float32 = 0.0
    temperature: float32 = 0.0
    current: float32 = 0.0
    charge: float32 = 0.0
    capacity: float32 = 0.0
    design_capacity: float32 = 0.0
    percentage: float32 = 0.0
    power_supply_status: uint8 = 0
    power_supply_health: uint8 = 0
    power_supply_technology: uint8 = 0
    present: bool = False
    cell_voltage: sequence[float32] = field(default_factory=list)
    cell_temperature: sequence[float32] = field(default_factory=list)
    location: str = ""
    serial_number: str = ""
