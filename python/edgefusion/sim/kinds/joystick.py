# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A joystick as large as a simulator's: a flight stick on a console."""

from __future__ import annotations

import numpy as np

from edgefusion.sim import marks, paint
from edgefusion.sim.kinds.form import forward, varied
from edgefusion.sim.kinds.kind import Kind, Size
from edgefusion.sim.mesh import Part, Texture, box, drum, lathe, placed, plain, quad, scaled, standing_box
from edgefusion.sim.paint import Rng

JOYSTICK: Size = (0.44, 0.44, 0.96)
BLACK = (0x2A2C30, 0x34363A, 0x404348)
BODY = (*BLACK, *BLACK, 0x5A5E64, 0x8C9094, 0x2A3448, 0x4A4C40)
SIGNAL = (0xD02820, 0xD02820, 0xE8A020, 0x2C9C4C, 0x2C6CC8)


def _tilted(angle: float) -> tuple[tuple[float, ...], ...]:
    """Turned about the y axis, so that what points up leans away from the front."""
    c, s = float(np.cos(angle)), float(np.sin(angle))
    return ((c, 0.0, -s), (0.0, 1.0, 0.0), (s, 0.0, c))


def _skirt(low: tuple[float, float], high: tuple[float, float], z0: float, z1: float, wall: Texture) -> list[Part]:
    """Four sloping walls between a (depth, width) below and one above."""
    corner = ((1, -1), (1, 1), (-1, 1), (-1, -1))
    below = [(x * low[0] / 2, y * low[1] / 2, z0) for x, y in corner]
    above = [(x * high[0] / 2, y * high[1] / 2, z1) for x, y in corner]
    return [quad((above[i], above[(i + 1) % 4], below[(i + 1) % 4], below[i]), wall) for i in range(4)]


def _bellows(radius: float, tip: float, z0: float, z1: float, folds: int) -> Part:
    """The rubber boot around a stick's foot."""
    profile = [(radius, z0)]
    for i in range(folds):
        share = (i + 1) / folds
        r, z = radius + (tip - radius) * share, z0 + (z1 - z0) * share
        profile += [(r + 0.012, z - 0.4 * (z1 - z0) / folds), (r, z)]
    return lathe(profile, plain(0x18181A), 24)


def _head(rng: Rng, size: float, color: int) -> list[Part]:
    """The block on top of a grip: a hat switch, thumb buttons, a trigger on the far side."""
    face = paint.plastic(rng, (1.5 * size, 1.2 * size), color)
    parts = box((1.3 * size, 1.5 * size, 1.2 * size), (0, 0, 0.6 * size), paint.edged(face, 0.02))
    hat = drum(0.2 * size, 0, 0.12 * size, plain(0x3A3C40), plain(0x505458), 12)
    hat += drum(0.1 * size, 0.12 * size, 0.3 * size, plain(0x101012), plain(0x606468), 10)
    parts += forward(hat, (0.65 * size, 0, 0.85 * size))
    cap = plain(paint.pick(rng, SIGNAL))
    for y in (-0.48, 0.48):
        parts += forward(drum(0.17 * size, 0, 0.14 * size, cap, segments=12), (0.65 * size, y * size, 0.7 * size))
    top = drum(0.24 * size, 1.2 * size, 1.34 * size, plain(paint.pick(rng, SIGNAL)), segments=14)
    parts += placed(top, (0, rng.uniform(-0.35, 0.35) * size, 0))
    trigger = placed(box((0.3 * size, 0.4 * size, 0.9 * size), (0, 0, 0), plain(paint.pick(rng, SIGNAL))),
                     (-0.75 * size, 0, -0.2 * size), rotation=_tilted(-0.4))  # fmt: skip
    return parts + trigger


def _flight_grip(rng: Rng, length: float, color: int) -> list[Part]:
    """A grip shaped for a hand: a rest for its heel, waists for the fingers, a head."""
    radius = rng.uniform(0.15, 0.19) * length
    rubber = paint.grain(rng, paint.flat((0.4, 0.4), color), 0.06)
    shares = ((0.5, 0), (0.5, 0.1), (1.5, 0.13), (1.55, 0.18), (1.05, 0.24), (0.85, 0.34), (1.0, 0.44), (0.88, 0.53),
              (1.05, 0.63), (0.95, 0.7), (1.15, 0.8))  # fmt: skip
    parts = scaled([lathe([(r * radius, z * length) for r, z in shares], rubber, 24)], (1.0, 0.85, 1.0))
    return parts + placed(_head(rng, 1.15 * radius, color), (0.1 * radius, 0, 0.76 * length), rotation=_tilted(-0.25))


def _ball_grip(rng: Rng, length: float, color: int) -> list[Part]:
    """A steel rod with a ball or a sleeve with a button, as on an arcade's console."""
    radius = 0.2 * length
    cap = plain(paint.pick(rng, (*SIGNAL, 0x202022)))
    if rng.random() < 0.6:
        turns = np.linspace(-1.2, np.pi / 2, 10)
        knob = [(radius * float(np.cos(a)), length - radius + radius * float(np.sin(a))) for a in turns]
        return [*drum(0.25 * radius, 0, length - 1.8 * radius, plain(0xA8ACB0), segments=14), lathe(knob, cap, 24)]
    sleeve = [(0.3 * radius, 0), (0.55 * radius, 0.1 * length), (0.45 * radius, 0.5 * length),
              (0.65 * radius, 0.93 * length), (0, 0.93 * length)]  # fmt: skip
    return [lathe(sleeve, plain(color), 20), *drum(0.35 * radius, 0.93 * length, length, cap, segments=14)]


def _console_top(rng: Rng, side: float, color: int) -> tuple[Texture, list[Part]]:
    """The plate around the boot, z = 0 on it: keys, a throttle, lamps."""
    plate = paint.edged(paint.plastic(rng, (side, side), color), 0.015)
    marks.panel(plate, (0.03, 0.03, side - 0.06, side - 0.06), 0.005)
    parts: list[Part] = []
    keys = int(rng.integers(2, 5))
    caps = [plain(paint.pick(rng, SIGNAL)) for _ in range(2)]
    for i in range(keys):
        y = (i + 0.5 - keys / 2) * 0.8 * side / keys
        parts += placed(drum(0.028, 0, 0.022, caps[i % 2], segments=12), (0.4 * side, y, 0))
    slot = 0.4 * side * float(rng.choice((-1, 1)))
    parts += box((0.5 * side, 0.02, 0.006), (-0.1 * side, slot, 0.003), plain(0x08080A))
    return plate, parts + box((0.03, 0.05, 0.07), (rng.uniform(-0.25, 0.1) * side, slot, 0.035), plain(0x6A6E72))


def joystick(rng: Rng) -> list[Part]:
    """A stick with a boot on a console that reaches to the ground."""
    depth, width, height = varied(rng, JOYSTICK)
    color = paint.pick(rng, BODY)
    console, rim = rng.uniform(0.36, 0.38), rng.uniform(0.05, 0.08)  # closed where the laser meets it
    wall = paint.painted_metal(rng, (width, console), color)
    front = wall.copy()
    trim = paint.pick(rng, SIGNAL)
    marks.line(front, [(0, 0.03), (width, 0.03)], trim, 0.01)
    marks.slots(front, (0.2 * width, 0.7 * console, 0.6 * width, 0.18 * console), int(rng.integers(3, 6)))
    words = str(rng.choice(("FLIGHT 3", "PILOT", "X-STICK", "AVIATOR")))
    marks.label(front, words, (0.22 * width, 0.25 * console, 0.56 * width, 0.09), 0x101012, trim)
    parts = standing_box((depth, width, console), wall, {"front": front})
    upper = rng.uniform(0.7, 0.85)
    skirt = paint.plastic(rng, (width, rim), paint.lighter(color, 1.15))
    parts += _skirt((depth, width), (upper * depth, upper * width), console, console + rim, skirt)
    plate, keys = _console_top(rng, upper * width, color)
    z = console + rim
    parts += standing_box((upper * depth, upper * width, 0.004), plate, z=z - 0.004) + placed(keys, (0, 0, z))
    boot = rng.uniform(0.08, 0.12)
    parts.append(_bellows(0.32 * width, 0.13 * width, z, z + boot, int(rng.integers(3, 6))))
    grip = (_flight_grip if rng.random() < 0.75 else _ball_grip)(rng, height - z - 0.6 * boot, paint.pick(rng, BLACK))
    return parts + placed(grip, (0, 0, z + 0.6 * boot), rotation=_tilted(rng.uniform(-0.1, 0.2)))


KINDS = (Kind("joystick", "joystick", JOYSTICK, joystick),)
