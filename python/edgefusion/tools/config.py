# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion config`: a file to begin with, what is wrong with one, and what is in effect."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Dict

from edgefusion.errors import RefusedError

if TYPE_CHECKING:
    from edgefusion.config import Config
    from edgefusion.config.documentation import Key
    from edgefusion.config.load import Loaded

EXAMPLES = """examples:
  edgefusion config init robot.toml
  edgefusion config check robot.toml
  edgefusion config show robot.toml --json

Exit codes: 0 done, 2 refused, as a configuration in which something is wrong."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "config",
        help="make, check and show a configuration",
        description="The one TOML file that all processes on the robot read.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    verbs = parser.add_subparsers(title="verbs", metavar="VERB", required=True)
    init = _verb(verbs, "init", run_init, "write a file with every key, its default and what it means")
    init.add_argument("file", type=Path, nargs="?", default=Path("robot.toml"), help="default: robot.toml; -: print it")
    check = _verb(verbs, "check", run_check, "say all that is wrong, each with its line")
    check.add_argument("file", type=Path, help="TOML")
    show = _verb(verbs, "show", run_show, "print what is in effect, and where each value comes from")
    show.add_argument("file", type=Path, nargs="?", help="TOML (default: the defaults)")
    show.add_argument("--json", action="store_true", help="as JSON")
    _verb(verbs, "reference", run_reference, "print the page that describes every key, as Markdown")


def _verb(
    verbs: argparse._SubParsersAction[argparse.ArgumentParser],
    name: str,
    run: Callable[[argparse.Namespace], int],
    text: str,
) -> argparse.ArgumentParser:
    parser = verbs.add_parser(name, help=text, description=f"{text[0].upper()}{text[1:]}.")
    parser.set_defaults(run=run)
    return parser


def run_init(args: argparse.Namespace) -> int:
    """Raises RefusedError where the file is there already."""
    from edgefusion.config import Config
    from edgefusion.config.documentation import sections
    from edgefusion.tools.config_template import template

    text = template(sections(Config))
    if str(args.file) == "-":
        print(text, end="")
        return 0
    try:
        with args.file.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise RefusedError(f"{args.file}: expected no file there, got one, which is left as it is") from error
    except OSError as error:
        raise RefusedError(f"{args.file}: cannot be written: {error.strerror}") from error
    print(f"{args.file}: every key with its default; ports, [vision] and [base] are yours to set")
    return 0


def run_check(args: argparse.Namespace) -> int:
    """2 where anything is wrong, which it prints line by line. Raises RefusedError where it is no TOML."""
    from edgefusion.config import Config
    from edgefusion.config.load import ConfigError, load

    try:
        loaded = load(args.file, Config)
    except ConfigError as error:
        print("\n".join(error.complaints))
        return 2
    count = len(_given(loaded))
    print(f"{args.file}: nothing is wrong; {'1 key is' if count == 1 else f'{count} keys are'} set")
    return 0


def run_show(args: argparse.Namespace) -> int:
    """Raises RefusedError for a configuration in which anything is wrong."""
    import json

    from edgefusion.config import Config
    from edgefusion.config.documentation import sections
    from edgefusion.config.load import Loaded, load
    from edgefusion.tools.config_template import effective

    loaded = Loaded(Config(), {}) if args.file is None else load(args.file, Config)
    known = sections(Config)
    if args.json:
        keys = [key for section in known for key in section.keys]
        print(json.dumps({".".join(key.path): _as_json(key, loaded, args.file) for key in keys}, indent=2))
    else:
        print(effective(known, lambda key: _value(key, loaded), lambda key: _source(key, loaded, args.file)), end="")
    return 0


def run_reference(args: argparse.Namespace) -> int:
    """Prints docs/configuration.md."""
    from edgefusion.config import Config
    from edgefusion.config.documentation import sections
    from edgefusion.tools.config_template import page

    print(page(sections(Config)), end="")
    return 0


def _given(loaded: Loaded[Config]) -> Dict[str, int]:
    """The keys that the file sets, and where."""
    from edgefusion.config import Config
    from edgefusion.config.documentation import sections

    keys = [key.path for section in sections(Config) for key in section.keys]
    return {".".join(path): loaded.lines[path] for path in keys if path in loaded.lines}


def _value(key: Key, loaded: Loaded[Config]) -> Any:
    """As it may be shown: without the name and password that a URL may hold."""
    import re

    import msgspec

    value: Any = loaded.config
    for name in key.path:
        value = getattr(value, name)
    value = msgspec.to_builtins(value)
    return re.sub(r"//[^/@]*@", "//***@", value) if isinstance(value, str) else value


def _source(key: Key, loaded: Loaded[Config], path: Path | None) -> str:
    return f"{path}:{loaded.lines[key.path]}" if key.path in loaded.lines else "default"


def _as_json(key: Key, loaded: Loaded[Config], path: Path | None) -> Dict[str, Any]:
    line = loaded.lines.get(key.path)
    source = "default" if line is None else str(path)
    return {"value": _value(key, loaded), "unit": key.unit or None, "from": source, "line": line}
