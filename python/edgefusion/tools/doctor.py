# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion doctor`: whether the robot is as its configuration says, and what to do where it is not."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Callable, Dict, Iterator, List, Sequence

if TYPE_CHECKING:
    from edgefusion.tools.doctor_finding import Examination, Finding

EXAMPLES = """examples:
  edgefusion doctor --config robot.toml
  edgefusion doctor --config robot.toml --only ports --only laser
  edgefusion doctor --config robot.toml --json

The robot is never moved: it is told to stop, and its motors are not enabled (those that are on are switched off at the
end, as at every end). The service must not run meanwhile: it holds the ports.
Exit codes: 0 all well, perhaps with warnings; 2 the configuration is refused; 130 interrupted; else the first check
that failed: 10 ports, 11 robot, 12 laser, 13 camera, 14 model, 15 calibration, 16 bus, 17 clock, 18 disk,
19 permissions."""


INTERRUPTED = 130


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Registers the verb."""
    parser = subparsers.add_parser(
        "doctor",
        help="say what is wrong with the robot, and what to do",
        description="Checks ports, robot, laser, camera, model, calibration, bus, clock, disk and permissions.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--config", type=Path, required=True, metavar="FILE", help="TOML; `edgefusion config init` makes one")
    add("--only", action="append", default=[], metavar="CHECK", help="only this one; may be given again")
    add("--json", action="store_true", help="all findings as JSON")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """One line for each finding, as it is found. Raises RefusedError."""
    from edgefusion.config import load_config
    from edgefusion.errors import RefusedError
    from edgefusion.service.signals import ended_by_signals
    from edgefusion.tools.doctor_finding import CHECKS, Examination, exit_code

    unknown = [name for name in args.only if name not in CHECKS]
    if unknown:
        raise RefusedError(f"--only: expected {', '.join(CHECKS)}, got {', '.join(unknown)}")
    exam = Examination(load_config(args.config), args.config)
    findings: List[Finding] = []
    with ended_by_signals(INTERRUPTED):
        for finding in examine(exam, args.only or CHECKS):
            findings.append(finding)
            if not args.json:
                print(_in_words(finding), flush=True)
    code = exit_code(findings)
    if args.json:
        _print_json(findings, code)
    return code


def examine(exam: Examination, checks: Sequence[str]) -> Iterator[Finding]:
    """What is found, check by check, in the order of CHECKS; one that cannot be made does not end the others."""
    from edgefusion.tools.doctor_finding import CHECKS, Finding, State

    known = known_checks()
    for name in CHECKS:
        if name not in checks:
            continue
        try:
            yield from known[name](exam)
        except (OSError, RuntimeError, ValueError, LookupError) as error:
            text = " ".join((str(error) or type(error).__name__).split())
            yield Finding(name, State.FAILED, f"it could not be looked at: {text}", "mend what is named, and try again")


def known_checks() -> Dict[str, Callable[[Examination], Iterator[Finding]]]:
    """By name."""
    from edgefusion.tools.doctor_bus import check_bus
    from edgefusion.tools.doctor_camera import check_camera
    from edgefusion.tools.doctor_laser import check_laser
    from edgefusion.tools.doctor_machine import check_clock, check_disk, check_permissions
    from edgefusion.tools.doctor_ports import check_ports
    from edgefusion.tools.doctor_robot import check_robot
    from edgefusion.tools.doctor_vision import check_calibration, check_model

    return {
        "ports": check_ports,
        "robot": check_robot,
        "laser": check_laser,
        "camera": check_camera,
        "model": check_model,
        "calibration": check_calibration,
        "bus": check_bus,
        "clock": check_clock,
        "disk": check_disk,
        "permissions": check_permissions,
    }


def _in_words(finding: Finding) -> str:
    line = f"{finding.state.value:8} {finding.check:12} {finding.text}"
    return f"{line}\n{'':8} {'':12} -> {finding.cure}" if finding.cure else line


def _print_json(findings: Sequence[Finding], code: int) -> None:
    import json

    told = [
        {"check": each.check, "state": each.state.value, "text": each.text, "cure": each.cure or None}
        for each in findings
    ]
    print(json.dumps({"exit_code": code, "findings": told}, indent=2))
