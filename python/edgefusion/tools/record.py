# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion record`: what is on the bus, into an MCAP file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Sequence

from edgefusion.errors import RefusedError
from edgefusion.tools.arguments import whole_number
from edgefusion.tools.bus_options import add_bus, asked_endpoint

if TYPE_CHECKING:
    from edgefusion.bus.topics import Topic
    from edgefusion.recording.mcap_writer import McapWriter

EXAMPLES = """examples:
  edgefusion record drive.mcap
  edgefusion record drive.mcap --topic scan --topic image/compressed
  edgefusion record drive.mcap --connect tls/robot.local:7447 --keys edgefusion-keys/viewer

Ctrl-C or SIGTERM ends the recording. It is on the disk twice a second: a crash or a power cut costs a second at most
where the disk takes less than about 0.4 s for an fsync, else up to twice what that takes (`edgefusion recover` mends
the file). It ends by itself before the disk is full. A bus that goes away meanwhile does not end it.
FILE is of the format that Foxglove, Rerun and rosbag2 read.
Exit codes: 0 ended by a signal, 1 there is no bus, or the disk became full or failed, 2 refused input, also a FILE that
cannot be begun, as on a disk that is full already."""

MOST_RESERVE_MB = 10**9
"""A petabyte: more than any disk that is recorded to."""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "record",
        help="record what is on the bus",
        description="Records the topics of a robot's bus as MCAP with ROS 2's messages.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="to write, as drive.mcap")
    parser.add_argument("--overwrite", action="store_true", help="replace FILE")
    parser.add_argument("--topic", action="append", metavar="NAME", help="record only this one (again for more)")
    reserve = whole_number(0, MOST_RESERVE_MB)
    parser.add_argument("--reserve", type=reserve, default=500, metavar="MB", help="to leave free (default: 500)")
    add_bus(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Records until a signal comes or the disk is full. Raises RefusedError."""
    from edgefusion.recording.extras import require

    require("mcap", "record", "record")
    from edgefusion.bus.session import open_client
    from edgefusion.clock import system_clock
    from edgefusion.recording.recorder import Recorder
    from edgefusion.tools.record_loop import Tap, record

    topics, endpoint = _topics(args.topic), asked_endpoint(args)
    with open_client(endpoint.address, endpoint.keys, lease_s=endpoint.lease_s) as session:
        taps = [Tap(session, endpoint.robot, topic) for topic in topics]
        return record(args.file, Recorder(_writer(args), system_clock()), taps)


def _topics(names: Sequence[str] | None) -> list[Topic]:
    from edgefusion.bus.topics import TOPICS

    wanted = [name.lstrip("/") for name in names or TOPICS]  # ROS's names have a slash
    unknown = [name for name in wanted if name not in TOPICS]
    if unknown:
        raise RefusedError(f"--topic: expected some of {', '.join(TOPICS)}, got {unknown[0]}")
    return [topic for name, topic in TOPICS.items() if name in wanted]


def _writer(args: argparse.Namespace) -> McapWriter:
    from edgefusion.recording.mcap_writer import McapWriter
    from edgefusion.recording.record_file import RecordFile

    try:
        file = RecordFile.create(args.file, args.reserve * 1_000_000, args.overwrite)
        try:
            return McapWriter(file)
        except OSError:
            file.close()
            args.file.unlink()
            raise
    except FileExistsError:
        raise RefusedError(f"{args.file}: exists already; --overwrite replaces it") from None
    except OSError as error:
        raise RefusedError(f"{args.file}: cannot write there: {error.strerror or error}") from error
