"""docs/specification.md, section 12: which clients may ask a server for what, and the log of writes and
refusals."""
import contextlib
import json
import signal
import socket
import struct

import endpoints
from program import DEADLINE, start, takt, until

RULES = """
- {peers: [127.0.0.0/8], functions: [write], area: holding_register, items: [0..9], rule: allow}
- {peers: [127.0.0.0/8, "::1"], functions: [read], rule: allow}
"""


def ask(port, *pdus, host="127.0.0.1", unit=1):
    """The answers to requests on one connection."""
    answers = []
    with socket.create_connection((host, port), timeout=DEADLINE) as connection:
        for pdu in pdus:
            body = bytes([unit]) + bytes.fromhex(pdu)
            connection.sendall(struct.pack(">HHH", 1, 0, len(body)) + body)
            head = connection.recv(6, socket.MSG_WAITALL)
            answers.append(connection.recv(struct.unpack(">HHH", head)[2], socket.MSG_WAITALL)[1:].hex())
    return answers


@contextlib.contextmanager
def guarded(*options, host="127.0.0.1"):
    port = endpoints.free_port()
    address = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
    with start("serve", "--listen", address, *options) as device:
        until(lambda: any("serving" in line for line in device.err), f"that it serves: {device!r}")
        yield port, device
        if device.process.poll() is None:
            device.interrupt()


def rules(tmp_path, text=RULES):
    path = tmp_path / "access.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_rules_of_a_file(tmp_path):
    with guarded("--access", rules(tmp_path)) as (port, _):
        assert ask(port, "03 0000 0002", "06 0009 0001", "06 000A 0001", "10 0009 0002 04 0001 0002",
                   "05 0000 FF00", "17 0000 0001 0009 0001 02 0005", "08 0000 1234") == \
            ["030400000000", "0600090001", "8601", "9001", "8501", "17020000", "8801"]


def test_an_ipv6_peer(tmp_path):
    with guarded("--access", rules(tmp_path), host="::1") as (port, _):
        assert ask(port, "03 0000 0001", "06 0000 0001", host="::1") == ["03020000", "8601"]


def test_a_rate(tmp_path):
    path = rules(tmp_path, "- {rule: allow, rate: 1, burst: 3}\n")
    with guarded("--access", path) as (port, _):
        answers = ask(port, *["03 0000 0001"] * 20)
        assert answers[:3] == ["03020000"] * 3 and "8306" in answers[3:]


def test_rules_are_read_again(tmp_path):
    path = rules(tmp_path)
    with guarded("--access", path) as (port, device):
        assert ask(port, "06 0000 0001") == ["0600000001"]

        def reload(text, said):
            before = len(device.err)
            path.write_text(text)
            device.process.send_signal(signal.SIGHUP)
            until(lambda: any(said in line for line in device.err[before:]), f"{said}: {device!r}")

        reload("- {rule: read_only}\n", "access rules in force: 1")
        assert ask(port, "06 0000 0001", "03 0000 0001") == ["8601", "03020001"]
        reload("- {rule: maybe}\n", "stay in force")
        assert any("access[0].rule" in line for line in device.err), "the mistake is reported"
        assert ask(port, "06 0000 0001", "03 0000 0001") == ["8601", "03020001"]
        reload("rule: allow\n", "stay in force")
        path.unlink()
        device.process.send_signal(signal.SIGHUP)
        until(lambda: sum("stay in force" in line for line in device.err) == 3, "an absent file")
        assert ask(port, "06 0000 0001") == ["8601"]


def test_a_broken_file_is_no_start(tmp_path):
    path = rules(tmp_path, "- {peers: [1.2.3], rule: allow}\n")
    result = takt("serve", "--listen", f"127.0.0.1:{endpoints.free_port()}", "--access", path, code=2)
    assert "access[0].peers[0]" in result.err and "1.2.3" in result.err


def test_the_audit_log(tmp_path):
    log = tmp_path / "audit.log"
    with guarded("--access", rules(tmp_path), "--audit", log) as (port, device):
        ask(port, "06 0003 0007", "10 0003 0002 04 0008 0009", "03 0000 0001", "06 000A 0001",
            "16 0003 00F0 0001")
        device.interrupt()
    lines = [json.loads(line) for line in log.read_text().splitlines()]
    assert all(line.pop("time").endswith("Z") and line.pop("peer").startswith("127.0.0.1:") for line in lines)
    area = {"unit": 1, "area": "holding_register"}
    assert lines == [
        area | {
            "event": "write",
            "function": 6,
            "start": 3,
            "count": 1,
            "old": [0],
            "new": [7]
        },
        area | {
            "event": "write",
            "function": 16,
            "start": 3,
            "count": 2,
            "old": [7, 0],
            "new": [8, 9]
        },
        area | {
            "event": "refused",
            "function": 6,
            "start": 10,
            "count": 1,
            "request": "06000a0001",
            "why": "rule",
            "exception": 1
        },
        area | {
            "event": "write",
            "function": 22,
            "start": 3,
            "count": 1,
            "old": [8],
            "new": [1]
        },
    ]


def test_servers_of_a_project(project, tmp_path):
    port = endpoints.free_port()
    text = f"""
takt: 1
servers:
  - name: plant
    listen: 127.0.0.1
    tcp_port: {port}
    audit: plant.audit
    access:
      - {{units: [2], rule: read_only}}
      - {{units: [1], area: holding_register, items: [0..4], rule: allow}}
    units:
      - {{address: 1, banks: [{{area: holding_register, items: [0..9]}}]}}
      - {{address: 2, banks: [{{area: holding_register, items: [0..9]}}]}}
"""
    path = project(text)
    with start("serve", path) as device:
        endpoints.wait_listening(port, device)
        assert ask(port, "06 0004 0001", "06 0005 0001", "03 0003 0003") == ["0600040001", "8601", "8301"]
        assert ask(port, "06 0004 0001", unit=0) == ["0600040001"], "0 means the first unit"
        assert ask(port, "06 0005 0001", unit=255) == ["8601"]
        assert ask(port, "06 0004 0001", "03 0000 0001", unit=2) == ["8601", "03020000"]
        path.write_text(text.replace("rule: allow", "rule: deny"))
        device.process.send_signal(signal.SIGHUP)
        until(lambda: ask(port, "06 0004 0001") == ["8601"], "the new rules")
        path.write_text("takt: 1\n")
        device.process.send_signal(signal.SIGHUP)
        until(lambda: any("stay in force" in line for line in device.err), repr(device))
        assert ask(port, "03 0000 0001", unit=2) == ["03020000"]
        device.interrupt()
    assert (tmp_path / "plant.audit").exists()
