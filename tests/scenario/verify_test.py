"""docs/specification.md, section 9: writes that are read back and compared."""
import pytest

from fake_slave import Device, RtuDevices, TcpSlave
from program import start
from projects import serial, tcp

VERIFIED = "type: int16, read: 0x03, write: 0x10, verify: true, period: 1h"


def outcome(run, command):
    before = len(run.out)
    run.send(command)
    return run.wait_event(lambda e: e["event"] == "outcome", f"the outcome of {command!r}", after=before)


def lowered(device):
    """The device limits what is written to 40."""

    def meddle(pdu):
        answer = device.obey(pdu)
        device.registers = {a: min(v, 40) for a, v in device.registers.items()}
        return answer

    return meddle


@pytest.mark.parametrize("more", ["", ", write_on_change: true"])
def test_on_a_serial_line(project, pair, more):
    device = Device({0: 7})
    path = project(serial(["name: V, register: 0, " + VERIFIED + more], port=pair.a, response_timeout="1s"))
    with RtuDevices(pair.b, {16: device}), start("run", path, "--json", "--stdin") as run:
        run.wait_event(lambda e: e.get("value") == 7, "the first value")
        assert outcome(run, "write V 30")["outcome"] == "done"
        assert device.done[-2:] == ["10 00 00 00 01 02 00 1E", "03 00 00 00 01"]
        device.meddle = lowered(device)
        refused = outcome(run, "write V 50")
        assert (refused["outcome"], refused["reason"]) == ("refused", "differs")
        assert (refused["written"], refused["read"]) == ("50", "40")
        event = run.wait_event(lambda e: e["event"] == "verify_failed", "both values")
        assert (event["name"], event["written"], event["read"]) == ("V", 50, 40)
        device.meddle = lambda pdu: "silence" if pdu[0] == 3 else None
        unknown = outcome(run, "write V 20")
        assert (unknown["outcome"], unknown["reason"]) == ("unknown", "timeout")
        result = run.interrupt()
    summary = run.events()[-1]["lines"][0]["devices"][0]
    assert (summary["verified"], summary["differed"]) == (1, 1), result


def test_the_answer_in_words(project):
    device = Device()
    device.meddle = lowered(device)
    with TcpSlave(device.over_tcp) as slave:
        path = project(tcp(["name: V, register: 0, " + VERIFIED], slave.port))
        with start("run", path, "--stdin") as run:
            run.send("write V 50")
            run.wait_line(lambda line: line == "refused V differs written 50 read 40", "the answer")
            run.wait_line(lambda line: "V: 50 was written, 40 was read back" in line, "the news")
            run.interrupt()
