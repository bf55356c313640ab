# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The page on the bus says what there is, and what it shows is accepted as it is."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Dict

import pytest

from edgefusion.bus.key_files import ROLES
from edgefusion.bus.requests import GotoRequest, InspectRequest, ResumeRequest, StopRequest, read_json
from edgefusion.bus.tags import CommandTag, SampleTag, read_tag
from edgefusion.bus.topics import GOTO, INSPECT, QUERIES, RESUME, STOP, TOPICS
from edgefusion.config import BusConfig
from edgefusion.messages import ros_name

PAGE = (Path(__file__).parents[1] / "docs/bus.md").read_text(encoding="utf-8")
KINDS: Dict[str, Any] = {GOTO: GotoRequest, STOP: StopRequest, RESUME: ResumeRequest, INSPECT: InspectRequest}


def rows() -> Dict[str, str]:
    """By key, the rest of its line."""
    found = {}
    for line in PAGE.splitlines():
        if line.startswith("| `"):
            keys, rest = line[2:].split(" | ", 1)
            found.update({key: rest for key in re.findall(r"`([^`]+)`", keys)})
    return found


@pytest.mark.parametrize("name", TOPICS)
def test_every_topic_is_there_with_its_type(name: str) -> None:
    assert ros_name(TOPICS[name].message).replace("/msg/", "/") in rows()[name]


def test_nothing_else_is() -> None:
    assert set(rows()) == {*TOPICS, *QUERIES}


@pytest.mark.parametrize("name", QUERIES)
def test_every_query_as_it_is_shown_is_one(name: str) -> None:
    (shown,) = re.findall(r"`(\{.*?\})`(?:$|;| \|)", rows()[name])
    assert isinstance(read_json(KINDS[name], shown.encode()), KINDS[name])


def test_the_attachments_as_they_are_shown_are_some() -> None:
    (command,) = re.findall(r"```json\n(.*?)```", PAGE, re.DOTALL)
    assert read_tag(CommandTag, command.encode()).ttl_ms == 200
    (sample,) = re.findall(r'`(\{"clock".*?\})`', PAGE, re.DOTALL)
    assert read_tag(SampleTag, sample.encode()).seq == 7


def test_settings_and_roles_are_those_that_there_are() -> None:
    settings = {name for name in re.findall(r"`([a-z]+(?:_[a-z]+)+)`", PAGE)} - {"ttl_ms", "camera_info", "cmd_vel"}
    others = {"tf_static", "goal_pose", "camera_optical", "base_link", "position_tolerance_m", "heading_tolerance"}
    assert settings - others <= set(BusConfig.__struct_fields__)
    assert all(f"| {role} | " in PAGE for role in ROLES)
    (listen,) = re.findall(r"listen = \[(.*)\]", PAGE)
    assert BusConfig(listen=tuple(re.findall(r'"([^"]+)"', listen)), keys="keys").listen
