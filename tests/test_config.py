# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""The configuration is strict: what it does not know or cannot be is refused with the file and the key."""

from __future__ import annotations

from pathlib import Path

import pytest

from edgefusion.config import (
    BaseConfig,
    Config,
    KhatibConfig,
    MissionConfig,
    NavigationConfig,
    PerceptionConfig,
    SafetyConfig,
    load_config,
)
from edgefusion.errors import RefusedError


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def test_no_file_means_the_defaults() -> None:
    assert load_config(None) == Config()


def test_a_file_changes_only_what_it_names(tmp_path: Path) -> None:
    config = load_config(write(tmp_path / "c.toml", "version = 1\n[perception]\neps_m = 0.2\nheights = [1.0, 2]\n"))
    assert config.perception.eps_m == 0.2
    assert config.perception.heights == (1.0, 2.0)
    assert config.perception.min_points == Config().perception.min_points


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[perception]\nepsilon = 1\n", "2: perception.epsilon: unknown key"),
        ("[perception]\nmin_point = 1\n", "unknown key, did you mean min_points?"),
        ("\n\nversion = 1\npercept = 1\n", "4: percept: unknown key, did you mean perception?"),
        ("perception = 1\n", "1: perception: expected a table, got 1"),
        ("[perception]\neps_m = 'wide'\n", '2: perception.eps_m: expected a number above 0, at most 10, got "wide"'),
        ("[perception]\neps_m = 0\n", "perception.eps_m: expected a number above 0, at most 10, got 0"),
        ("[perception]\nheights = []\n", "perception.heights: expected a list of 1 to 16 numbers above 0, at most 100"),
        ("[perception]\nfeatures = 'xyz'\n", 'perception.features: expected "xy" or "yr", got "xyz"'),
        ("[perception]\nmin_score = 1.5\n", "perception.min_score: expected a number from 0 to 1, got 1.5"),
        ("[perception]\neps_m = nan\n", "perception.eps_m: "),
        ("[perception]\neps_m = inf\n", "perception.eps_m: "),
        ("[perception]\nmin_points = 3000000000\n", "perception.min_points: expected a whole number from 1 to 1000"),
        ("[perception]\nmin_points = 2.5\n", "perception.min_points: expected a whole number"),
        ("[perception]\nmax_object_width_m = inf\n", "perception.max_object_width_m: "),
        ("[perception]\nobjects = 101\n", "perception.objects: "),
        ("[perception]\nwidth_step = inf\n", "perception.width_step: "),
        ("[perception]\nheights = [inf]\n", "perception.heights: "),
        (f"[perception]\nheights = {[1.0] * 17}\n", "perception.heights: expected a list of 1 to 16 "),
        ("[perception]\nrange_sigma_m = inf\n", "perception.range_sigma_m: "),
        ("[perception]\neps_m = 2020-01-01\n", "perception.eps_m: .*got a date"),
        (f"[perception]\neps_m = 1{'0' * 400}\n", "robot.toml:2: perception.eps_m: "),
        ("[sync]\ntolerance_s = inf\n", "sync.tolerance_s: "),
        ("[sync]\nhorizon_s = 1e300\n", "sync.horizon_s: "),
        ("[sync]\n\ntolerance_s = 2.0\n", "3: sync: tolerance_s: expected at most horizon_s, 1, got 2"),
        ("[navigation]\n\nmargin_m = 0.5\n", "3: navigation: comfort_m: expected more than margin_m, 0.5, got 0.5"),
        ("[robot]\nport = '/dev/laser'\n", "2: laser.port: expected another one than robot.port, got /dev/laser"),
        (
            "[laser]\nbeams = 361\n[safety]\nmax_scan_age_s = 0.2\n",
            "4: safety.max_scan_age_s: expected at least 0.38",
        ),
        (
            "[safety]\ncycle_s = 0.3\nmax_cycle_s = 0.5\n",
            "2: bus.cmd_vel_timeout_s: expected at least safety.cycle_s, 0.3",
        ),
        ("[service]\nbase_silence_s = 0.1\n", "2: service.base_silence_s: expected more than safety.max_cycle_s, 0.2"),
        ("[camera]\nrate_hz = 30\nexposure_s = 0.1\n", "3: camera: exposure_s: expected at most 1 / rate_hz, "),
        (
            "[service]\ndrive_without_vision = false\n",
            "2: vision.model: expected one where service.drive_",
        ),
        (
            "[service]\nprocesses = ['vision']\n",
            "2: vision.model: expected one where service.processes ",
        ),
        (
            "[vision]\nmodel = 'net'\ncalibration = 'c.toml'\n[safety]\noptional = ['camera']\n",
            "5: safety.optional: expected vision among them where service.drive_without_vision is true, got camera",
        ),
        (
            "[bus]\nrequire_operator = true\nmax_command_hz = 5\n",
            "3: bus.max_command_hz: expected at least 10 where bus.require_operator is true",
        ),
        (
            "[bus]\nrequire_operator = true\noperator_timeout_s = 0.1\n",
            "3: bus.operator_timeout_s: expected at least 0.2 where",
        ),
        ("[bus]\nstate_hz = 0.2\n", "2: bus.state_hz: expected"),
        ("[vision]\nmodel = 'net'\n", "2: vision: model, calibration: expected both or neither, "),
        ("[vision]\nrequire_provider = true\n", "2: vision: require_provider: expected a provider beside it"),
        ('[bus]\nrobot = "a\\n"\n', r'2: bus.robot: expected no control characters, got "a\\n"'),
        ("[mission]\ninterest = ['a\tb']\n", "2: mission.interest: expected no control characters, got "),
        ('"\\u001b[31ma\\n" = 1\n', r'1: "\\u001b\[31ma\\n": unknown key'),
        (f"{'k' * 5000} = 1\n", '1: "k{59} ...: unknown key'),
        ("[robot]\nport = ''\n", '2: robot.port: expected text of 1 to 1024 characters, got ""'),
        (
            "[bus]\nmax_command_bytes = 4096.0\n",
            "2: bus.max_command_bytes: expected a whole number from 256 to 1000000,",
        ),
        pytest.param(
            f"{'.'.join('a' * 5000)} = 1", "tables within tables without end|more than the allowed", id="dotted deeply"
        ),
        pytest.param(f"a = {'[' * 100000}", "not TOML", id="nested deeply"),
        ("version = 2\n", "1: version: expected 1, got 2"),
        ("[perception\n", "not TOML: .*line 1"),
    ],
)
def test_a_bad_file_is_refused_in_one_line_with_its_name(tmp_path: Path, text: str, expected: str) -> None:
    path = write(tmp_path / "robot.toml", text)
    with pytest.raises(RefusedError, match=expected) as refused:
        load_config(path)
    assert str(refused.value).startswith(f"{path}:")
    assert "\n" not in str(refused.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(RefusedError, match=r"none.toml: cannot be read: No such file"):
        load_config(tmp_path / "none.toml")


@pytest.mark.parametrize("bad", [{"eps_m": -1.0}, {"heights": ()}, {"features": "xyz"}, {"min_points": 2.5}])
def test_settings_built_in_python_are_checked_as_strictly(bad) -> None:
    (name,) = bad
    with pytest.raises(RefusedError, match=f"{name}: "):
        PerceptionConfig(**bad)


def test_the_documented_settings_of_navigation_are_all_there_are_and_the_defaults(tmp_path: Path) -> None:
    document = (Path(__file__).parents[1] / "docs/navigation.md").read_text(encoding="utf-8")
    settings = document.partition("```toml")[2].partition("```")[0]
    assert load_config(write(tmp_path / "c.toml", settings)) == Config()
    for section in (BaseConfig, KhatibConfig, NavigationConfig, MissionConfig, SafetyConfig):
        for name in section.__struct_fields__:
            assert any(f"\n{mark}{name} = " in settings for mark in ("", "#")) or f".{name}]" in settings, (
                f"{section.__name__}.{name}"
            )
