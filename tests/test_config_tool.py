# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion config`: what it writes loads back, what it says is true, and its page is up to date."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from edgefusion.cli import main
from edgefusion.config import Config, load_config, read_toml, toml_lines
from edgefusion.config.documentation import Key, sections
from edgefusion.config.strict import parse_toml
from edgefusion.config.toml_lines import key_lines
from edgefusion.config.words import toml_value

DOCS = Path(__file__).parents[1] / "docs"
KEYS = [key for section in sections(Config) for key in section.keys]


def ids(key: Key) -> str:
    return ".".join(key.path)


@pytest.mark.parametrize("key", KEYS, ids=ids)
def test_every_key_is_documented_and_every_number_has_a_unit(key: Key) -> None:
    assert key.text.endswith((".", ")"))
    if "number" in key.kind and "or text" not in key.kind:
        assert key.unit


@pytest.mark.parametrize("section", sections(Config), ids=lambda section: ".".join(section.path))
def test_every_section_is_described(section: Any) -> None:
    assert section.text.endswith(".")
    assert section.keys


def test_the_reference_is_up_to_date(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["config", "reference"]) == 0
    assert capsys.readouterr().out == (DOCS / "configuration.md").read_text(encoding="utf-8"), (
        "edgefusion config reference > docs/configuration.md"
    )


def test_the_file_to_begin_with_has_every_key_and_loads_back_to_the_defaults(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    assert main(["config", "init", str(path)]) == 0
    assert load_config(path) == Config()
    text = path.read_text(encoding="utf-8")
    for key in KEYS:
        assert re.search(rf"^#?{key.path[-1]} =", text, re.MULTILINE), key.path
        assert (key.path in key_lines(text)) == (key.default is not None)


def test_a_key_of_that_file_that_is_left_out_takes_a_value_where_it_stands(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    main(["config", "init", str(path)])
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("#width =", "width = 640").replace("#height =", "height = 480"), encoding="utf-8")
    assert load_config(path).camera.width == 640


def test_a_file_that_is_there_is_left_as_it_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("# mine\n", encoding="utf-8")
    assert main(["config", "init", str(path)]) == 2
    assert "expected no file there" in capsys.readouterr().err
    assert path.read_text(encoding="utf-8") == "# mine\n"


def test_a_file_that_cannot_be_written_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["config", "init", str(tmp_path / "none" / "robot.toml")]) == 2
    assert "cannot be written: No such file" in capsys.readouterr().err


def test_check_says_all_that_is_wrong_with_its_lines_in_order(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("[sync]\ntolerance_s = 2.0\n\n[laser]\nbeams = 7\n[perception]\n# one\nepsilon = 0.2\n", "utf-8")
    assert main(["config", "check", str(path)]) == 2
    assert capsys.readouterr().out.splitlines() == [
        f"{path}:2: sync: tolerance_s: expected at most horizon_s, 1, got 2",
        f"{path}:5: laser.beams: expected 101, 181, 201, 361 or 401, got 7",
        f"{path}:8: perception.epsilon: unknown key",
    ]


def test_check_is_content_with_a_good_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("[laser]\nbeams = 181\nport = '/dev/ttyUSB7'\n", "utf-8")
    assert main(["config", "check", str(path)]) == 0
    assert capsys.readouterr().out == f"{path}: nothing is wrong; 2 keys are set\n"
    path.write_text("[laser]\nbeams = 181\n", "utf-8")
    assert main(["config", "check", str(path)]) == 0
    assert capsys.readouterr().out == f"{path}: nothing is wrong; 1 key is set\n"


def test_a_verb_that_reads_a_bad_file_says_the_first_complaint_and_how_many_more(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("[laser]\nbeams = 7\nbaud = 1\n", "utf-8")
    assert main(["config", "show", str(path)]) == 2
    told = capsys.readouterr().err
    assert f"{path}:2: laser.beams: " in told
    assert f"(and 1 more: edgefusion config check {path})" in told


def test_show_says_where_each_value_comes_from(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("laser.beams = 181\n[perception]\n\neps_m = 0.2\n", "utf-8")
    assert main(["config", "show", str(path), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["perception.eps_m"] == {"value": 0.2, "unit": "m", "from": str(path), "line": 4}
    assert shown["laser.beams"] == {"value": 181, "unit": "beams", "from": str(path), "line": 1}
    assert shown["laser.baudrate"] == {"value": 38400, "unit": "baud", "from": "default", "line": None}
    assert list(shown) == [".".join(key.path) for key in KEYS]
    assert main(["config", "show", str(path)]) == 0
    assert re.search(rf"^eps_m = 0.2 +# {path}:4$", capsys.readouterr().out, re.MULTILINE)


def test_what_show_prints_is_a_file_that_says_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, again = tmp_path / "robot.toml", tmp_path / "again.toml"
    path.write_text("[mission]\ninterest = ['\"a\\\\b\"', 'ä']\n[perception]\nheights = [1, 2.5]\n", "utf-8")
    main(["config", "show", str(path)])
    again.write_text(capsys.readouterr().out, "utf-8")
    assert load_config(again) == load_config(path)


def test_the_password_of_a_cameras_url_is_not_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("[camera]\nsource = 'rtsp://me:secret@camera/1'\n", "utf-8")
    for how in ([], ["--json"]):
        assert main(["config", "show", str(path), *how]) == 0
        told = capsys.readouterr().out
        assert "rtsp://***@camera/1" in told
        assert "secret" not in told


def test_files_are_relative_to_the_folder_of_the_configuration(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("[vision]\nmodel = 'models/net'\ncalibration = '/etc/calibration.toml'\n", "utf-8")
    vision = load_config(path).vision
    assert vision.model == str(tmp_path / "models/net")
    assert vision.calibration == "/etc/calibration.toml"
    assert vision.groups is None


TEXT = """# one
top = 1
dotted.key = '''
a = 1
[table]
'''

[ table . "in ner" ]   # a comment
list = [
  1,  # [x]

  2, ]
after = {inline = 1, deep.er = 2}
[[many]]
name = 1
[[many]]
name = 2
"""


def test_lines_are_those_where_a_statement_begins() -> None:
    assert key_lines(TEXT) == {
        ("top",): 2,
        ("dotted",): 3,
        ("dotted", "key"): 3,
        ("table",): 8,
        ("table", "in ner"): 8,
        ("table", "in ner", "list"): 9,
        ("table", "in ner", "after"): 13,
        ("table", "in ner", "after", "inline"): 13,
        ("table", "in ner", "after", "deep"): 13,
        ("table", "in ner", "after", "deep", "er"): 13,
        ("many",): 14,
        ("many", "name"): 15,
    }


def test_a_long_list_is_not_parsed_again_for_each_of_its_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    parse, parsed = toml_lines.tomllib.loads, []

    def counted(text: str) -> Any:
        parsed.append(text)
        return parse(text)

    monkeypatch.setattr(toml_lines.tomllib, "loads", counted)
    assert key_lines("a = [\n" + 1000 * "1,\n" + "]\nb = 1\n") == {("a",): 1, ("b",): 1003}
    assert len(parsed) < 10


VALUES = st.recursive(
    st.one_of(st.booleans(), st.integers(-(2**63), 2**63 - 1), st.floats(allow_nan=False, allow_infinity=False))
    | st.text(st.characters(blacklist_categories=["Cs"], blacklist_characters="\x7f")),
    lambda inner: st.lists(inner, max_size=3),
    max_leaves=6,
)


@given(values=st.lists(st.tuples(VALUES, st.sampled_from(["", "\n", "# comment = 1\n", "\n  \n"])), max_size=6))
def test_whatever_the_values_are_each_key_is_found_in_its_line(values: list[tuple[Any, str]]) -> None:
    text, expected = "", {}
    for number, (value, before) in enumerate(values):
        text += before
        expected[(f"k{number}",)] = text.count("\n") + 1
        text += f"k{number} = {toml_value(value)}\n"
    assert parse_toml(text, Path("x")) == {f"k{number}": value for number, (value, _) in enumerate(values)}
    assert key_lines(text) == expected


def test_a_byte_order_mark_before_everything_is_no_part_of_it(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("version = 1\n", "utf-8-sig")
    assert read_toml(path) == {"version": 1}


def test_a_file_with_windows_line_ends_has_the_same_lines(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_bytes(TEXT.replace("\n", "\r\n").encode())
    assert read_toml(path) == parse_toml(TEXT, path)
    assert key_lines(TEXT.replace("\n", "\r\n")) == key_lines(TEXT)
