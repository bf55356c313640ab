# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""What may stand in a world: every kind by seed, on the ground, of the size that it says, cheap to draw."""

from __future__ import annotations

import numpy as np
import pytest

from edgefusion.sim.kinds import CATALOGUE
from edgefusion.sim.kinds.kind import Kind
from edgefusion.sim.mesh import Parts, size_of
from edgefusion.types import UNKNOWN

KINDS = sorted(CATALOGUE.values(), key=lambda kind: kind.name)
TRIANGLES_MAX = 2500
TEXTURES_MAX = 20
IMAGENET = {
    "ashcan", "barrel", "bookcase", "cash machine", "desk", "electric fan", "file", "joystick", "lampshade",
    "loudspeaker", "mailbox", "microwave", "minivan", "monitor", "oscilloscope", "parking meter", "photocopier",
    "printer", "radio", "refrigerator", "safe", "slot", "space heater", "television", "traffic light",
    "typewriter keyboard", "vending machine", "washer",
}  # fmt: skip
"""Those of ImageNet's labels that kinds carry, as networks spell them."""


def bytes_of(parts: Parts) -> list[bytes]:
    return [array.tobytes() for part in parts for array in (part.vertices, part.uv, part.triangles, part.texture)]


def distinct_textures(parts: Parts) -> int:
    return len({id(part.texture.base if part.texture.base is not None else part.texture) for part in parts})


def height_span(parts: Parts) -> tuple[float, float]:
    heights = np.concatenate([part.vertices[:, 2] for part in parts])
    return float(heights.min()), float(heights.max())


@pytest.fixture(scope="module", params=KINDS, ids=lambda kind: kind.name)
def kind(request: pytest.FixtureRequest) -> Kind:
    found: Kind = request.param
    return found


@pytest.fixture(scope="module")
def parts(kind: Kind) -> Parts:
    return kind.make(7)


def test_the_same_seed_draws_the_same_object(kind: Kind, parts: Parts) -> None:
    assert bytes_of(kind.make(7)) == bytes_of(parts)


def test_another_seed_draws_another_object(kind: Kind, parts: Parts) -> None:
    assert bytes_of(kind.make(8)) != bytes_of(parts)


def test_it_stands_on_the_ground(parts: Parts) -> None:
    assert height_span(parts)[0] == pytest.approx(0, abs=1e-3)


def test_it_is_high_enough_for_the_laser_to_meet_it(parts: Parts) -> None:
    assert height_span(parts)[1] >= 0.45


def test_it_is_about_as_large_as_its_kind_says(kind: Kind, parts: Parts) -> None:
    np.testing.assert_allclose(size_of(parts), kind.size_m, rtol=0.25)


def test_it_is_exactly_as_large_as_one_asks(kind: Kind) -> None:
    wanted = (0.7, 0.9, 1.1)
    np.testing.assert_allclose(size_of(kind.make(7, wanted)), wanted, rtol=1e-4)


def test_it_is_cheap_to_draw(parts: Parts) -> None:
    assert sum(len(part.triangles) for part in parts) <= TRIANGLES_MAX
    assert distinct_textures(parts) <= TEXTURES_MAX


def test_its_normals_are_of_length_one(parts: Parts) -> None:
    for part in parts:
        np.testing.assert_allclose(np.linalg.norm(part.normals, axis=1), 1, atol=1e-3)


def test_its_label_is_one_that_networks_know_or_none(kind: Kind) -> None:
    assert kind.label == UNKNOWN or kind.label in IMAGENET
