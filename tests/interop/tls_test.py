"""Modbus over TLS with mutual certificates and roles (Modbus/TCP Security v36; SECURITY.md): `takt` on
both sides, and with OpenSSL's command line, Python's ssl and pymodbus as peers."""
import contextlib
import pathlib
import re
import socket
import ssl
import struct
import subprocess
import threading
import time

import pytest

import endpoints
from program import DEADLINE, start, takt, until

SCRIPT = pathlib.Path(__file__).resolve().parents[1] / "certificates.sh"
SERVER = """takt: 1
servers:
  - name: Panel
    transport: tls
    listen: 127.0.0.1
    tcp_port: {port}
    max_per_peer: 256
    tls: {{ca: root.pem, certificate: server/server.pem, key: server/server.key, crl: root.crl}}
    access:
      - {{roles: [Operator], rule: allow}}
      - {{roles: [none], functions: [read], rule: allow}}
    units:
      - {{address: 1, banks: [{{area: holding_register, items: [0..99]}}]}}
"""


@pytest.fixture(scope="module")
def plant(tmp_path_factory):
    """A folder of certificates."""
    folder = tmp_path_factory.mktemp("plant")
    subprocess.run(["sh", SCRIPT, folder], check=True, timeout=DEADLINE)
    return folder


@contextlib.contextmanager
def serving(*arguments, cwd):
    with start("serve", *arguments, cwd=cwd) as device:
        until(lambda: any("serving" in line for line in device.err), f"that it serves: {device!r}")
        yield device
        if device.process.poll() is None:
            device.interrupt()


@pytest.fixture(scope="module")
def panel(plant):
    """A server with rules by role, and its port."""
    port = endpoints.free_port()
    (plant / "panel.yaml").write_text(SERVER.format(port=port), encoding="utf-8")
    with serving("panel.yaml", cwd=plant):
        yield port


def client(plant, name, version=None):
    context = ssl.create_default_context(cafile=plant / "root.pem")
    if name:
        context.load_cert_chain(plant / name / "client.pem", plant / name / "client.key")
    if version:
        context.minimum_version = context.maximum_version = version
    return context


def connect(plant, port, name, version=None, session=None):
    plain = socket.create_connection(("127.0.0.1", port), timeout=DEADLINE)
    return client(plant, name, version).wrap_socket(plain, server_hostname="localhost", session=session)


def ask(connection, pdu):
    body = b"\1" + bytes.fromhex(pdu)
    connection.sendall(struct.pack(">HHH", 1, 0, len(body)) + body)
    answer = b""
    while len(answer) < 6 or len(answer) < 6 + struct.unpack(">H", answer[4:6])[0]:
        got = connection.recv(260)
        if not got:
            return None
        answer += got
    return answer[7:].hex()


def read_and_write(plant, port, name):
    """The exit codes of a read and of a write by `takt`, and what the first says that failed."""
    target = f"tls://localhost:{port}?certs={name}"
    results = [
        takt("read", target, "holding", 5, 1, code=None, cwd=plant),
        takt("write", target, "holding", 5, 7, code=None, cwd=plant)
    ]
    return [result.code for result in results], next((r.err for r in results if r.code), "")


@pytest.mark.parametrize("name, codes, says", [
    ("operator", [0, 0], ""),
    ("norole", [0, 5], "exception 1"),
    ("wrongtype", [0, 5], "exception 1"),
    ("nul", [0, 5], "exception 1"),
    ("broken", [0, 5], "exception 1"),
    ("revoked", [3, 3], "is revoked"),
    ("expired", [3, 3], "has expired"),
    ("serverasclient", [3, 3], "refuses this program's certificate"),
    ("stranger", [3, 3], "does not trust the root"),
    ("missing", [3, 3], "missing/ca.pem"),
])
def test_certificates_of_clients(plant, panel, name, codes, says):
    was, error = read_and_write(plant, panel, name)
    assert was == codes
    assert says in error


def test_a_line_of_a_project(plant, panel):
    (plant / "line.yaml").write_text(
        f"takt: 1\nlines:\n  - name: Plant\n    transport: tls\n    host: localhost\n    tcp_port: {panel}\n"
        "    tls: {ca: root.pem, certificate: operator/client.pem, key: operator/client.key}\n"
        "    devices:\n      - {name: Panel, address: 1, poll_period: 50ms, variables: "
        "[{name: A, type: uint16, area: holding_register, register: 5}]}\n",
        encoding="utf-8")
    assert takt("check", "line.yaml", cwd=plant)
    result = takt("run", "line.yaml", "--for", "1s", cwd=plant)
    assert "Panel A = " in result.out and "100.00 %" in result.out


@pytest.mark.parametrize("change, says", [
    ({
        "server_name": "boiler"
    }, "is for another host"),
    ({
        "ca": "stranger/client.pem"
    }, "leads to none of the trusted roots"),
    ({
        "crl": "root.pem"
    }, "no certificate, key or list in PEM"),
    ({
        "key": "root.key"
    }, "does not belong to the certificate"),
])
def test_a_server_that_is_not_the_right_one(plant, panel, change, says):
    keys = {"ca": "root.pem", "certificate": "operator/client.pem", "key": "operator/client.key"} | change
    tls = ", ".join(f"{key}: {value}" for key, value in keys.items())
    (plant / "wrong.yaml").write_text(
        f"takt: 1\nlines:\n  - name: Plant\n    transport: tls\n    host: localhost\n    tcp_port: {panel}\n"
        f"    tls: {{{tls}}}\n    devices:\n      - {{name: P, address: 1, variables: "
        "[{name: A, type: uint16, area: holding_register, register: 5}]}\n",
        encoding="utf-8")
    result = takt("run", "wrong.yaml", "--for", "300ms", code=None, cwd=plant)
    assert says in result.out + result.err


@pytest.mark.parametrize("version", [ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3])
def test_a_resumed_session_keeps_its_role(plant, panel, version):
    context = client(plant, "operator", version)

    def begin(session):
        plain = socket.create_connection(("127.0.0.1", panel), timeout=DEADLINE)
        return context.wrap_socket(plain, server_hostname="localhost", session=session)

    with begin(None) as first:
        assert ask(first, "06 0007 0011") == "0600070011"
        session = first.session
    with begin(session) as second:
        assert second.session_reused
        assert ask(second, "06 0007 0012") == "0600070012"


def test_without_a_certificate_nothing_is_answered(plant, panel):
    with pytest.raises((ssl.SSLError, ConnectionError)):
        with connect(plant, panel, None) as connection:
            assert ask(connection, "03 0000 0001") is None
            connection.read(1)


def s_client(plant, port, *options, stdin=""):
    command = ["openssl", "s_client", "-connect", f"127.0.0.1:{port}", "-CAfile", "root.pem", *options]
    done = subprocess.run(command, cwd=plant, input=stdin, capture_output=True, text=True, timeout=DEADLINE)
    return done.stdout + done.stderr


OPERATOR = ["-cert", "operator/client.pem", "-key", "operator/client.key"]


@pytest.mark.parametrize("options, expected", [
    (["-tls1_1", "-cipher", "ALL@SECLEVEL=0"], "alert protocol version"),
    (["-tls1_2", "-cipher", "ECDHE-ECDSA-AES128-GCM-SHA256"], "Cipher is ECDHE-ECDSA-AES128-GCM-SHA256"),
    (["-tls1_2"], "Secure Renegotiation IS supported"),
    (["-tls1_2"], "Compression: NONE"),
    (["-tls1_2", "-cipher", "AES128-SHA256"], "handshake failure"),
    (["-tls1_2", "-maxfraglen", "512"
     ], "Max. fragment length: 512|Fragment Length: 512|Verify return code: 0"),
    (["-showcerts"], r"(?s)BEGIN CERTIFICATE.*BEGIN CERTIFICATE"),
])
def test_what_is_negotiated(plant, panel, options, expected):
    assert re.search(expected, s_client(plant, panel, *OPERATOR, *options))


def test_a_renegotiation_is_refused(plant, panel):
    assert "no renegotiation" in s_client(plant, panel, *OPERATOR, "-tls1_2", stdin="R\n")


def test_slow_handshakes_delay_nobody(plant, panel):
    """A hundred clients that stop in their handshake, the half of them with a first byte of it."""
    slow = [socket.create_connection(("127.0.0.1", panel), timeout=DEADLINE) for _ in range(60)]
    for one in slow[::2]:
        one.sendall(b"\x16")
    try:
        with connect(plant, panel, "operator") as good:
            for _ in range(20):
                assert ask(good, "03 0000 0001") == "03020000"
        # The server ends them after five seconds.
        slow[0].settimeout(DEADLINE)
        with contextlib.suppress(ConnectionError):
            while slow[0].recv(100):
                pass
    finally:
        for one in slow:
            one.close()


def test_silent_clients_keep_nobody_out(plant, panel):
    """More of them than there may be connections; one that was there before stays."""
    with connect(plant, panel, "operator") as good, contextlib.ExitStack() as silent:
        for _ in range(300):
            with contextlib.suppress(OSError):
                silent.enter_context(socket.create_connection(("127.0.0.1", panel), timeout=DEADLINE))
        assert ask(good, "03 0000 0001") == "03020000"


def test_requests_while_others_shake_hands(plant, panel):
    stop = threading.Event()

    def flood():
        while not stop.is_set():
            with contextlib.suppress(OSError):
                connect(plant, panel, "operator").close()

    threads = [threading.Thread(target=flood) for _ in range(3)]
    with connect(plant, panel, "operator") as good:
        for thread in threads:
            thread.start()
        end = time.monotonic() + 2
        answered = 0
        while time.monotonic() < end:
            assert ask(good, "03 0000 0001") == "03020000"
            answered += 1
        stop.set()
    for thread in threads:
        thread.join()
    assert answered > 0


def test_pymodbus_asks_and_answers(plant, panel, tmp_path):
    program = pathlib.Path(__file__).resolve().parents[1] / "peers" / "pymodbus_tls.py"
    port = endpoints.free_port()
    peer = subprocess.Popen(["/usr/bin/python3", program, plant,
                             str(port), str(panel)],
                            stdout=subprocess.PIPE,
                            stderr=(tmp_path / "err").open("w"),
                            text=True)
    try:
        assert peer.stdout.readline().strip() == "[0, 0]", (tmp_path / "err").read_text()
        target = f"tls://localhost:{port}?certs=operator"
        assert takt("read", target, "holding", 3, 2, cwd=plant).out.split() == ["3", "7", "4", "7"]
    finally:
        peer.kill()
        peer.wait()
