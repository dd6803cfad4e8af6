"""Devices on the page: probes on request, learnt gaps, registers of the wire, scans and their way into the
project, ages."""
import json
import socket
import time

import pytest

from api_schema import check_event
from fake_slave import TcpSlave
from program import WITHOUT_WAITING, start, until
from web_site import Site

LEARNING = """\
takt: 1
lines:
  - name: net
    transport: tcp
    host: 127.0.0.1
    tcp_port: {port}
    framing: tcp
    devices:
      - name: Meter
        address: 1
        poll_period: 50ms
        response_timeout: 2s
        attempts: 1
        backoff: 1h
        strategy: optimal
        gaps: learn
        variables:
          - {{name: A, type: uint16, register: 0, read: 0x03}}
          - {{name: B, type: uint16, register: 3, read: 0x03}}
          - {{name: C, type: uint16, register: 8, read: 0x03, scale: 0.1}}
          - {{name: D, type: float, register: 10, read: 0x03}}
"""


class Meter:
    """A TCP device with registers that refuses reads across `hole`, and can be silent."""

    def __init__(self, hole=()):
        self.registers = {i: 1000 + i for i in range(20)}
        self.silent = False
        self.hole = set(hole)
        self.seen, self.answered_at = [], []
        self.slave = TcpSlave(self.answers)

    def answers(self, adu):
        unit, pdu = adu[6], adu[7:]
        self.seen.append((unit, pdu.hex()))
        if self.silent or unit != 1:
            return None
        if pdu[0] != 3:
            return adu[:4] + bytes([0, 3, unit, pdu[0] | 0x80, 1])
        first, count = int.from_bytes(pdu[1:3], "big"), int.from_bytes(pdu[3:5], "big")
        wanted = range(first, first + count)
        if any(i in self.hole or i not in self.registers for i in wanted):
            return adu[:4] + bytes([0, 3, unit, 0x83, 2])
        self.answered_at.append(time.time() * 1000)
        data = b"".join(self.registers[i].to_bytes(2, "big") for i in wanted)
        return adu[:4] + (3 + len(data)).to_bytes(2, "big") + bytes([unit, 3, len(data)]) + data


def get(site, path):
    status, text = site.get(f"/api/v1{path}")
    assert status == 200, text
    return json.loads(text)


def post(site, path, body, status=200):
    got, text = site.post(path, body)
    assert got == status, text
    return json.loads(text)


@pytest.fixture
def meter():
    made = Meter(hole=[5])
    with made.slave:
        yield made


@pytest.fixture
def site(meter, tmp_path):
    path = tmp_path / "plant.yaml"
    path.write_text(LEARNING.format(port=meter.slave.port))
    with start("run", path, "--json", "--web", "127.0.0.1:0", "--allow-write") as run:
        run.wait_event(lambda e: e["event"] == "value" and e["quality"] == "good", "a value")
        site = Site(run)
        site.run = run
        site.file = path
        yield site


def device(site):
    return get(site, "/status")["lines"][0]["devices"][0]


def test_a_device_that_does_not_answer_is_tried_now(site, meter):
    assert post(site, "/devices/probe", {"line": "net", "device": "Meter"})["outcome"] == "refused"
    meter.silent = True
    until(lambda: device(site)["state"] == "not_answering", "the silence of the device")
    until(lambda: (device(site)["back_off"] or {}).get("pause_ms", 0) >= 1000, "a back-off")
    assert device(site)["back_off"]["next_probe_ms"] <= device(site)["back_off"]["pause_ms"]
    meter.silent = False
    assert post(site, "/devices/probe", {"line": "net", "device": "Meter"})["outcome"] in ("done", "refused")
    until(lambda: device(site)["state"] == "answering", "an answer to the probe")
    assert device(site)["back_off"] is None
    assert post(site, "/devices/probe", {"line": "net", "device": "Nobody"}, 404)["error"]["code"] == "device"


def test_learnt_gaps_are_those_that_the_device_answers_and_refuses(site):

    def learnt():
        lines = get(site, "/devices/learnt")["lines"]
        assert lines[0]["name"] == "net" and lines[0]["learns"]
        its = [g for g in lines[0]["learnt"] if g["function"] == 3]
        return its[0] if its and its[0]["refused"] else None

    its = until(learnt, "a refused gap")
    assert any(r["first"] <= 1 and r["last"] >= 2 for r in its["confirmed"]), its
    refused = its["refused"][0]
    assert refused["first"] <= 5 <= refused["last"] and refused["exception"] == 2, its


def test_registers_are_those_of_the_wire(site, meter):
    path = "/registers?variable=C&variable=D"

    def known():
        its = get(site, path)["registers"]
        return its if all(x["items"] for x in its) else None

    its = until(known, "registers")
    assert [x["variable"] for x in its] == ["C", "D"]
    assert its[0]["items"] == [1008] and its[1]["items"] == [1010, 1011]
    assert its[0]["function"] == 3 and not its[0]["bits"]
    meter.registers[8] = 4242
    until(lambda: get(site, path)["registers"][0]["items"] == [4242], "the new register")
    assert site.get("/api/v1/registers?variable=Nothing")[0] == 404


def test_ages_of_values_that_stay_the_same_are_right(site, meter):
    """The instant of the last good read that a browser knows is never older than 0.2 s and a period. The
    reads that the device has answered since are counted: they stand still where the machine does. A period
    has up to three."""
    sampled_at, seen, missed = {}, 0, []
    with site.connect() as s:
        s.sendall(f"GET /api/v1/stream HTTP/1.1\r\nHost: 127.0.0.1:{site.port}\r\n\r\n".encode())
        buffer = b""
        while seen < 40:
            got = s.recv(65536)
            assert got, "the stream goes on"
            buffer += got
            *events, buffer = buffer.split(b"\n\n")
            for event in events:
                name, _, data = event.partition(b"\ndata: ")
                name = name.rpartition(b"event: ")[2]
                check_event(name.decode(), json.loads(data))
                if name not in (b"snapshot", b"values", b"reads"):
                    continue
                body = json.loads(data)
                if name == b"snapshot":
                    names = [v["name"] for v in body["values"]]
                    sampled_at = {i: v["sampled_at"] for i, v in enumerate(body["values"])}
                elif name == b"values":
                    sampled_at.update({row[0]: row[5] for row in body["values"]})
                else:
                    seen += 1
                    for at, first, last in body["reads"]:
                        sampled_at.update(dict.fromkeys(range(first, last + 1), at))
                    oldest = min(sampled_at[names.index(n)] for n in "ABCD")
                    missed.append(sum(answered > oldest for answered in meter.answered_at[-100:]))
    missed.sort()
    assert missed[len(missed) * 9 // 10] <= 3 * 250 / 50, missed


def wait_for_end(site):
    return until(lambda: s if not (s := get(site, "/search"))["running"] else None, "the end of the search")


def test_a_scan_of_hosts_becomes_a_device_of_the_project(site, meter):
    other = Meter()
    with other.slave:
        target = f"tcp://127.0.0.1:{other.slave.port}"
        state = post(site, "/search/scan", {"targets": [target], "units": "1-3", "timeout_ms": 500})
        assert state["kind"] == "scan" and state["id"] == 1
        state = wait_for_end(site)
        assert [d["unit"] for d in state["devices"]] == [1], state
        found = state["devices"][0]
        assert found["target"] == target and found["known_as"] is None and found["line"] is None
        assert found["line_node"]["host"] == "127.0.0.1" and "$from" not in json.dumps(found)
        # The registers that a probe finds become variables of the device.
        assert found["device_node"]["address"] == "1"
        post(site, "/search/probe", {"target": target, "unit": 1, "timeout_ms": 5000, "to": 200})
        state = wait_for_end(site)
        assert state["kind"] == "probe" and not state["error"], state["error"]
        assert "holding_register 0..19" in state["probed"][0]["text"]
        found = state["devices"][0]
        assert len(found["device_node"]["variables"]) == 20 and "readable" in found["device_node"]
        project = get(site, "/project")
        document = project["document"]
        document["lines"].append({**found["line_node"], "name": "found", "devices": [found["device_node"]]})
        status, text = site.send(
            "\r\n".join([
                "PUT /api/v1/project HTTP/1.1", f"Host: 127.0.0.1:{site.port}", "X-Takt: 1",
                "Content-Type: application/json", "Content-Length: " + str(
                    len(body := json.dumps({
                        "document": document,
                        "revision": project["revision"],
                        "apply": True
                    })))
            ]), body)
        assert status == 200, text
        until(lambda: len(get(site, "/status")["lines"]) == 2, "the new line")
        assert get(site, "/search")["devices"][0]["known_as"] == found["device_node"]["name"]


def test_a_polled_line_is_scanned_beside_polling(site, meter):
    before = len(site.run.out)
    post(site, "/search/scan", {"targets": ["line:net"], "units": "1-4", "timeout_ms": 500})
    state = wait_for_end(site)
    assert [(d["unit"], d["line"], d["known_as"]) for d in state["devices"]] == [(1, "net", "Meter")], state
    assert not state["troubles"], state
    assert device(site)["state"] == "answering"
    assert {unit for unit, _ in meter.seen} == {1, 2, 3, 4}
    post(site, "/search/probe", {"target": "line:net", "unit": 1, "to": 50})
    state = wait_for_end(site)
    assert not state["error"], state["error"]
    assert "holding_register 0..4" in state["probed"][0]["text"], state["probed"]
    assert state["probed"][0]["known_as"] == "Meter" and state["probed"][0]["keys"]["readable"]
    assert before <= len(site.run.out)


@pytest.mark.parametrize("spare", [False, True])
def test_a_simulated_line_is_scanned(tmp_path, spare):
    path = tmp_path / "demo.yaml"
    path.write_text("""\
takt: 1
lines:
  - name: bus
    transport: simulated
    framing: rtu
    baud: 115200
    devices:
      - {name: Boiler, address: 16, poll_period: 200ms, response_timeout: 50ms, variables: [
          {name: L, type: uint16, register: 0, read: 0x03}]}
""")
    with start("run", path, "--json", "--web", "127.0.0.1:0", "--allow-write") as run:
        site = Site(run)
        post(site, "/search/scan", {
            "targets": ["line:bus"],
            "units": "14-18",
            "timeout_ms": 50,
            "spare": spare
        })
        assert [d["unit"] for d in wait_for_end(site)["devices"]] == [16]
        post(site, "/search/probe", {"target": "line:bus", "unit": 16, "to": 9, "spare": spare})
        assert not wait_for_end(site)["error"]


def test_a_search_in_spare_time_ends_where_the_line_has_none(site, meter):
    """A time-out of 500 ms does not fit between polled requests each 50 ms."""
    post(site, "/search/scan", {"targets": ["line:net"], "units": "2", "timeout_ms": 500, "spare": True})
    state = wait_for_end(site)
    assert state["devices"] == [] and state["troubles"], state
    assert {unit for unit, _ in meter.seen} == {1}


def test_a_search_is_cancelled_and_one_at_a_time(site):
    silent = TcpSlave()
    with silent:
        target = f"tcp://127.0.0.1:{silent.port}"
        post(site, "/search/scan", {"targets": [target], "timeout_ms": 1000})
        assert post(site, "/search/scan", {"targets": [target]}, 409)["error"]["code"] == "busy"
        assert post(site, "/search/probe", {"target": target, "unit": 1}, 409)["error"]["code"] == "busy"
        until(lambda: get(site, "/search")["total"] > 0, "progress")
        post(site, "/search/cancel", {})
        state = wait_for_end(site)
        assert state["cancelled"] and state["devices"] == []
        post(site, "/search/scan", {"targets": [target], "units": "1", "timeout_ms": 50})
        assert not wait_for_end(site)["cancelled"]


def test_the_run_ends_during_a_search(site):
    silent = TcpSlave()
    with silent:
        post(site, "/search/scan", {"targets": [f"tcp://127.0.0.1:{silent.port}"], "timeout_ms": 10000})
        site.run.interrupt(deadline=WITHOUT_WAITING)


@pytest.mark.parametrize("path,body,status,code", [
    ("/search/scan", {
        "targets": []
    }, 400, "body"),
    ("/search/scan", {
        "targets": ["10.0.0.1"]
    }, 422, "syntax"),
    ("/search/scan", {
        "targets": ["tcp://10.0.0.1"],
        "units": "0-256"
    }, 422, "out_of_range"),
    ("/search/scan", {
        "targets": ["tcp://10.0.0.0/20"]
    }, 422, "too_large"),
    ("/search/scan", {
        "targets": ["tcp://10.0.0.1"],
        "timeout_ms": 1
    }, 422, "out_of_range"),
    ("/search/scan", {
        "targets": ["rtu:///etc/passwd"]
    }, 422, "port"),
    ("/search/scan", {
        "targets": ["rtu:///dev/tty/../watchdog"]
    }, 422, "port"),
    ("/search/scan", {
        "targets": ["line:none"]
    }, 404, "line"),
    ("/search/probe", {
        "target": "tcp://10.0.0.1",
        "unit": 256
    }, 422, "out_of_range"),
    ("/search/probe", {
        "target": "tcp://10.0.0.1"
    }, 400, "body"),
    ("/search/probe", {
        "target": "tcp://10.0.0.1",
        "unit": 1,
        "from": 9,
        "to": 5
    }, 422, "out_of_range"),
    ("/search/probe", {
        "target": "tcp://10.0.0.1",
        "unit": 1,
        "max_requests": 0
    }, 422, "out_of_range"),
])
def test_wrong_searches_are_refused(site, path, body, status, code):
    assert post(site, path, body, status)["error"]["code"] == code


def test_an_endpoint_in_use_is_scanned_through_its_line_only(site, meter):
    target = f"tcp://127.0.0.1:{meter.slave.port}"
    answer = post(site, "/search/scan", {"targets": [target]}, 409)
    assert answer["error"]["code"] == "in_use" and "net" in answer["error"]["text"]


def test_searches_need_allow_write(tmp_path, meter):
    path = tmp_path / "plant.yaml"
    path.write_text(LEARNING.format(port=meter.slave.port))
    with start("run", path, "--json", "--web", "127.0.0.1:0") as run:
        site = Site(run)
        assert post(site, "/search/scan", {"targets": ["tcp://127.0.0.1:1"]},
                    403)["error"]["code"] == "read_only"
        assert get(site, "/search")["kind"] == "none"


def test_thousands_of_idle_connections_give_way(site):
    idle = []
    for _ in range(3000):
        s = socket.socket()
        s.connect(("127.0.0.1", site.port))
        idle.append(s)

    def answered():
        try:
            return site.get("/api/v1/info")[0] == 200
        except (ConnectionError,
                IndexError):  # closed at once: none of the others has been idle for long enough
            return False

    until(answered, "an answer")
    for _ in range(20):
        assert site.get("/api/v1/info")[0] == 200
    for s in idle:
        s.close()
