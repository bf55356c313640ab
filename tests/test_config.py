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
        ("[perception]\nepsilon = 1\n", "unknown field `epsilon`"),
        ("[perception]\neps_m = 'wide'\n", r"Expected `float`, got `str` - at `\$.perception.eps_m`"),
        ("[perception]\neps_m = 0\n", r"Expected `float` > 0.0 - at `\$.perception.eps_m`"),
        ("[perception]\nheights = []\n", r"length >= 1 - at `\$.perception.heights`"),
        ("[perception]\nfeatures = 'xyz'\n", r"Invalid enum value 'xyz' - at `\$.perception.features`"),
        ("[perception]\nmin_score = 1.5\n", r"at `\$.perception.min_score`"),
        ("[perception]\neps_m = nan\n", r"at `\$.perception.eps_m`"),
        ("[perception]\neps_m = inf\n", r"Expected `float` <= 10.0 - at `\$.perception.eps_m`"),
        ("[perception]\nmin_points = 3000000000\n", r"Expected `int` <= 1000 - at `\$.perception.min_points`"),
        ("[perception]\nmax_object_width_m = inf\n", r"at `\$.perception.max_object_width_m`"),
        ("[perception]\nobjects = 101\n", r"at `\$.perception.objects`"),
        ("[perception]\nwidth_step = inf\n", r"at `\$.perception.width_step`"),
        ("[perception]\nheights = [inf]\n", r"at `\$.perception.heights"),
        (f"[perception]\nheights = {[1.0] * 17}\n", r"length <= 16 - at `\$.perception.heights`"),
        ("[perception]\nrange_sigma_m = inf\n", r"at `\$.perception.range_sigma_m`"),
        (f"[perception]\neps_m = 1{'0' * 400}\n", r"robot.toml: "),
        ("[sync]\ntolerance_s = inf\n", r"at `\$.sync.tolerance_s`"),
        ("[sync]\nhorizon_s = 1e300\n", r"at `\$.sync.horizon_s`"),
        ("[sync]\ntolerance_s = 2.0\n", r"tolerance_s: expected at most horizon_s, 1, got 2"),
        pytest.param(f"a = {'[' * 100000}", "not TOML", id="nested deeply"),
        ("version = 2\n", r"version"),
        ("[perception\n", "not TOML: .*line 1"),
    ],
)
def test_a_bad_file_is_refused_in_one_line_with_its_name(tmp_path: Path, text: str, expected: str) -> None:
    path = write(tmp_path / "robot.toml", text)
    with pytest.raises(RefusedError, match=expected) as refused:
        load_config(path)
    assert str(refused.value).startswith(f"{path}: ")
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
            assert f"\n{name} = " in settings or f".{name}]" in settings, f"{section.__name__}.{name}"
