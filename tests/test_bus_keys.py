# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""`edgefusion keys`: a CA, a folder for each role, and what is refused. Whom they let in is in test_bus_security."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Sequence

import pytest
from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from edgefusion.bus import key_folder
from edgefusion.bus.key_files import find_keys, usual_folder
from edgefusion.cli import main
from edgefusion.errors import RefusedError

UNTIL = datetime(2040, 1, 1)


def certificate(folder: Path) -> x509.Certificate:
    return x509.load_pem_x509_certificate((folder / "cert.pem").read_bytes())


def purposes(folder: Path) -> Sequence[x509.ObjectIdentifier]:
    return list(certificate(folder).extensions.get_extension_for_class(x509.ExtendedKeyUsage).value)


def valid_from(issued: x509.Certificate) -> datetime:
    utc = getattr(issued, "not_valid_before_utc", None)  # the other one is deprecated where this one is
    return issued.not_valid_before if utc is None else utc.replace(tzinfo=None)


def test_init_makes_a_ca_and_keys_for_each_role_that_it_has_signed(tmp_path: Path) -> None:
    assert main(["keys", "init", "--host", "robot.local", "192.168.0.5", "--out", str(tmp_path / "k")]) == 0
    ca = x509.load_pem_x509_certificate((tmp_path / "k" / "ca" / "ca.pem").read_bytes())
    for role in ("robot", "operator", "viewer"):
        issued = certificate(tmp_path / "k" / role)
        key = ca.public_key()
        assert isinstance(key, ec.EllipticCurvePublicKey)
        assert issued.signature_hash_algorithm is not None
        key.verify(issued.signature, issued.tbs_certificate_bytes, ec.ECDSA(issued.signature_hash_algorithm))
        assert issued.subject.get_attributes_for_oid(NameOID.COMMON_NAME)[0].value == role
        find_keys(tmp_path / "k" / role)


def test_the_robots_certificate_is_for_its_hosts_and_its_loopback(tmp_path: Path) -> None:
    key_folder.init(tmp_path, ["robot.local", "192.168.0.5", "fe80::1"], UNTIL)
    names = certificate(tmp_path / "robot").extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert names.get_values_for_type(x509.DNSName) == ["robot.local", "localhost"]
    assert [str(each) for each in names.get_values_for_type(x509.IPAddress)] == ["192.168.0.5", "fe80::1", "127.0.0.1"]


def test_only_the_robot_may_serve(tmp_path: Path) -> None:
    key_folder.init(tmp_path, ["robot"], UNTIL)
    assert ExtendedKeyUsageOID.SERVER_AUTH in purposes(tmp_path / "robot")
    for role in ("operator", "viewer"):
        assert purposes(tmp_path / role) == [ExtendedKeyUsageOID.CLIENT_AUTH]


def test_nobody_else_can_read_a_secret_key(tmp_path: Path) -> None:
    key_folder.init(tmp_path / "k", ["robot"], UNTIL)
    secrets = list((tmp_path / "k").glob("*/key.pem"))
    assert len(secrets) == 4
    assert all(path.stat().st_mode & 0o077 == 0 for path in secrets)
    (tmp_path / "k" / "robot" / "key.pem").chmod(0o644)
    with pytest.raises(RefusedError, match="chmod 600"):
        find_keys(tmp_path / "k" / "robot")


def test_keys_hold_on_a_computer_whose_clock_booted_in_the_past(tmp_path: Path) -> None:
    key_folder.init(tmp_path, ["robot"], UNTIL)
    for path in tmp_path.glob("*/c*.pem"):
        assert valid_from(x509.load_pem_x509_certificate(path.read_bytes())).year <= 2000


def test_add_makes_one_more_folder_from_the_same_ca(tmp_path: Path) -> None:
    assert main(["keys", "init", "--host", "robot", "--out", str(tmp_path)]) == 0
    assert main(["keys", "add", "tablet", "--role", "viewer", "--keys", str(tmp_path)]) == 0
    added = certificate(tmp_path / "tablet")
    assert added.subject.get_attributes_for_oid(NameOID.COMMON_NAME)[0].value == "viewer"
    assert added.subject.get_attributes_for_oid(NameOID.ORGANIZATION_NAME)[0].value == "tablet"
    assert (tmp_path / "tablet" / "ca.pem").read_bytes() == (tmp_path / "ca" / "ca.pem").read_bytes()


def test_keys_are_never_overwritten(tmp_path: Path) -> None:
    key_folder.init(tmp_path, ["robot"], UNTIL)
    before = (tmp_path / "robot" / "key.pem").read_bytes()
    with pytest.raises(RefusedError, match="new or empty folder"):
        key_folder.init(tmp_path, ["robot"], UNTIL)
    with pytest.raises(RefusedError, match="name: expected one that is not taken"):
        key_folder.add(tmp_path, "robot", "viewer")
    assert (tmp_path / "robot" / "key.pem").read_bytes() == before


@pytest.mark.parametrize("host", ["", "a b", "-robot", "robot..local", "*.local", "192.168.0.500", "a" * 64, "robot/x"])
def test_what_is_no_host_is_refused_before_anything_is_written(tmp_path: Path, host: str) -> None:
    with pytest.raises(RefusedError, match="host: expected a name"):
        key_folder.init(tmp_path / "k", [host], UNTIL)
    assert not (tmp_path / "k").exists()


@pytest.mark.parametrize("name", ["", "../robot", "a/b", ".hidden", "a\nb", "x" * 65])
def test_what_is_no_name_is_refused(tmp_path: Path, name: str) -> None:
    key_folder.init(tmp_path, ["robot"], UNTIL)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(RefusedError, match="name: expected"):
        key_folder.add(tmp_path, name, "viewer")
    assert sorted(tmp_path.iterdir()) == before


def test_add_without_a_ca_says_how_to_make_one(tmp_path: Path) -> None:
    with pytest.raises(RefusedError, match="keys init"):
        key_folder.add(tmp_path, "tablet", "viewer")


def test_a_ca_that_is_none_is_refused(tmp_path: Path) -> None:
    key_folder.init(tmp_path, ["robot"], UNTIL)
    (tmp_path / "ca" / "key.pem").write_text("not a key", encoding="ascii")
    with pytest.raises(RefusedError, match="expected a CA's certificate and key"):
        key_folder.add(tmp_path, "tablet", "viewer")


def test_a_folder_without_keys_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(RefusedError, match=r"ca\.pem"):
        find_keys(tmp_path)


def test_a_laptops_keys_are_looked_for_where_it_says_or_at_home() -> None:
    assert usual_folder({}, Path("/home/me")) == Path("/home/me/.config/edgefusion/keys")
    assert usual_folder({"EDGEFUSION_KEYS": "/k"}, Path("/home/me")) == Path("/k")
