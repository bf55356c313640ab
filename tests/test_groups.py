# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Label groups: the shipped file against ImageNet's labels, what a user may ask for, and what is refused."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.errors import RefusedError
from edgefusion.perception.groups import LabelGroups

AMBIGUOUS = {"crane", "maillot"}  # each the name of two classes
ASKED_FOR = [
    "car", "truck", "bus", "bicycle", "motorcycle", "lamp", "chair", "sofa", "table", "screen", "computer",
    "keyboard", "printer", "telephone", "bottle", "cup", "bag", "box", "door", "appliance", "heater", "speaker",
    "camera", "clock", "plant", "dog", "cat", "bird", "train", "boat", "traffic sign", "bookshelf", "bed", "fan",
    "measuring instrument", "controller", "ball", "musical instrument",
]  # fmt: skip
SMALL = LabelGroups({"car": ["cab", "jeep"], "screen": ["monitor", "screen"]})
MODEL = ["cab", "umbrella", "monitor", "screen", "studio couch"]


@pytest.fixture(scope="module")
def shipped() -> LabelGroups:
    return LabelGroups.load()


@pytest.fixture(scope="module")
def imagenet(shared_data) -> list[str]:
    path = shared_data / "models" / "imagenet_classes.txt"
    if not path.is_file():
        pytest.skip("imagenet_classes.txt is not on this machine")
    return path.read_text(encoding="utf-8").splitlines()


def test_every_shipped_label_is_exactly_one_class_of_imagenet(shipped, imagenet) -> None:
    for group in shipped:
        for label in shipped.labels_of(group):
            assert imagenet.count(label) == 1, f"{group}: {label}"


def test_no_shipped_group_is_named_like_a_class_it_does_not_hold(shipped, imagenet) -> None:
    for group in set(shipped) & set(imagenet):
        assert group in shipped.labels_of(group)


def test_ambiguous_names_are_in_no_group(shipped) -> None:
    assert {shipped.group_of(label) for label in AMBIGUOUS} == {""}


def test_what_a_user_of_a_robot_asks_for_is_there(shipped) -> None:
    assert set(ASKED_FOR) <= set(shipped)


def test_cats_dogs_and_birds_are_those_of_imagenet_and_no_wolf_or_crane(shipped, imagenet) -> None:
    assert set(shipped.labels_of("dog")) == set(imagenet[151:269])
    assert set(shipped.labels_of("cat")) == set(imagenet[281:286])
    birds = imagenet[7:25] + imagenet[80:101] + imagenet[127:147]
    assert set(shipped.labels_of("bird")) == set(birds) - AMBIGUOUS


def test_a_car_is_what_imagenet_calls_it(shipped) -> None:
    assert {"sports car", "minivan", "beach wagon", "convertible", "limousine"} <= set(shipped.labels_of("car"))
    assert shipped.group_of("sports car") == "car"
    assert shipped.group_of("traffic light") == ""


@given(st.data())
def test_every_label_of_a_group_leads_back_to_it(shipped, data) -> None:
    group = data.draw(st.sampled_from(list(shipped)))
    assert {shipped.group_of(label) for label in shipped.labels_of(group)} == {group}


def test_labels_that_the_model_lacks_are_left_out() -> None:
    assert SMALL.labels_of("car") == ("cab", "jeep")
    assert SMALL.labels_of("car", MODEL) == ("cab",)


def test_a_plain_label_of_the_model_is_its_own_name() -> None:
    assert SMALL.labels_of("umbrella", MODEL) == ("umbrella",)
    assert SMALL.labels_of("cab") == ("cab",)


def test_a_name_of_both_a_group_and_a_label_means_the_group() -> None:
    assert SMALL.labels_of("screen", MODEL) == ("monitor", "screen")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("umbrela", "'umbrela': no label or group of the model; did you mean umbrella?"),
        ("Cab", "'Cab': no label or group of the model; did you mean cab, car?"),
        ("couch", "'couch': no label or group of the model; did you mean studio couch?"),
        ("cat", "'cat': no label or group of the model; did you mean car, cab?"),
        ("jeep", "'jeep': no label or group of the model"),  # in the file, not in the model
        ("qqqqqq", "'qqqqqq': no label or group of the model"),
        ("", "'': no label or group of the model"),
    ],
)
def test_an_unknown_name_is_refused_with_the_closest_ones(name: str, message: str) -> None:
    with pytest.raises(RefusedError) as refused:
        SMALL.labels_of(name, MODEL)
    assert str(refused.value) == message


def test_a_group_of_which_the_model_has_nothing_is_refused_and_not_suggested() -> None:
    with pytest.raises(RefusedError, match=r"^'car': no label or group of the model$"):
        SMALL.labels_of("car", ["umbrella"])


GOOD = 'version = 1\n[groups]\ncar = ["cab", "jeep"]\n'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (GOOD + 'taxi = ["cab"]', "group 'taxi': 'cab' is already in the group 'car'"),
        (GOOD + 'taxi = ["van", "van"]', "group 'taxi': 'van' is already in the group 'taxi'"),
        (GOOD + 'cab = ["van"]', "group 'cab': is also a label of the group 'car'"),
        (GOOD + "taxi = []", "group 'taxi': expected a name and at least one label"),
        (GOOD + 'taxi = [""]', "group 'taxi': expected a name and at least one label"),
        (GOOD + '"" = ["van"]', "group '': expected a name and at least one label"),
        (GOOD + 'taxi = "van"', "array"),
        (GOOD + "taxi = [1]", "str"),
        (GOOD + 'car = ["van"]', "not TOML"),
        ("[groups]\n", "version"),
        ("version = 2\n[groups]\n", "2"),
        ("version = 1\n", "groups"),
        ("version = 1\nextra = 1\n[groups]\n", "extra"),
        ("version =", "not TOML"),
    ],
)
def test_a_bad_file_is_refused_with_one_line_that_names_it(tmp_path, text: str, message: str) -> None:
    path = tmp_path / "groups.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(RefusedError) as refused:
        LabelGroups.load(path)
    assert str(refused.value).startswith(f"{path}: ")
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_users_own_file_is_used_instead(tmp_path) -> None:
    path = tmp_path / "groups.toml"
    path.write_text(GOOD, encoding="utf-8")
    assert list(LabelGroups.load(path)) == ["car"]


def test_a_missing_file_is_refused(tmp_path) -> None:
    with pytest.raises(RefusedError, match="cannot be read"):
        LabelGroups.load(tmp_path / "none.toml")
