# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The configuration as files: as one to begin with, as the page that describes it, and as what is in effect."""

from __future__ import annotations

import textwrap
from typing import Callable, Iterator, List, Sequence

from edgefusion.config.documentation import Key, Section
from edgefusion.config.words import toml_value

_WIDTH = 100
_HEAD = "edgefusion's configuration, with every key at its default. A key that is left out has its default, too."
_PAGE = """# Configuration

One TOML file for all processes: `edgefusion run --config robot.toml`. This page is made by `edgefusion config
reference` from the structures that read the file, and so is the file to begin with:

```sh
edgefusion config init robot.toml     # every key with its default and what it means
edgefusion config check robot.toml    # all that is wrong, each with its line; exit code 2
edgefusion config show robot.toml     # what is in effect, and where each value comes from
edgefusion doctor --config robot.toml # whether the robot is as the file says
```

An unknown key, a value of another type or out of its range, and keys that cannot be together are refused with file,
line and reason. A key that is left out has its default; files are relative to the folder of the configuration.
"""


def template(sections: Sequence[Section]) -> str:
    """A TOML file of every key with its default, and what is said of it."""
    lines = _comment(_HEAD)
    for section in sections:
        lines += ["", f"[{'.'.join(section.path)}]", *_comment(section.text)] if section.path else []
        for key in section.keys:
            lines += ["", *_comment(key.text), *_comment(_takes(key)), _assignment(key, key.default)]
    return "\n".join(lines) + "\n"


def page(sections: Sequence[Section]) -> str:
    """The reference, in Markdown."""
    return "\n".join([_PAGE, *(line for section in sections for line in _table(section))])


def effective(sections: Sequence[Section], value_of: Callable[[Key], object], source_of: Callable[[Key], str]) -> str:
    """A TOML file of every value that is in effect, each with where it comes from."""
    blocks = []
    for section in sections:
        settings = [_assignment(key, value_of(key)) for key in section.keys]
        width = min(max(map(len, settings), default=0), _WIDTH)
        head = [f"[{'.'.join(section.path)}]"] if section.path else []
        lines = [f"{text:{width}}  # {source_of(key)}" for text, key in zip(settings, section.keys)]
        blocks.append("\n".join([*head, *lines]))
    return "\n\n".join(blocks) + "\n"


def _comment(text: str) -> List[str]:
    return textwrap.wrap(text, _WIDTH, initial_indent="# ", subsequent_indent="# ", break_on_hyphens=False)


def _takes(key: Key) -> str:
    left_out = "; may be left out" if key.default is None else ""
    return f"{key.takes[:1].upper()}{key.takes[1:]}{left_out}."


def _assignment(key: Key, value: object) -> str:
    """What has no value is a comment: TOML has no word for none."""
    return f"#{key.path[-1]} =" if value is None else f"{key.path[-1]} = {toml_value(value)}"


def _table(section: Section) -> Iterator[str]:
    if section.path:
        yield f"## `[{'.'.join(section.path)}]`\n"
        yield section.text + "\n"
    yield "| key | default | takes | |"
    yield "|---|---|---|---|"
    for key in section.keys:
        default = "" if key.default is None else f"`{toml_value(_rounded(key.default))}`"
        yield f"| `{key.path[-1]}` | {default} | {key.takes} | {_cell(key.text)} |"
    yield ""


def _rounded(value: object) -> object:
    """For the eye: angles in radians have no short form."""
    return float(f"{value:.4g}") if isinstance(value, float) else value


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;")
