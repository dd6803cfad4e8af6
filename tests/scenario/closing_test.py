"""docs/commands/run.md, "Lines and connections": devices that close their TCP connections."""
import socket
import time
from collections import Counter

import pytest

from fake_slave import Device, TcpSlave, tcp_answer
from program import start, takt, until

PERIOD = 0.3  # seconds
LEAST = 8  # reads of each register before a test looks at the counts


def line(slave, devices, keys="", name="net"):
    """A line to that slave; `devices`: {unit: registers}."""
    text = [f"  - name: {name}", "    host: 127.0.0.1", f"    tcp_port: {slave.port}"]
    text += [f"    {key}" for key in keys.split("\n") if key] + ["    devices:"]
    for unit, registers in devices.items():
        variables = ", ".join(f"{{name: V{unit}_{r}, type: uint16, register: {r}, read: 0x03}}"
                              for r in registers)
        text.append(
            f"      - {{name: D{unit}, address: {unit}, poll_period: {PERIOD}s, response_timeout: 2s, "
            f"variables: [{variables}]}}")
    return "\n".join(text) + "\n"


def lines(*described):
    return "takt: 1\nlines:\n" + "".join(described)


class Polled:
    """Counts the requests that a slave received, by unit and register."""

    def __init__(self, answer):
        self.seen, self._answer, self._device = Counter(), answer, Device(
            {r: r & 0xFFFF
             for r in range(65536)})

    def __call__(self, adu):
        self.seen[adu[6], int.from_bytes(adu[8:10], "big")] += 1
        return self._answer(adu, self._device.over_tcp(adu))


def fell(events):
    """The variables that were good and ceased to be."""
    good, found = set(), set()
    for event in events:
        if event["event"] != "value":
            continue
        if event["quality"] == "good":
            good.add(event["name"])
        elif event["name"] in good:
            found.add(event["name"])
    return found


def run(project, text, polled, wanted):
    """Runs until each of the wanted reads was received LEAST times. @returns the events, and the seconds"""
    path = project(text)
    begun = time.monotonic()
    with start("run", path, "--json") as running:
        until(lambda: all(polled.seen[key] >= LEAST for key in wanted), f"all of {wanted} are read")
        lasted = time.monotonic() - begun
        running.interrupt()
        return running.events(), lasted


def test_a_device_that_closes_after_each_response_is_read_once_a_period(project):
    polled = Polled(lambda adu, response: (response, "close"))
    with TcpSlave(polled) as slave:
        events, lasted = run(project, lines(line(slave, {1: [100, 900, 1900]})), polled, [(1, 100), (1, 900),
                                                                                          (1, 1900)])
    assert max(polled.seen.values()) <= lasted / PERIOD + 2
    assert not fell(events)
    device = events[-1]["lines"][0]["devices"][0]
    assert device["outages"] == 0


def test_a_dead_unit_behind_a_gateway_that_closes_costs_the_others_nothing(project):
    polled = Polled(lambda adu, response: "close" if adu[6] == 2 else response)
    with TcpSlave(polled) as slave:
        events, lasted = run(project, lines(line(slave, {unit: [100]
                                                         for unit in (1, 2, 3)})), polled, [(1, 100),
                                                                                            (3, 100)])
    assert polled.seen[2, 100] <= LEAST, "probed with a back-off"
    assert fell(events) <= {"V2_100"}
    states = {d["name"]: d["state"] for d in events[-1]["lines"][0]["devices"]}
    assert states == {"D1": "answering", "D2": "not_answering", "D3": "answering"}
    reasons = {e["reason"] for e in events if e["event"] == "value" and e["name"] == "V2_100"}
    assert "closed" in reasons


@pytest.mark.parametrize("surplus", [b"", b"\0"])
def test_a_length_that_is_one_too_large_is_accepted_where_the_line_allows_it(project, surplus):

    def answer(adu, response):
        if int.from_bytes(adu[8:10], "big") != 39000:
            return response
        wrong = bytearray(tcp_answer(adu, "83 02"))
        wrong[5] += 1
        return bytes(wrong) + surplus

    polled = Polled(answer)
    with TcpSlave(polled) as slave:
        described = line(slave, {1: [100, 39000, 45000]}, "length_tolerance: true")
        events, _ = run(project, lines(described), polled, [(1, 100), (1, 39000), (1, 45000)])
        assert len(slave.accepted) == 1
        result = takt("read", f"tcp://127.0.0.1:{slave.port}", "holding", "39000", code=5)
        assert "exception 2" in result.err
        assert "length_tolerance: true" in result.err
    shown = {e["name"]: e for e in events if e["event"] == "value"}
    assert shown["V1_39000"]["quality"] == "bad" and shown["V1_39000"]["reason"] == "exception 2"
    assert shown["V1_45000"]["quality"] == "good"


def test_other_reads_go_on_beside_one_whose_responses_break_the_stream(project):

    def answer(adu, response):
        return response[:-1] if int.from_bytes(adu[8:10], "big") == 900 else response

    polled = Polled(answer)
    with TcpSlave(polled) as slave:
        described = line(slave, {
            1: [100, 900, 1900]
        }).replace("response_timeout: 2s", "response_timeout: 100ms")
        events, _ = run(project, lines(described), polled, [(1, 100), (1, 1900)])
    # Their values may be older than proved for a moment, and are never lost.
    shown = {e["name"] for e in events if e["event"] == "value" and e["quality"] == "bad"}
    assert shown <= {"V1_900"}


@pytest.mark.parametrize("off, surplus", [(-1, b""), (1, b"\0")])
def test_a_length_that_is_off_costs_only_its_read_and_check_proposes_the_key(project, off, surplus):

    def answer(adu, response):
        if adu[6] != 1 or int.from_bytes(adu[8:10], "big") != 900:
            return response
        wrong = bytearray(response)
        wrong[5] += off
        return bytes(wrong) + surplus

    polled = Polled(answer)
    with TcpSlave(polled) as slave:
        described = lines(line(slave, {1: [100, 900, 1900], 2: [100]}))
        events, lasted = run(project, described, polled, [(1, 100), (1, 1900), (2, 100)])
    assert not fell(events)
    assert polled.seen[1, 900] <= lasted / PERIOD + 3

    def warned(text):
        found = takt("check", project(text), "--json").json["findings"]
        return [(f["code"], f["path"]) for f in found if f["severity"] == "warning"]

    assert warned(described) == [("learnt.lengths_off", "lines[0]")]
    tolerant = described.replace("    devices:", "    length_tolerance: true\n    devices:", 1)
    assert not warned(tolerant)


@pytest.mark.parametrize("keys, least, most",
                         [("connection: per_request", 2 * LEAST, 3 * LEAST + 6),
                          ("connection: per_cycle", LEAST - 1, 2 * LEAST + 6),
                          ("connection: on_demand\nidle_close: 0.1s", LEAST - 1, LEAST + 6),
                          ("connection: on_demand\nidle_close: 60s", 1, 1)])
def test_the_line_closes_its_connection_as_it_is_told(project, keys, least, most):
    polled = Polled(lambda adu, response: response)
    with TcpSlave(polled) as slave:
        events, _ = run(project, lines(line(slave, {1: [100, 900]}, keys)), polled, [(1, 100), (1, 900)])
        assert least <= len(slave.accepted) <= most
    assert not fell(events)


def test_the_first_request_waits_after_connecting(project):
    first = []

    def answer(adu, response):
        first.append(time.monotonic())
        return response

    polled = Polled(answer)
    with TcpSlave(polled) as slave:
        run(project, lines(line(slave, {1: [100]}, "pause_after_connect: 400ms")), polled, [(1, 100)])
        assert first[0] - slave.accepted[0] >= 0.39


def test_two_lines_share_the_only_connection_of_a_host(project):
    peers, counts = [], []

    def is_open(peer):
        try:
            return peer.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT) != b""
        except BlockingIOError:
            return True
        except OSError:
            return False

    class Single(TcpSlave):

        def _serve(self, peer):
            peers.append(peer)
            counts.append(sum(is_open(each) for each in list(peers)))
            super()._serve(peer)

    polled = Polled(lambda adu, response: response)
    with Single(polled) as slave:
        text = lines(*(line(slave, {unit: [100]}, "connections_per_host: 1", f"net{unit}")
                       for unit in (1, 2)))
        events, _ = run(project, text, polled, [(1, 100), (2, 100)])
    assert max(counts) <= 2, "the one that is being closed, and the next one"
    assert not fell(events)


def test_one_off_commands_go_on_with_a_new_connection():
    device = Device({r: r for r in range(400)})
    with TcpSlave(lambda adu: (device.over_tcp(adu), "close")) as slave:
        result = takt("read", f"tcp://127.0.0.1:{slave.port}", "holding", "0", "300", "--json")
        assert len(result.json["values"]) == 300


def test_a_probe_finds_the_ranges_of_a_device_that_closes_at_missing_registers():
    there = {*range(10, 20), *range(100, 105)}

    def answer(adu):
        start_, count = int.from_bytes(adu[8:10], "big"), int.from_bytes(adu[10:12], "big")
        if adu[7] != 3 or not there.issuperset(range(start_, start_ + count)):
            return "close"
        return Device().over_tcp(adu)

    with TcpSlave(answer) as slave:
        result = takt("probe", f"tcp://127.0.0.1:{slave.port}", "--area", "holding", "--to", "150", "--yaml")
        assert "10..19" in result.out and "100..104" in result.out
