"""takt listen on a bus with foreign masters, libmodbus and pymodbus, against the record of the bus itself."""
import contextlib
import datetime
import json
import re
import statistics
import time

import pytest

from captures import packets_in
from frames import pcap
from program import start, takt, until
from serial_bus import Bus, LibmodbusMaster, PymodbusMaster, frame

PROJECT = """takt: 1
lines:
  - name: rs485
    transport: serial
    port: /dev/takt-none
    devices:
      - name: Boiler
        address: 1
        variables:
          - {name: Level, type: uint16, register: 1, read: 0x03, unit: mm}
          - {name: Flow, type: uint16, register: 3, read: 0x03, scale: 0.1}
          - {name: Setpoint, type: uint16, register: 20, read: 0x03, write: 0x06}
      - name: Pump
        address: 2
        variables: []
"""


class Listening:
    """takt listen on the port "listener" of a bus. A context; `finish()` sends Ctrl-C."""

    def __init__(self, bus, *options, settings="rtu://{}?baud=115200&parity=none"):
        self.program = start("listen", settings.format(bus.ports["listener"]), *options)
        until(lambda: self.program.catches(2), "the handler of signals")
        self.bus = bus

    def __enter__(self):
        self.program.__enter__()
        return self

    def __exit__(self, *stop):
        self.program.__exit__(*stop)

    def said(self):
        """The values and the device of a project were printed."""
        text = "\n".join(self.program.out)
        return "Setpoint = " in text and "Level = " in text and "Pump: unit 2" in text

    def events(self, kind):
        return [e for e in self.program.events() if e["event"] == kind]

    def finish(self, code=0):
        result = self.program.interrupt(code=code)
        assert self.bus.sent_by["listener"] == b"", "a third party sends nothing"
        return result


def hear_two_masters(cycles, *options):
    """Both masters work for that many cycles; the bus, and what was heard."""
    with Bus(["one", "two", "listener"]) as bus, Listening(bus, *options) as listening:
        with LibmodbusMaster(bus.ports["one"], 0.6, [(1, 0, 4), (2, 10, 2)]) as one, \
                LibmodbusMaster(bus.ports["two"], 0.8, [(3, 0, 10)], [(1, 20)]) as two:
            until(lambda: one.cycles >= cycles and two.cycles >= cycles, "the cycles of both masters")
        last = len(bus.answers)
        until(lambda: len(listening.events("exchange")) >= last
              if "--json" in options else listening.said(), "the last exchange")
        return bus, listening.finish()


def cycle_of(bus, unit, pdu_begins):
    """How many ms lie between two of a master's requests, by the record of the bus."""
    times = [t for t, u, pdu in bus.asked_at if u == unit and pdu.startswith(pdu_begins)]
    return 1000 * statistics.median(b - a for a, b in zip(times, times[1:]))


def hex_of(pdu):
    return pdu.hex(" ").upper()


def test_every_exchange_of_two_masters_is_heard(tmp_path):
    project = tmp_path / "heard.yaml"
    bus, result = hear_two_masters(24, "--json", "--timeout", "10s", "--write", project)
    lines = [json.loads(line) for line in result.lines]
    exchanges = [e for e in lines if e["event"] == "exchange"]
    heard = sorted((e["unit"], e["request"], e["response"]) for e in exchanges)
    assert heard == sorted((unit, hex_of(pdu), hex_of(reply)) for unit, pdu, reply in bus.answers)
    assert not [e for e in lines if e["event"] in ("stray", "damaged")]
    # What the listener measures has the delays of its own process too, so medians are compared.
    took = 1000 * statistics.median(bus.response_times)
    assert took >= 4 and took / 3 < statistics.median(e["response_ms"] for e in exchanges) < 3 * took + 10

    summary = lines[-1]
    assert summary["requests"] == summary["answered"] == len(bus.answers)
    masters = [sorted((p["unit"], p["function"], p["start"]) for p in m["polls"]) for m in summary["masters"]]
    assert sorted(masters) == [[(1, 3, 0), (2, 3, 10)], [(1, 6, 20), (3, 3, 0)]]
    cycles = sorted(m["cycle_ms"] for m in summary["masters"])
    one, two = (cycle_of(bus, unit, b"\x03\0\0") for unit in (1, 3))
    assert cycles == [pytest.approx(one, rel=0.1), pytest.approx(two, rel=0.1)]

    text = project.read_text()
    assert takt("check", project).code == 0, text
    plan = takt("plan", project, "--json").json
    requests = {(r["device"], r["function"], r["start"], r["quantity"]) for r in plan["lines"][0]["requests"]}
    assert {("unit 1", 3, 0, 4), ("unit 2", 3, 10, 2), ("unit 3", 3, 0, 10)} <= requests
    periods = sorted(int(number) for number in re.findall(r"poll_period: (\d+)ms", text))
    assert periods == [pytest.approx(one, rel=0.1)] * 2 + [pytest.approx(two, rel=0.1)]
    assert "{name: unit1_holding_20, type: uint16, register: 20, write: 0x06}" in text


def test_the_names_of_a_project(project):
    _, result = hear_two_masters(4, "--project", project(PROJECT))
    assert any("Boiler: unit 1 read holding registers 0..3 → 4 values: 0 1 2 3; " in line
               and line.endswith("Level = 1 mm, Flow = 0.3") for line in result.lines), result
    assert any("Setpoint = " in line for line in result.lines)
    assert any("Pump: unit 2" in line for line in result.lines)
    assert any(line.split()[:2] == ["1", "Boiler"] for line in result.lines), "the table of devices"


@pytest.mark.parametrize("framing", ["rtu", "ascii"])
def test_the_framing_is_found(framing):
    with Bus(["master", "listener"], framing=framing) as bus, Listening(bus, "--json",
                                                                        settings="{}") as listening:
        port, reads = bus.ports["master"], [(1, 0, 4)]
        with LibmodbusMaster(port, 0.05, reads) if framing == "rtu" else PymodbusMaster(
                port, 0.05, reads, framing) as master:
            until(lambda: len(listening.events("exchange")) >= 5, "exchanges")
            assert master.cycles >= 5
        result = listening.finish()
    assert f"{framing.upper()}; characters needed" in result.err
    answered = [e for e in listening.events("exchange") if (e["unit"], e["outcome"]) == (1, "answered")]
    assert len(answered) >= 4
    assert json.loads(result.lines[-1])["framing"] == framing


def test_silent_devices_and_damage():
    with Bus(["master", "listener"], units=(1, )) as bus, Listening(bus, "--json", "--timeout",
                                                                    "800ms") as listening:
        with PymodbusMaster(bus.ports["master"], 0.5, [(1, 0, 4), (9, 0, 1), (1, 99, 2)]) as master:
            until(lambda: master.cycles >= 4, "cycles")
        heard = len(bus.answers)
        until(lambda: len(listening.events("exchange")) >= heard, "the last exchange")
        for number, bad in enumerate((frame("rtu", 1, b"\x03\x02\0\0")[:-1] + b"\0", b"\x01\x03"), 1):
            bus.send(bad)
            until(lambda n=number: len(listening.events("damaged")) == n, "the damaged bytes")
        bus.send(frame("rtu", 1, b"\x03\x02\0\0"))
        until(lambda: listening.events("stray"), "the response without a request")
        summary = json.loads(listening.finish().lines[-1])
    devices = {d["unit"]: d for d in summary["devices"]}
    assert devices[9]["silent"] and devices[9]["answered"] == 0 and devices[9]["unanswered"] >= 3
    assert not devices[1]["silent"] and devices[1]["exceptions"] == {"2": master.cycles}
    assert summary["damaged"] == 2 and summary["strays"] == 1


def test_frames_of_a_capture(tmp_path):
    exchange = [frame("rtu", 5, b"\x03\0\0\0\x01"), frame("rtu", 5, b"\x03\x02\0\x07")]
    path = tmp_path / "line.pcap"
    path.write_bytes(pcap(147, exchange * 5))
    result = takt("listen", path, "--json", "--write", tmp_path / "heard.yaml")
    lines = [json.loads(line) for line in result.lines]
    assert [e["response_ms"] for e in lines[:-1]] == [1.0] * 5
    assert lines[-1]["baud"] is None and lines[-1]["devices"][0]["unit"] == 5
    assert takt("check", tmp_path / "heard.yaml").code == 0


CAPTURED = """takt: 1
lines:
  - {name: dead, transport: tcp, host: 127.0.0.1, tcp_port: 1, devices: [
      {name: Dead, address: 1, variables: [{name: x, type: int, register: 0, read: 0x03}]}]}
  - name: rs485
    transport: simulated
    framing: FRAMING
    devices:
      - name: Boiler
        address: 5
        poll_period: 50ms
        turnaround: 4ms
        variables: [{name: Level, type: uint16, register: 1, read: 0x03, write: 0x06}]
"""


def frames_of(capture, device):
    """How many frames a capture has so far, by their comments."""
    return capture.read_bytes().count(device + b" | ") if capture.exists() else 0


def median_gap(exchanges):
    """The median of the ms between the reads."""
    times = [datetime.datetime.fromisoformat(e["time"]) for e in exchanges if e["function"] == 3]
    return statistics.median((b - a).total_seconds() * 1000 for a, b in zip(times, times[1:]))


@pytest.mark.parametrize("framing", ["rtu", "ascii"])
def test_a_capture_of_takt_run(tmp_path, project, framing):
    capture, plant, heard = tmp_path / "run.pcapng", project(CAPTURED.replace(
        "FRAMING", framing)), tmp_path / "heard.yaml"
    with start("run", plant, "--stdin", "--json", "--capture", capture) as run:
        run.wait_event(lambda e: e.get("name") == "Level", "a value")
        run.send("write Level 7")
        run.wait_event(lambda e: e.get("outcome") == "done", "the outcome of the write")
        until(lambda: frames_of(capture, b"Boiler") >= 50, "25 exchanges")
        run.send("quit")
        run.finish()
    result = takt("listen", capture, "--json", "--project", plant, "--write", heard)
    lines = [json.loads(line) for line in result.lines]
    answered = [e for e in lines if e["event"] == "exchange" and e["outcome"] == "answered"]
    assert {(e["device"], e["unit"], e["function"]) for e in answered} == {("Boiler", 5, 3), ("Boiler", 5, 6)}
    longest = takt("latency", capture, "--json", code=None).json["total"]["max_ms"]
    assert all(4 < e["response_ms"] <= longest + 0.01 and "Level" in e["values"] for e in answered)
    assert lines[-1]["framing"] == framing and lines[-1]["answered"] == len(answered) > 5
    assert (lines[-1]["damaged"], lines[-1]["strays"]) == (0, 0)
    assert takt("check", heard).code == 0
    period = int(re.search(r"poll_period: (\d+)ms", heard.read_text())[1])
    assert period == pytest.approx(median_gap(answered), rel=0.25), "50 ms, where the machine is not busy"


def test_all_lines_of_a_capture_are_heard(tmp_path, project):
    capture, heard = tmp_path / "run.pcapng", tmp_path / "heard.yaml"
    line = CAPTURED.replace("FRAMING", "rtu").split("\n", 4)[4]
    other = line.replace("rs485",
                         "other").replace("rtu",
                                          "ascii").replace("Boiler",
                                                           "Pump").replace("Level",
                                                                           "Speed").replace("50ms", "30ms")
    plant = project("takt: 1\nlines:\n" + line + other)
    with start("run", plant, "--quiet", "--capture", capture) as run:
        until(lambda: min(frames_of(capture, name) for name in (b"Boiler", b"Pump")) >= 50,
              "25 exchanges on each line")
        run.interrupt()
    result = takt("listen", capture, "--json", "--project", plant, "--write", heard)
    lines = [json.loads(text) for text in result.lines]
    summaries = {s["line"]: s for s in lines if s["event"] == "summary"}
    assert {name: s["framing"] for name, s in summaries.items()} == {"rs485": "rtu", "other": "ascii"}
    for name, device in (("rs485", "Boiler"), ("other", "Pump")):
        exchanges = [e for e in lines if e["event"] == "exchange" and e["line"] == name]
        assert {e["device"]
                for e in exchanges} == {device} and len(exchanges) == summaries[name]["requests"] > 20
        assert summaries[name]["answered"] >= summaries[name]["requests"] - 1
    assert takt("check", heard).code == 0
    assert "# rs485" in heard.read_text() and "# other" in heard.read_text()
    text = takt("listen", capture, "--quiet").out
    assert "run.pcapng, line rs485: RTU" in text and "run.pcapng, line other: ASCII" in text
    named = takt("listen", capture).lines
    assert any("  rs485  unit 5 read" in each for each in named) and any("  other  unit 5 read" in each
                                                                         for each in named)


def test_a_capture_of_takt_capture(tmp_path):
    capture = tmp_path / "line.pcapng"
    with Bus(["master", "listener"]) as bus, start("capture", f"rtu://{bus.ports['listener']}?baud=115200",
                                                   "-o", capture) as listener:
        until(lambda: any("listening on" in text for text in listener.err), "listening")
        with LibmodbusMaster(bus.ports["master"], 0.1, [(1, 0, 4)], [(2, 20)]) as master:
            until(lambda: master.cycles >= 10, "cycles")
        until(lambda: packets_in(capture) >= len(bus.frames), "the last frame")
        bus.send(b"\x01\x03\x55\xAA")
        until(lambda: b"dropped: " in capture.read_bytes(), "the damaged bytes")
        listener.interrupt()
    summary = json.loads(takt("listen", capture, "--json").lines[-1])
    assert summary["answered"] == summary["requests"] == len(bus.answers)
    assert summary["damaged"] == 1
    cycles = master.cycles
    assert sorted((d["unit"], d["answered"]) for d in summary["devices"]) == [(1, cycles), (2, cycles)]


@pytest.mark.parametrize("link, code, words", [(101, 1, "no packet has a frame of a serial line"),
                                               (252, 6, "frames with a good checksum: none"),
                                               (None, 2, "not a capture")])
def test_a_capture_without_serial_frames(tmp_path, link, code, words):
    path = tmp_path / "other.pcap"
    data = bytes.fromhex("000c0004") + b"data" + bytes(4) + b"\x01\x03"
    path.write_bytes(pcap(link, [data]) if link else b"This is text, not packets.")
    result = takt("listen", path, code=code)
    assert words in result.err and str(path) in result.err, result


def test_exit_codes(tmp_path, project):
    with Bus(["listener"]) as bus:
        port = bus.ports["listener"]
        assert "nothing was received" in takt("listen", port, "--for", "100ms", code=1).err
        with Listening(bus) as listening:

            def heard():  # what comes before the port is open is lost
                bus.send(b"\x01\x03\x55\xAA")
                time.sleep(0.2)
                return any("damaged, bytes: 4: 01 03 55 AA" in line for line in listening.program.out)

            until(heard, "the bytes")
            assert "no" in listening.finish(code=6).err
        assert "error" in takt("listen", port, "--project", project("takt: 2\n"), code=2).err
        assert "no serial line" in takt(
            "listen", port, "--project",
            project("takt: 1\nlines: [{name: net, transport: tcp, host: 127.0.0.1, devices: [\n"
                    "  {name: D, address: 1, variables: []}]}]\n"), code=2).err
    takt("listen", "/dev/takt-none", code=3)
    takt("listen", "tcp://127.0.0.1", code=2)
    unwritable = tmp_path / "there.yaml"
    unwritable.write_text("mine")
    path = tmp_path / "line.pcap"
    path.write_bytes(pcap(147, [frame("rtu", 5, b"\x03\0\0\0\x01")]))
    takt("listen", path, "--write", unwritable, code=2)
    takt("listen", path, "--write", tmp_path / "no-folder/heard.yaml", code=7)
    assert unwritable.read_text() == "mine"
    takt("listen", path, "--write", unwritable, "--force")
    assert "takt: 1" in unwritable.read_text()
    path.write_bytes(pcap(147, [frame("rtu", 250, b"\x06\0\0\0\x01")]))  # no device of a project
    assert "is not written" in takt("listen", path, "--write", tmp_path / "none.yaml").err
    assert not (tmp_path / "none.yaml").exists()
    path.write_bytes(pcap(147, [frame("rtu", 0, b"\x06\0\0\0\x01")]))
    takt("listen", path, "--write", tmp_path / "broadcasts.yaml")
    assert "address: 0" in (tmp_path / "broadcasts.yaml").read_text()


def test_a_port_that_is_lost_ends_with_the_summary():
    bus = Bus(["listener"])
    with bus:
        listening = Listening(bus, "--json")
        for _ in range(50):  # what comes before the port is open is lost
            bus.send(frame("rtu", 5, b"\x03\0\0\0\x01") + frame("rtu", 5, b"\x03\x02\0\x07"))
            with contextlib.suppress(AssertionError):
                until(lambda: listening.events("exchange"), "the exchange", deadline=2)
                break
        exchanges = len(listening.events("exchange"))
    with listening:
        result = listening.program.finish(code=3)
    assert json.loads(result.lines[-1])["answered"] >= exchanges >= 1
