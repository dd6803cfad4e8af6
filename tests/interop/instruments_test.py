"""Instruments with start commands and with settings that a Modbus client writes, by `takt serve`. The
instrument is restarted in the middle, refuses, falls silent, answers in part and repeats what it gets."""
import json
import select
import struct
import threading
import time

import pytest

import endpoints
from converter_test import Client, take
from fake_slave import SerialPeer
from peer_base import TcpPeer
from program import DEADLINE, WITHOUT_WAITING, start, takt, until
from projects import TEN_REGISTERS

PROJECT = """
takt: 1
instruments:
  - name: scale
    {line}
    every: 50ms
    timeout: {timeout}
    start:
      - {{request: 'INIT\\r', answer: {{until: '\\r', pattern: 'OK'}}, attempts: 2,
         refused: {{until: '\\r', pattern: 'ERR{{*}}'}}}}
      - {{request: 'UNIT kg\\r'}}
    start_retry: 300ms
    reset: {{until: '\\r', pattern: 'READY{{*}}'}}
    silent_after: 2
    exchanges:
      - {{request: 'W\\r', answer: {{until: '\\r', pattern: 'W{{weight}}'}}}}
    commands:
      - name: tare
        request: 'T{{value}}\\r'
        decimals: 2
        least: 0
        greatest: 60
        unit: kg
        answer: {{until: '\\r', pattern: 'OK'}}
        refused: {{until: '\\r', pattern: 'ERR{{*}}'}}
        read_back: {{request: 'T?\\r', answer: {{until: '\\r', pattern: 'T={{value}}'}}}}
        expires: {expires}
      - {{name: label, request: 'L{{value:text}}\\r', answer: {{until: '\\r', pattern: 'OK'}}, attempts: 2,
         expires: {expires}}}
      - {{name: beep, request: 'B{{value}}\\r', answer: {{until: '\\r', pattern: 'OK'}}, restore: false}}
""" + TEN_REGISTERS + """          - {{name: Weight, type: int16,
               area: holding_register, register: 0, source: {{instrument: scale.weight}}, max_age: 2s}}
          - {{name: State, type: int16,
               area: holding_register, register: 1, source: {{instrument: scale.state}}}}
          - {{name: Tare, type: int16,
               area: holding_register, register: 2, scale: 0.01, writes_to: {{instrument: scale.tare}}}}
          - {{name: Label, type: string, length: 4,
               area: holding_register, register: 3, writes_to: {{instrument: scale.label}}}}
          - {{name: Beep, type: int16,
               area: holding_register, register: 7, writes_to: {{instrument: scale.beep}}}}
"""


def text(line, port, timeout="1s", expires="8s"):
    """The project. Its instrument answers at once, so that only what it holds back takes that long."""
    return PROJECT.format(line=line, port=port, timeout=timeout, expires=expires)


READY, STARTING, START_FAILED, SILENT, DOWN = range(5)


class Scale:
    """What the instrument is: lines in, lines out. `meddle(line)` gives another answer (bytes), or None to
    let it answer."""

    def __init__(self):
        self.meddle = lambda line: None
        self.lines = []
        self._part = b""
        self.restart()

    def restart(self):
        self.initialised, self.tare, self.label = False, None, None
        self._part = b""
        self.lines.append("-- restart")

    def take(self, data):
        """The answers to the bytes."""
        answer = b""
        for byte in data:
            if byte != 0x0D:
                self._part += bytes([byte])
                continue
            line, self._part = self._part.decode(), b""
            if line != "W":
                self.lines.append(line)
            meddled = self.meddle(line)
            answer += self._obey(line) if meddled is None else meddled
        return answer

    def _obey(self, line):
        if line == "INIT":
            self.initialised = True
        elif line == "UNIT kg":
            return b""
        elif not self.initialised:
            return b"ERR 1\r"
        elif line == "W":
            return b"W42\r"
        elif line == "T?":
            return f"T={self.tare}\r".encode()
        elif line[0] == "T":
            if float(line[1:]) == 13:
                return b"ERR 13\r"
            self.tare = float(line[1:])
        elif line[0] == "L":
            self.label = line[1:]
        return b"OK\r"

    def since_restart(self):
        last = len(self.lines) - 1 - self.lines[::-1].index("-- restart")
        return self.lines[last + 1:]


class OnSerial(SerialPeer):

    def __init__(self, port):
        self.scale = Scale()
        super().__init__(port)

    def _serve_once(self):
        answer = self.scale.take(self._line.read(1))
        if answer:
            self._line.write(answer)

    def restart(self, banner=b"READY v2\r"):
        self.scale.restart()
        self._line.write(banner)


class OnTcp(TcpPeer):

    def __init__(self):
        self.scale = Scale()
        self._peer = None
        super().__init__()

    def _connected(self, peer):
        self._peer = peer
        self._begin(self._serve, peer)

    def _serve(self, peer):
        peer.settimeout(0.02)
        while not self._stop.is_set():
            try:
                data = peer.recv(300)
                if not data:
                    return
                peer.sendall(self.scale.take(data))
            except TimeoutError:
                continue
            except OSError:
                return

    def restart(self):
        self.scale.restart()
        self._peer.close()

    def stop(self):
        """Ends the connection and accepts no other one."""
        self.__exit__()
        self._peer.close()


def registers(client, register, count=1):
    answer = client.ask(f"03 {register:04X} {count:04X}")
    return answer[1] if answer[0] & 0x80 else list(struct.unpack(f">{count}H", answer[2:]))


def write_request(value):
    """The frame of a write of the tare."""
    return struct.pack(">HHHBBHH", 1, 0, 6, 1, 6, 2, value)


def answer_of(client):
    """Of a write request that was sent before: 0, or the exception."""
    head = take(client._socket.recv, 6)
    body = take(client._socket.recv, struct.unpack(">H", head[4:])[0])
    return body[2] if body[1] & 0x80 else 0


def write(client, register, value):
    """0, or the exception."""
    answer = client.ask(f"06 {register:04X} {value & 0xFFFF:04X}")
    return answer[1] if answer[0] & 0x80 else 0


def write_text(client, register, text):
    data = text.ljust(8, b"\0")
    answer = client.ask(f"10 {register:04X} 0004 08 {data.hex()}")
    return answer[1] if answer[0] & 0x80 else 0


@pytest.fixture
def served(project, pair, tmp_path, request):
    """The instrument on a serial port, the running program, a client. The parameter: times of text()."""
    port = endpoints.free_port()
    path = project(text(line=f"port: {pair.b}", port=port, **getattr(request, "param", {})))
    with OnSerial(pair.a) as instrument, start("serve", path, "--json", "--log", tmp_path / "log") as running:
        endpoints.wait_listening(port, running)
        yield instrument, running, Client(port)


def ready(client):
    until(lambda: registers(client, 0, 2) == [42, READY], "the instrument is ready")


def test_a_written_register_becomes_a_command(served):
    instrument, running, client = served
    ready(client)
    assert instrument.scale.since_restart()[:2] == ["INIT", "UNIT kg"]
    assert write(client, 2, 1250) == 0
    assert instrument.scale.tare == 12.5
    assert instrument.scale.lines[-2:] == ["T12.50", "T?"]
    assert registers(client, 2) == [1250]

    assert write(client, 2, 6001) == 3, "beyond the range: nothing is sent"
    assert instrument.scale.lines[-1] == "T?"
    assert write(client, 2, 1300) == 4, "the instrument refuses"
    assert registers(client, 2) == [1250], "the value before"
    instrument.scale.meddle = lambda line: b"T=7.00\r" if line == "T?" else None
    assert write(client, 2, 500) == 4, "another value is read back"
    instrument.scale.meddle = lambda line: b"" if line[0] == "T" else None
    assert write(client, 2, 600) == 0x0B, "silent"
    instrument.scale.meddle = lambda line: b"O" if line[0] == "T" else None
    assert write(client, 2, 600) == 0x0B, "half an answer"
    instrument.scale.meddle = lambda line: line.encode() + b"\rT=9\r?\r" if line[0] == "T" else None
    assert write(client, 2, 600) == 0x0B, "its echo and garbage"
    instrument.scale.meddle = lambda line: None
    assert write(client, 2, 700) == 0
    assert instrument.scale.tare == 7

    assert write_text(client, 3, b"Silo 1") == 0
    assert instrument.scale.label == "Silo 1"
    for label in (b"a\rT1", b"a\nb", b"a;b", b"\x1B[2J", b"", b"\xC3\xA9"):
        before = len(instrument.scale.lines)
        assert write_text(client, 3, label) == 3, label
        assert len(instrument.scale.lines) == before, label
    before = list(instrument.scale.lines)
    label, beep = b"a\rT1".ljust(8, b"\0").hex(), "0001"
    refused = bytes([0x90, 3])
    assert client.ask(f"10 0002 0006 0C 05DC {label} {beep}") == refused, "one of three values is wrong"
    assert instrument.scale.lines == before and registers(client, 2) == [700], "none of the three is sent"
    counters = running.interrupt().json["instruments"][0]
    assert (counters["name"], counters["state"]) == ("scale", "ready")
    assert counters["written"] == 3
    assert counters["refused"] == 2
    assert counters["unanswered"] == 3


@pytest.mark.parametrize("how", ["by its line", "by silence"])
def test_settings_survive_the_instrument(served, tmp_path, how):
    instrument, running, client = served
    ready(client)
    assert write(client, 2, 100) == 0
    assert write(client, 2, 250) == 0
    assert write_text(client, 3, b"Silo") == 0
    assert write(client, 7, 5) == 0
    if how == "by its line":
        instrument.restart()
    else:
        instrument.scale.meddle = lambda line: b""
        until(lambda: registers(client, 1) == [SILENT], "it is silent")
        instrument.scale.restart()
        scale = instrument.scale
        scale.meddle = lambda line: None if line != "W" or scale.initialised else b"W1\r"
    until(lambda: instrument.scale.label == "Silo", "the settings")
    assert [line for line in instrument.scale.since_restart() if line[0] != "W"] == \
        ["INIT", "UNIT kg", "T2.50", "T?", "LSilo"], "no action, and each setting once"
    assert instrument.scale.tare == 2.5
    ready(client)
    counters = running.interrupt().json["instruments"][0]
    assert (counters["resets"], counters["starts"], counters["restored"]) == (1, 2, 2)
    log = (tmp_path / "log").read_text()
    assert "instrument scale: start complete, settings sent again: 2" in log
    assert ("it has restarted" if how == "by its line" else "it answers again") in log


def test_a_connection_that_is_opened_again(project, tmp_path):
    port = endpoints.free_port()
    with OnTcp() as instrument:
        line = f"transport: tcp\n    host: 127.0.0.1\n    tcp_port: {instrument.port}"
        with start("serve", project(text(line=line, port=port))) as running:
            endpoints.wait_listening(port, running)
            client = Client(port)
            ready(client)
            assert write(client, 2, 250) == 0
            instrument.restart()
            until(lambda: instrument.scale.tare == 2.5, "the setting")
            assert instrument.scale.since_restart()[:3] == ["INIT", "UNIT kg", "T2.50"]
            ready(client)
            running.interrupt()


def test_each_write_expires_while_the_link_is_down(project):
    """Also the later ones: the time of each runs by itself."""
    port = endpoints.free_port()
    with OnTcp() as instrument:
        line = f"transport: tcp\n    host: 127.0.0.1\n    tcp_port: {instrument.port}"
        with start("serve", project(text(line=line, port=port, expires="1500ms"))) as running:
            endpoints.wait_listening(port, running)
            ready(Client(port))
            instrument.stop()
            until(lambda: registers(Client(port), 1) == [DOWN], "the link is down")
            clients = [Client(port) for _ in range(3)]
            results = []
            threads = [threading.Thread(target=lambda c=c: results.append(write(c, 2, 100))) for c in clients]
            for thread in threads:
                thread.start()
                time.sleep(0.2)
            for thread in threads:
                thread.join(DEADLINE)
            assert results == [0x0B] * 3
            running.interrupt()


def test_a_write_that_races_with_a_restart(served):
    """The instrument restarts instead of an answer: the old value goes out after the start, then the new
    one."""
    instrument, _, client = served
    ready(client)
    assert write(client, 2, 100) == 0

    def restart_once(line):
        if line != "T2.00":
            return None
        instrument.scale.meddle = lambda line: None
        instrument.scale.restart()
        return b"READY\r"

    instrument.scale.meddle = restart_once
    assert write(client, 2, 200) == 0
    assert instrument.scale.since_restart() == ["INIT", "UNIT kg", "T1.00", "T?", "T2.00", "T?"]
    assert instrument.scale.tare == 2

    instrument.scale.meddle = lambda line: b"READY\r" if line[0] == "B" else None
    assert write(client, 7, 1) == 0x0B, "an action is not repeated: it may have been done"
    instrument.scale.meddle = lambda line: None
    ready(client)
    assert instrument.scale.lines.count("B1") == 1


def test_a_start_that_fails(served, tmp_path):
    instrument, running, client = served
    ready(client)
    instrument.scale.meddle = lambda line: b"ERR 5\r" if line == "INIT" else None
    instrument.restart()
    until(lambda: registers(client, 1) == [START_FAILED], "the start fails")
    until(lambda: registers(client, 0) == 0x0B, "no value without a start")
    assert write(client, 2, 100) == 0x0B
    instrument.scale.meddle = lambda line: None
    ready(client)
    assert instrument.scale.tare is None, "what has expired is not sent"
    assert running.interrupt().json["instruments"][0]["failed_starts"] >= 1
    assert "instrument scale: start command 1: refused by the instrument" in (tmp_path / "log").read_text()


@pytest.mark.parametrize("served", [{"timeout": "60s", "expires": "60s"}], indirect=True, ids=["patient"])
def test_many_writers(served):
    """More writes than the queue takes: each is done, or refused as busy. The last one done is the value."""
    instrument, running, client = served
    ready(client)
    port = client._socket.getpeername()[1]
    all_asked = threading.Event()  # the instrument holds its answers back until then
    instrument.scale.meddle = lambda line: all_asked.wait(DEADLINE) and None
    clients = [Client(port) for _ in range(60)]
    for number, each in enumerate(clients):
        each._socket.sendall(write_request(number))
    sockets = [each._socket for each in clients]
    until(lambda: len(select.select(sockets, [], [], 0)[0]) >= 20, "refusals of the queue")
    all_asked.set()
    results = {number: answer_of(each) for number, each in enumerate(clients)}
    assert set(results.values()) <= {0, 6, 0x0B}
    done = [f"T{number / 100:.2f}" for number, result in results.items() if result == 0]
    assert len(done) >= 5
    assert 6 in results.values(), "the queue is limited"
    sent = [line for line in instrument.scale.lines if line[0] == "T" and line != "T?"]
    assert set(done) <= set(sent)
    assert len(sent) == len(set(sent)), "none twice"
    until(lambda: instrument.scale.lines[-1] == "T?", "the last one is read back")
    counters = running.interrupt().json["instruments"][0]
    assert counters["written"] == len(done)
    assert counters["busy"] == list(results.values()).count(6)


@pytest.mark.parametrize("served", [{"timeout": "60s", "expires": "60s"}], indirect=True, ids=["patient"])
def test_the_end_of_the_program_while_a_write_waits(served):
    instrument, running, client = served
    ready(client)
    instrument.scale.meddle = lambda line: b"" if line[0] == "T" else None
    client._socket.sendall(write_request(100))
    until(lambda: "T1.00" in instrument.scale.lines, "the command")
    running.interrupt(deadline=WITHOUT_WAITING)


def test_what_cannot_be(project):
    wrong = text(line="port: /dev/null", port=1).replace("scale.tare", "scale.tara") \
        .replace("T{value}", "T").replace("least: 0", "least: 61").replace("expires: 8s", "expires: never")
    findings = takt("check", project(wrong), "--json", code=1).json["findings"]
    found = {finding["code"]: finding for finding in findings}
    assert {"instrument.command_unknown", "instrument.placeholder", "instrument.range", "duration.malformed"
            } <= set(found)
    unknown = found["instrument.command_unknown"]
    assert unknown["path"] == "servers[0].units[0].variables[2].writes_to.instrument"
    assert unknown["value"] == "scale.tara"
    assert "scale.tare" in unknown["allowed"]
    assert json.dumps(findings)
