# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The command line: one verb, one module of tools."""

from __future__ import annotations

import argparse
import logging
import sys
from typing import Sequence

from edgefusion import __version__
from edgefusion.errors import RefusedError

EXAMPLES = """examples:
  edgefusion demo
  edgefusion detect drive --model models/resnet18 --images
  edgefusion sim --links /tmp/sim
  edgefusion model add net.onnx --labels labels.txt --out models/net
  edgefusion run --config robot.toml
  edgefusion goto 5 5.5 15deg --inspect oscilloscope"""

CORE = "edgefusion._core"
"""A laptop sees and steers a robot without it."""


def build_parser() -> argparse.ArgumentParser:
    """The parser of all verbs; each verb's module registers its own options and loads what it needs when run."""
    from edgefusion.tools import (
        base,
        bus,
        config,
        demo,
        detect,
        doctor,
        evaluate,
        goto,
        keys,
        laser,
        model,
        record,
        recover,
        replay,
        resume,
        robot,
        run,
        sim,
        stop,
        teleop,
        topics,
        view,
        vision_verb,
        watch,
    )

    parser = argparse.ArgumentParser(
        prog="edgefusion",
        description="Names and distances of the objects in front of a robot, from a 2D laser and a camera.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"edgefusion {__version__}")
    verbs = parser.add_subparsers(title="verbs", metavar="VERB", required=True)
    for tool in (
        base,
        bus,
        config,
        demo,
        detect,
        doctor,
        evaluate,
        goto,
        keys,
        laser,
        model,
        record,
        recover,
        replay,
        resume,
        robot,
        run,
        sim,
        stop,
        teleop,
        topics,
        view,
        vision_verb,
        watch,
    ):
        tool.add_parser(verbs)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Runs a verb. Returns the exit code: 0 done, 1 failed while running, 2 refused input, 130 interrupted."""
    logging.basicConfig(level=logging.WARNING, format="edgefusion: %(levelname)s: %(message)s")
    try:
        return _run(argv)
    except RefusedError as error:
        return _say(error, 2)
    except ModuleNotFoundError as error:  # a laptop's installation
        if error.name != CORE:
            raise
        return _say("this verb needs the C++ core, which is not installed: `pip install .` in a clone compiles it", 2)
    except KeyboardInterrupt:
        return _say("interrupted", 130)
    except BrokenPipeError:  # whoever reads has seen enough, as with `| head`
        _drop_stdout()
        return 0
    except ConnectionError as error:  # nobody on the bus
        return _say(error, 1)
    except OSError as error:  # a full disk behind stdout: files are refused by name
        _drop_stdout()
        return _say(error, 1)
    except RuntimeError as error:  # a GPU that fails in mid-run
        return _say(error, 1)


def _run(argv: Sequence[str] | None) -> int:
    try:
        args = build_parser().parse_args(argv)
    except SystemExit:  # --help
        sys.stdout.flush()
        raise
    code: int = args.run(args)
    sys.stdout.flush()  # here, where what goes wrong has an exit code
    return code


def _say(what: object, code: int) -> int:
    print(f"edgefusion: {' '.join(str(what).split())}", file=sys.stderr)
    return code


def _drop_stdout() -> None:
    from edgefusion.tools.terminal import drop_stdout

    drop_stdout()


if __name__ == "__main__":
    sys.exit(main())
