"""A Dask cluster behind TLS: an authority of one's own, and who is not of it stays outside."""

from __future__ import annotations

import datetime
import ipaddress
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from agrik_fast import ArgumentError, cluster
from cluster_tools import ROBOT, Processes, run_cluster, scheduler_address, write_formula
from cluster_tools import hashes as hashes_of

pytestmark = [
    pytest.mark.filterwarnings("default"),
    pytest.mark.skipif(sys.platform != "linux", reason="processes are found in /proc"),
]


def write_certificates(folder: Path) -> tuple[Path, Path, Path]:
    """Write an authority's certificate, and one of a side that it vouches for with its key."""
    folder.mkdir()
    now = datetime.datetime.now(datetime.UTC)
    keys = {name: ec.generate_private_key(ec.SECP256R1()) for name in ("ca", "cert")}
    names = {
        name: x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, f"agrik_fast test {name}")])
        for name in keys
    }
    loopback = x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address("127.0.0.1"))])
    for name, key in keys.items():
        made = (
            x509.CertificateBuilder()
            .subject_name(names[name])
            .issuer_name(names["ca"])
            .public_key(key.public_key())
            .serial_number(x509.random_serial_number())
            .not_valid_before(now - datetime.timedelta(hours=1))
            .not_valid_after(now + datetime.timedelta(hours=1))
            .add_extension(x509.BasicConstraints(ca=name == "ca", path_length=None), critical=True)
            .add_extension(loopback, critical=False)
            .sign(keys["ca"], hashes.SHA256())
        )
        (folder / f"{name}.pem").write_bytes(made.public_bytes(serialization.Encoding.PEM))
    text = keys["cert"].private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    (folder / "key.pem").write_bytes(text)
    return folder / "ca.pem", folder / "cert.pem", folder / "key.pem"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, Path]:
    return write_certificates(tmp_path_factory.mktemp("tls") / "own")


@pytest.fixture(scope="module")
def address(
    files: tuple[Path, Path, Path], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[str]:
    """A scheduler and a worker behind TLS."""
    folder = tmp_path_factory.mktemp("cluster")
    started = Processes()
    words: tuple[object, ...] = ("--protocol", "tls", "--host", "127.0.0.1", "--no-dashboard")
    for name, path in zip(("ca-file", "cert", "key"), files, strict=True):
        words += (f"--tls-{name}", path)
    try:
        file = folder / "scheduler.json"
        scheduler = ("--port", 0, "--scheduler-file", file)
        started.start("-m", "distributed.cli.dask_scheduler", *words, *scheduler)
        found = scheduler_address(file)
        worker = ("--nthreads", 1, "--no-nanny", "--local-directory", folder / "dask")
        started.start("-m", "distributed.cli.dask_worker", found, *words, *worker)
        yield found
    finally:
        started.close()


def tls(files: tuple[Path, Path, Path]) -> tuple[object, ...]:
    return ("--tls-ca", files[0], "--tls-cert", files[1], "--tls-key", files[2])


def test_a_job_behind_tls_leaves_the_same_bytes(
    address: str, files: tuple[Path, Path, Path], tmp_path: Path
) -> None:
    assert address.startswith("tls://127.0.0.1:")
    formula = write_formula(tmp_path / "grid.toml", rows=400, size=200)
    job = ("--generate", formula, "--robot", ROBOT)
    run_cluster("solve", tmp_path / "out", *job, "--scheduler", address, *tls(files))
    run_cluster("solve", tmp_path / "here", *job, "--workers", 1)
    assert hashes_of(tmp_path / "out") == hashes_of(tmp_path / "here")
    assert len(hashes_of(tmp_path / "out")) == 3


def test_who_is_not_of_the_authority_stays_outside(address: str, tmp_path: Path) -> None:
    formula = write_formula(tmp_path / "grid.toml", rows=400, size=200)
    stranger = write_certificates(tmp_path / "stranger")
    job = ("--generate", formula, "--robot", ROBOT, "--timeout", 2)
    out = tmp_path / "out"
    _, err = run_cluster("solve", out, *job, "--scheduler", address, *tls(stranger), code=2)
    assert f"{address}: the scheduler does not answer within 2 s" in err
    assert not out.exists()


def test_files_and_protocol_belong_together(
    address: str, files: tuple[Path, Path, Path], tmp_path: Path
) -> None:
    formula = write_formula(tmp_path / "grid.toml", rows=400, size=200)
    job = ("--generate", formula, "--robot", ROBOT)
    out = tmp_path / "out"
    _, err = run_cluster("solve", out, *job, "--scheduler", address, code=2)
    assert "`--scheduler`: expected tls:// together with the files of TLS" in err
    plain = address.replace("tls:", "tcp:")
    _, err = run_cluster("solve", out, *job, "--scheduler", plain, *tls(files), code=2)
    assert "tcp:// without them" in err
    ca, cert, _ = files
    with pytest.raises(ArgumentError, match=r"`tls_key`: expected a PEM file, got .*none\.pem"):
        cluster.solve(
            None,
            out,
            ROBOT,
            generate=formula,
            scheduler=address,
            tls=cluster.Tls(ca, cert, tmp_path / "none.pem"),
        )
    assert not out.exists()
