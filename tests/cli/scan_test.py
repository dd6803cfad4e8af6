"""`takt scan`: the devices found, their settings and identification, and the written project."""
import datetime
import json
import signal
import statistics
import sys

import pytest

import endpoints
from fake_slave import TcpSlave, tcp_answer
from program import ROOT, Running, start, takt, until
from pty_slave import Device, PtyLine

QUICK = ["--timeout", "200ms"]


def scan(*arguments, code=0):
    return takt("scan", *arguments, "--json", code=code).json


def found(result):
    return {(d["unit"], d["baud"]) for d in result["devices"]}


def test_units_behind_different_bit_rates():
    with PtyLine(Device(3, 19200), Device(16, 9600), Device(17, 9600)) as line:
        result = scan(f"rtu://{line.port}", "--units", "3-4,16-18", "--bauds", "9600,19200,115200",
                      "--parities", "none", *QUICK)
        assert found(result) == {(3, 19200), (16, 9600), (17, 9600)}
        assert result["complete"] and not result["troubles"]
        assert {d["parity"] for d in result["devices"]} == {"none"}
        assert takt("read", result["devices"][0]["target"], "--unit", result["devices"][0]["unit"], "holding",
                    0).code == 0


def test_the_settings_of_the_target_are_the_only_ones():
    with PtyLine(Device(3, 9600), Device(4, 19200)) as line:
        result = scan(f"rtu://{line.port}?baud=9600&parity=none", "--units", "1-5", *QUICK)
        assert found(result) == {(3, 9600)}
        assert result["requests"] == 4 + 3


def test_first_leaves_the_port_where_something_was_found():
    with PtyLine(Device(3, 9600), Device(4, 115200)) as line:
        arguments = (f"rtu://{line.port}", "--units", "1-5", "--bauds", "9600,115200", "--parities", "none",
                     *QUICK)
        assert found(scan(*arguments, "--first")) == {(3, 9600)}
        assert found(scan(*arguments)) == {(3, 9600), (4, 115200)}


def test_device_identification():
    named = Device(1, objects={0: "Acme", 1: "T1", 2: "1.0"})
    old = Device(2, server_id=b"\x4bKC-1 relay\xff")
    refusing = Device(5, registers={100: 1})
    with PtyLine(named, old, refusing) as line:
        result = scan(f"rtu://{line.port}?baud=19200&parity=none", "--units", "1-6", *QUICK)
        first, second, third = result["devices"]
        assert (first["vendor"], first["product"], first["revision"]) == ("Acme", "T1", "1.0")
        assert second["vendor"] is None and bytes.fromhex(second["server_id"]) == b"\x4bKC-1 relay\xff"
        assert third["exception"] == 2
        text = takt("scan", f"rtu://{line.port}?baud=19200&parity=none", "--units", "1-6", *QUICK).out
        assert "Acme T1 1.0" in text and "KC-1 relay" in text and "exception 2" in text


def test_a_slow_device_is_not_lost():
    with PtyLine(Device(4, delay=0.5)) as line:
        result = scan(f"rtu://{line.port}?baud=19200&parity=none", "--units", "3-6", *QUICK)
        assert [(d["unit"], d["late"]) for d in result["devices"]] == [(4, True)]


def test_garbled_answers_are_no_device():
    with PtyLine(Device(4, garble=True)) as line:
        result = scan(f"rtu://{line.port}?baud=19200&parity=none", "--units", "1-6", *QUICK, code=1)
        assert result["devices"] == []
        assert [(t["kind"], t["unit"]) for t in result["troubles"]] == [("garbled", 4)]


def test_no_device_answers():
    with PtyLine() as line:
        result = takt("scan", f"rtu://{line.port}?baud=19200&parity=none", "--units", "1-3", *QUICK, code=1)
        assert result.out == ""
        assert "0" in result.err


def test_a_project_that_can_be_checked(tmp_path):
    path = tmp_path / "found.yaml"
    with PtyLine(Device(3, 9600, objects={
            0: 'Ac"me\\',
            1: "T1"
    }), Device(5, 9600, registers={9: 1}), Device(7, 19200)) as line:
        arguments = ("scan", f"rtu://{line.port}", "--units", "3-5,7", "--bauds", "9600,19200", "--parities",
                     "none", *QUICK, "--project", path)
        takt(*arguments)
        assert not [f for f in takt("check", path, "--json").json["findings"] if f["severity"] == "error"]
        text = path.read_text()
        assert "baud: 9600" in text and "address: 3" in text and "address: 5" in text
        assert "--unit 7" in text, "a setting that does not fit the line is in a comment"
        takt(*arguments, code=7)
        assert path.read_text() == text, "a file that is there stays"
        path.write_text("mine")
        takt(*arguments, "--force")
        assert path.read_text() != "mine"


def test_interrupted():
    with PtyLine(Device(1)) as line:
        arguments = ("scan", f"rtu://{line.port}?baud=19200&parity=none", "--timeout", "1s")
        with start(*arguments) as running:
            running.wait_line(lambda text: "--unit 1 " in text, "the first device")
            result = running.interrupt(signal.SIGINT, code=7)
            assert len(result.lines) == 1
        before = line.asked
        with start(*arguments, "--json") as running:
            until(lambda: line.asked >= before + 6, "a few units asked")
            result = json.loads(running.interrupt(signal.SIGINT, code=7).out)
            assert [d["unit"] for d in result["devices"]] == [1] and result["complete"] is False


def test_a_blank_device_of_ours(blank_device):
    port = blank_device(unit=9)
    result = scan(f"tcp://127.0.0.1:{port}", "--units", "8-10", "--timeout", "500ms")
    assert [d["unit"] for d in result["devices"]] == [9]
    assert result["devices"][0]["baud"] is None


def test_pymodbus():
    port = endpoints.free_port()
    with Running([sys.executable, ROOT / "tests/peers/pymodbus_server.py", "tcp", port, 1,
                  "identity"]) as peer:
        peer.wait_line(lambda line: line == "ready", "ready")
        device, = scan(f"tcp://127.0.0.1:{port}", "--units", "1", "--timeout", "20s")["devices"]
        assert (device["vendor"], device["product"], device["revision"]) == ("Acme", "T1", "1.0")
        assert device["model"] == "Model M", "regular objects too"


def test_a_gateway_reports_missing_units():

    def answer(adu):
        if adu[6] != 5:
            return tcp_answer(adu, f"{adu[7] | 0x80:02X} 0B")
        return tcp_answer(adu, "03 02 00 07" if adu[7] == 3 else f"{adu[7] | 0x80:02X} 01")

    with TcpSlave(answer) as slave:
        result = scan(f"tcp://127.0.0.1:{slave.port}", "--units", "1-40")
        assert [d["unit"] for d in result["devices"]] == [5]


def only(unit):
    """A device over TCP that answers one unit and is silent for all others."""

    def answer(adu):
        if adu[6] != unit:
            return None
        return tcp_answer(adu, "03 02 00 07" if adu[7] == 3 else f"{adu[7] | 0x80:02X} 01")

    return TcpSlave(answer)


def median_pause(traffic):
    """Between two requests, in seconds."""
    sent = [
        datetime.datetime.fromisoformat(line[1:line.index("]")]) for line in traffic.read_text().splitlines()
        if " Tx: " in line
    ]
    return statistics.median((b - a).total_seconds() for a, b in zip(sent, sent[1:]))


def test_a_host_is_scanned_in_seconds(tmp_path):
    """The wait for a silent unit adapts to the answers so far. A written time-out is waited for."""
    with only(1) as slave:
        command = ["scan", f"tcp://127.0.0.1:{slave.port}", "--json", "--traffic"]
        result = takt(*command, tmp_path / "quick", deadline=500).json
        assert [d["unit"] for d in result["devices"]] == [1] and result["complete"]
        assert result["requests"] >= 249, "all units are asked"
        takt(*command, tmp_path / "slow", "--timeout", "1s", "--units", "1-7")
    assert median_pause(tmp_path / "quick") < 0.75 * median_pause(tmp_path / "slow")


def units_asked(traffic):
    """The units of the requests, each once, in turn. The seventh byte of a frame of Modbus TCP is the
    unit."""
    sent = [
        line.split("] ", 2)[-1].split()[6] for line in traffic.read_text().splitlines() if " Tx: " in line
    ]
    return list(dict.fromkeys(int(unit, 16) for unit in sent))


def test_the_units_of_a_host_are_asked_first(tmp_path):
    with TcpSlave(lambda adu: tcp_answer(adu, f"{adu[7] | 0x80:02X} 0B")) as slave:
        takt("scan", f"tcp://127.0.0.1:{slave.port}", "--traffic", tmp_path / "t.log", code=1)
    assert units_asked(tmp_path / "t.log") == [1, 0, 255, *range(2, 248)]


def runs(path, name):
    """The first good value of a variable when the project runs."""
    with start("run", path, "--json") as running:
        event = running.wait_event(lambda e: e.get("name") == name and e.get("quality") == "good",
                                   f"{name} is good")
        running.interrupt()
        return event["value"]


@pytest.mark.parametrize("serial", [True, False], ids=["pty", "tcp"])
def test_a_probed_project_runs(tmp_path, serial):
    path = tmp_path / "found.yaml"
    there = {a: 1000 + a for a in [*range(0, 40), *range(100, 104)]}
    device = Device(3, 9600, registers=there, limit=20)
    arguments = ("--project", path, "--probe", "--units", "2-4")
    if serial:
        with PtyLine(device) as line:
            takt("scan", f"rtu://{line.port}?baud=9600&parity=none", *QUICK, *arguments, deadline=300)
            assert runs(path, "line1_unit3_holding_103") == 1103
    else:
        answers = lambda adu: tcp_answer(adu, device.answer(adu[7:]).hex()) if adu[6] == 3 else None
        with TcpSlave(answers) as slave:
            takt("scan", f"tcp://127.0.0.1:{slave.port}", *arguments, deadline=120)
            assert runs(path, "line1_unit3_holding_103") == 1103
    text = path.read_text()
    assert "holding_register: [0..39, 100..103]" in text and "registers_per_request: 20" in text
    assert takt("check", path, "--json").json["findings"] == [] or \
        not [f for f in takt("check", path, "--json").json["findings"] if f["severity"] != "note"]


def test_a_probe_without_a_project():
    assert "--project" in takt("scan", "tcp://127.0.0.1:1", "--probe", code=2).err


def test_a_range_of_hosts(blank_device):
    port = blank_device()
    result = scan(f"tcp://127.0.0.1-4:{port}", "--units", "1", "--timeout", "500ms")
    assert len(result["devices"]) >= 1 and "127.0.0.1" in result["devices"][0]["target"]
    assert result["absent_hosts"] + len(result["devices"]) == 4


def test_a_target_named_twice_is_looked_at_once(blank_device):
    target = f"tcp://127.0.0.1:{blank_device()}"
    found = scan(target, target, target.replace("127.0.0.1", "127.0.0.1/32"), "--units", "1")
    assert len(found["devices"]) == 1


def test_a_host_that_is_not_there():
    takt("scan", f"tcp://127.0.0.1:{endpoints.free_port()}", code=3)
    takt("scan", "rtu:///dev/not-there", code=3)


@pytest.mark.parametrize("arguments", [
    [],
    ["nowhere"],
    ["tcp://127.0.0.1", "--units", "0-256"],
    ["tcp://127.0.0.1", "--units", "5-1"],
    ["tcp://127.0.0.1", "--units", "x"],
    ["rtu:///dev/ttyS0", "--bauds", "1"],
    ["rtu:///dev/ttyS0", "--parities", "mark"],
    ["rtu:///dev/ttyS0", "--stop-bits", "3"],
    ["rtu:///dev/ttyS0", "--units", "0"],
    ["tcp://10.0.0.0/8"],
    ["tcp://10.0.0.9-1"],
    ["tcp://127.0.0.1", "--timeout", "5"],
    ["tcp://127.0.0.1", "--timeout", "0ms"],
], ids=lambda a: " ".join(a).replace("/", "|") or "nothing")
def test_bad_usage(arguments):
    result = takt("scan", *arguments, code=2)
    assert result.out == "" and result.err.strip()
