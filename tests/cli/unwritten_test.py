"""A write that failed, or whose outcome is unknown, is reported in the stream, in the log, and to its
client."""
import re
import socket

import pytest

from fake_slave import TcpSlave
from program import start, takt, until
from projects import tcp

WRITTEN = "type: int16, read: 0x03, write: 0x10, write_on_change: true"
VARIABLES = [
    "name: Wanted, register: 0, " + WRITTEN, "name: Ordered, register: 9, type: int16, write: 0x06",
    "name: Checked, register: 20, verify: true, " + WRITTEN
]


def answered(adu, pdu):
    pdu = bytes.fromhex(pdu)
    return adu[:4] + (len(pdu) + 1).to_bytes(2, "big") + adu[6:7] + pdu


class Device:
    """Register 20 keeps 40 after any write; other writes are treated according to `refusal`."""

    def __init__(self):
        self.refusal = "exception"
        self.values = {}
        self.dead = False

    def __call__(self, adu):
        if self.dead:
            return None
        function, register = adu[7], int.from_bytes(adu[8:10], "big")
        if function == 3:
            count = int.from_bytes(adu[10:12], "big")
            values = "".join(f"{40 if r == 20 else self.values.get(r, 7):04X}"
                             for r in range(register, register + count))
            return answered(adu, f"03 {2 * count:02X}{values}")
        if register != 20 and self.refusal == "exception":
            return answered(adu, f"{function | 0x80:02X} 02")
        if register != 20 and self.refusal == "silence":
            return None
        if function == 16:
            self.values[register] = int.from_bytes(adu[13:15], "big")
        return answered(adu, adu[7:12].hex())


@pytest.fixture
def device():
    return Device()


@pytest.fixture
def slave(device):
    with TcpSlave(device) as running:
        yield running


@pytest.fixture
def path(project, slave):
    return project(tcp(VARIABLES, slave.port, response_timeout="1s", poll_period="50ms"))


@pytest.fixture
def run(path, tmp_path):
    with start("run", path, "--json", "--stdin", "--control", tmp_path / "control", "--log",
               tmp_path / "log") as running:
        running.control, running.log = tmp_path / "control", tmp_path / "log"
        running.wait_event(lambda e: e["event"] == "value" and e["quality"] == "good", "a value")
        yield running


def outcomes(run, name):
    return [e for e in run.events() if e["event"] == "outcome" and e["name"] == name]


def test_a_refused_set_is_answered_and_reported_in_the_stream(run):
    refused = takt("ctl", run.control, "set", "Wanted", 9, code=1)
    assert refused.out == "refused Wanted exception 2 wanted 9\n"
    event = run.wait_event(lambda e: e["event"] == "outcome", "the event")
    assert {k: event[k]
            for k in ("command", "device", "name", "wanted", "outcome", "reason")} == {
                "command": "set",
                "device": "Node1",
                "name": "Wanted",
                "wanted": "9",
                "outcome": "refused",
                "reason": "exception 2"
            }
    assert event["id"] == 1
    run.interrupt()
    words = r"warning host: line net, device Node1 \(unit 1\): Wanted: 9 was not written " \
        r"\(command `set`\): exception 2: "
    assert re.search(words, run.log.read_text()), run.log.read_text()


def test_on_standard_input_it_is_reported_once(run):
    run.send("set Wanted 5")
    run.send("get Ordered")
    run.wait_event(lambda e: e["event"] == "outcome", "the outcome")
    run.interrupt()
    assert len(outcomes(run, "Wanted")) == 1


def test_a_refused_write_by_ctl_is_in_the_stream_too(run):
    assert takt("ctl", run.control, "write", "Ordered", 3,
                code=1).out == "refused Ordered exception 2 wanted 3\n"
    event = run.wait_event(lambda e: e["event"] == "outcome", "the event")
    assert (event["command"], event["id"], event["name"], event["wanted"]) == ("write", 1, "Ordered", "3")
    run.interrupt()


def test_an_unknown_outcome_of_set_is_reported(run, device):
    device.refusal = "silence"
    assert takt("ctl", run.control, "set", "Wanted", 8, code=1).out == "unknown Wanted timeout wanted 8\n"
    run.wait_event(lambda e: e["event"] == "outcome" and e["outcome"] == "unknown", "the event")


def test_a_different_read_back_reports_both_values(run):
    assert takt("ctl", run.control, "set", "Checked", 50,
                code=1).out == "refused Checked differs written 50 read 40\n"
    event = run.wait_event(lambda e: e["event"] == "outcome", "the event")
    assert (event["wanted"], event["written"], event["read"]) == ("50", "50", "40")


def test_a_set_that_is_written_is_answered_when_it_is(run, device):
    device.refusal = None
    assert takt("ctl", run.control, "set", "Wanted", 3).out == "ok Wanted 3\n"
    assert device.values[0] == 3
    assert not outcomes(run, "Wanted"), "no news"


def test_a_set_for_a_device_that_is_silent_waits_and_says_so(run, device):
    device.dead = True
    run.wait_event(lambda e: e["event"] == "device" and e["state"] == "not_answering", "silence")
    assert takt("ctl", run.control, "set", "Wanted", 3).out == "ok Wanted 3 waiting\n"
    device.refusal = None
    device.dead = False
    until(lambda: device.values.get(0) == 3, "it is written")


def test_of_two_sets_the_earlier_gives_way(run, device):
    """The device is slow to refuse: both come while the first is under way."""
    device.refusal = "silence"
    with socket.socket(socket.AF_UNIX) as client:
        client.connect(str(run.control))
        client.settimeout(30)
        client.sendall(b"set Wanted 1\nset Wanted 2\n")
        seen = b""
        while seen.count(b"\n") < 2:
            seen += client.recv(1000)
    assert seen.splitlines() == [b"ok Wanted 1 superseded", b"unknown Wanted timeout wanted 2"]


@pytest.mark.parametrize(
    "language, words",
    [("en", "Node1: Wanted: 9 was not written (command `set`): exception 2: illegal data address"),
     ("ru", "значение 9 не записано (команда `set`): исключение 2: "),
     ("uk", "значення 9 не записано (команда `set`): виняток 2: ")])
def test_in_words(path, tmp_path, language, words):
    with start("--lang", language, "run", path, "--control", tmp_path / "control") as running:
        running.wait_line(lambda line: "Wanted = 7" in line, "a value")
        takt("ctl", tmp_path / "control", "set", "Wanted", 9, code=1)
        running.wait_line(lambda line: words in line, "the news")
        running.interrupt()
