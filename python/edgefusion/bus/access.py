# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""Who may do what on the bus, as Zenoh's access control: denied is what is not said here.

Viewers read everything of the robot. Operators also command. The robot's own processes may do anything of the robot's;
so may whoever is on its computer, by loopback without TLS.
"""

from __future__ import annotations

from typing import Any, Sequence

from edgefusion.bus.key_files import ROLES
from edgefusion.bus.topics import COMMANDS, QUERIES, key_of

_EVERYTHING = (
    "put", "delete", "declare_subscriber", "query", "declare_queryable", "reply", "liveliness_token",
    "liveliness_query", "declare_liveliness_subscriber",
)  # fmt: skip
_IN, _OUT, _BOTH = ("ingress",), ("egress",), ("ingress", "egress")  # as seen from the router


def access_control(robot: str) -> dict[str, Any]:
    """Zenoh's setting `access_control` for the router of this robot."""
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": _rules(robot),
        "subjects": [
            {"id": "local", "interfaces": ["lo"], "link_protocols": ["tcp"]},
            *({"id": role, "cert_common_names": [role]} for role in ROLES),
        ],
        "policies": [
            {"subjects": ["local", "robot"], "rules": ["everything"]},
            {"subjects": ["viewer", "operator"], "rules": ["subscribe", "receive"]},
            {"subjects": ["operator"], "rules": ["command", "see-command", "ask", "answer"]},
        ],
    }


def _rules(robot: str) -> list[dict[str, Any]]:
    every_key = [key_of(robot, "**")]
    commands = [key_of(robot, topic.name) for topic in COMMANDS]
    queries = [key_of(robot, name) for name in QUERIES]
    return [
        _rule("everything", _EVERYTHING, _BOTH, every_key),
        _rule("subscribe", ("declare_subscriber", "declare_liveliness_subscriber", "liveliness_query"), _IN, every_key),
        _rule("receive", ("put", "delete", "liveliness_token"), _OUT, every_key),
        _rule("command", ("put",), _IN, commands),
        _rule("see-command", ("declare_subscriber",), _OUT, commands),
        _rule("ask", ("query",), _IN, queries),
        _rule("answer", ("reply", "declare_queryable"), _OUT, queries),
    ]


def _rule(name: str, messages: Sequence[str], flows: Sequence[str], keys: Sequence[str]) -> dict[str, Any]:
    return {
        "id": name,
        "permission": "allow",
        "messages": list(messages),
        "flows": list(flows),
        "key_exprs": list(keys),
    }
