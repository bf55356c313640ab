# SPDX-License-Identifier: Apache-2.0
# Copyright the edgefusion authors
"""A certificate authority of one's own, and certificates for the roles: pure, and in memory (the extra `keys`).

Certificates are valid from the year 2000 on: a computer whose clock has no battery boots far in the past, and its
operator must be let in all the same.
"""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass
from datetime import datetime
from typing import Sequence, Union

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from edgefusion.bus.key_files import ROLES
from edgefusion.errors import RefusedError

SINCE = datetime(2000, 1, 1)
LONGEST_NAME = 64  # what X.509 allows for an organization's or a common name
LOCAL_HOSTS = ("localhost", "127.0.0.1")

Name = Union[x509.DNSName, x509.IPAddress]


@dataclass(frozen=True)
class Issued:
    """A certificate and its private key, both PEM."""

    certificate: bytes
    key: bytes


def make_authority(until: datetime) -> Issued:
    """A new certificate authority. until: when it and all that it has issued end (UTC)."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "edgefusion CA")])
    builder = _builder(name, name, key.public_key(), until)
    builder = builder.add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
    builder = builder.add_extension(_usage(signs_certificates=True), critical=True)
    return _issued(builder, key, key)


def issue(authority: Issued, name: str, role: str, hosts: Sequence[str] = ()) -> Issued:
    """A certificate for whoever is called `name`, valid as long as the authority.

    role: one of ROLES, the certificate's common name, by which access is controlled; hosts: names and addresses at
    which it serves, none for one that only connects. Raises RefusedError for what is no name, role or host.
    """
    if role not in ROLES:
        raise RefusedError(f"role: expected one of {', '.join(ROLES)}, got {role!r}")
    if not (name.isprintable() and 0 < len(name) <= LONGEST_NAME):
        raise RefusedError(f"name: expected 1 to {LONGEST_NAME} printable characters, got {name!r}")
    parent, parent_key = _authority(authority)
    key = ec.generate_private_key(ec.SECP256R1())
    subject = x509.Name(
        [x509.NameAttribute(NameOID.ORGANIZATION_NAME, name), x509.NameAttribute(NameOID.COMMON_NAME, role)]
    )
    builder = _builder(subject, parent.subject, key.public_key(), _until(parent))
    builder = builder.add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
    builder = builder.add_extension(_usage(signs_certificates=False), critical=True)
    purposes = [ExtendedKeyUsageOID.CLIENT_AUTH] + ([ExtendedKeyUsageOID.SERVER_AUTH] if hosts else [])
    builder = builder.add_extension(x509.ExtendedKeyUsage(purposes), critical=False)
    names = [host_name(host) for host in hosts] or [x509.DNSName(f"{role}.invalid")]
    builder = builder.add_extension(x509.SubjectAlternativeName(names), critical=False)
    return _issued(builder, key, parent_key)


def host_name(host: str) -> Name:
    """A host as a certificate names it. Raises RefusedError for what is neither a name nor an address."""
    try:
        return x509.IPAddress(ipaddress.ip_address(host))
    except ValueError:
        pass
    labels = host.split(".")
    if len(host) > 253 or not all(_is_label(label) for label in labels) or labels[-1].isdigit():
        raise RefusedError(f"host: expected a name like robot.local or an address like 192.168.0.5, got {host!r}")
    return x509.DNSName(host)


def _is_label(label: str) -> bool:
    plain = label.replace("-", "").replace("_", "")
    return plain.isascii() and plain.isalnum() and len(label) <= 63 and not label.startswith("-")


def _authority(authority: Issued) -> tuple[x509.Certificate, ec.EllipticCurvePrivateKey]:
    try:
        parent = x509.load_pem_x509_certificate(authority.certificate)
        key = serialization.load_pem_private_key(authority.key, None)
    except (ValueError, TypeError) as error:
        raise RefusedError(f"keys: expected a CA's certificate and key in PEM: {error}") from error
    if not isinstance(key, ec.EllipticCurvePrivateKey):
        raise RefusedError(f"keys: expected an elliptic curve's key of a CA, got {type(key).__name__}")
    return parent, key


def _until(certificate: x509.Certificate) -> datetime:
    """Its end; the property that is no longer deprecated is younger than what a Jetson has."""
    utc = getattr(certificate, "not_valid_after_utc", None)
    return certificate.not_valid_after if utc is None else utc.replace(tzinfo=None)


def _builder(
    subject: x509.Name, issuer: x509.Name, key: ec.EllipticCurvePublicKey, until: datetime
) -> x509.CertificateBuilder:
    builder = x509.CertificateBuilder().subject_name(subject).issuer_name(issuer).public_key(key)
    builder = builder.serial_number(x509.random_serial_number())
    return builder.not_valid_before(SINCE).not_valid_after(until)


def _usage(signs_certificates: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=not signs_certificates,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=signs_certificates,
        crl_sign=signs_certificates,
        encipher_only=False,
        decipher_only=False,
    )


def _issued(
    builder: x509.CertificateBuilder, key: ec.EllipticCurvePrivateKey, signer: ec.EllipticCurvePrivateKey
) -> Issued:
    pem = serialization.Encoding.PEM
    secret = key.private_bytes(pem, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
    return Issued(builder.sign(signer, hashes.SHA256()).public_bytes(pem), secret)
