"""`takt run` as a protocol converter: a device on RTU, served over TCP, RTU over TCP, RTU and ASCII at
once."""
import contextlib
import json
import socket
import struct

import pytest
import serial as pyserial

import endpoints
from fake_slave import SerialSlave, TcpSlave, tcp_answer
from frames import crc16, request
from program import DEADLINE, start, until

PROJECT = """
takt: 1
lines:
  - name: bus
    transport: serial
    port: {line}
    baud: 115200
    devices:
      - name: D
        address: 7
        poll_period: 50ms
        response_timeout: 2s
        attempts: 2
        group_requests: true
        variables:
          - {{name: Count, type: uint16, register: 0, read: 0x03}}
          - {{name: Triple, type: uint16, register: 1, read: 0x03}}
          - {{name: Setpoint, type: int16, register: 2, read: 0x03, write: 0x06}}
locals:
  - {{name: Note, type: int16, default: 3}}
servers:
  - name: net
    listen: 127.0.0.1
    tcp_port: {port}
    audit: net.audit
    units:
      - address: 1
        banks:
          - {{area: holding_register, items: [0..9]{bank}}}
        high_register_first: true
        variables:
          - {{name: A, type: uint16, area: holding_register, register: 0,
              source: {{variable: Count}}, max_age: 30s}}
          - {{name: B, type: float, area: holding_register, register: 1,
              source: {{variable: Triple}}, max_age: 30s}}
          - {{name: C, type: int16, area: holding_register, register: 3,
              source: {{variable: Setpoint}}, writes_to: {{variable: Setpoint}}, max_age: 30s}}
          - {{name: E, type: int16, area: holding_register, register: 4, source: {{local: Note}}}}
  - name: old
    transport: serial
    port: {ascii}
    framing: ascii
    units:
      - address: 9
        banks:
          - {{area: input_register, items: [0..1]}}
        variables:
          - {{name: A9, type: uint16, area: input_register, register: 0,
              source: {{variable: Count}}, max_age: 30s}}
          - {{name: B9, type: uint16, area: input_register, register: 1,
              source: {{variable: Triple}}, max_age: 30s}}
  - name: wired
    transport: serial
    port: {rtu}
    units:
      - address: 5
        banks:
          - {{area: input_register, items: [0..1]}}
        variables:
          - {{name: A5, type: uint16, area: input_register, register: 0,
              source: {{variable: Count}}, max_age: 30s}}
          - {{name: B5, type: uint16, area: input_register, register: 1,
              source: {{variable: Triple}}, max_age: 30s}}
  - name: tunnel
    listen: 127.0.0.1
    tcp_port: {tunnel}
    framing: rtu
    units:
      - address: 6
        banks:
          - {{area: input_register, items: [0..1]}}
        variables:
          - {{name: A6, type: uint16, area: input_register, register: 0,
              source: {{variable: Count}}, max_age: 30s}}
          - {{name: B6, type: uint16, area: input_register, register: 1,
              source: {{variable: Triple}}, max_age: 30s}}
"""


class Device:
    """Counts with every read; the second register is three times the first one. Can be switched off."""

    def __init__(self):
        self.count, self.setpoint, self.dead, self.refuses = 0, 20, False, False

    def __call__(self, frame):
        if self.dead:
            return None
        unit, function, start, value = struct.unpack(">BBHH", frame[:6])
        if unit != 7:
            return None
        if function == 3:
            self.count = (self.count + 1) % 20000
            registers = [self.count, self.count * 3, self.setpoint][start:start + value]
            return request(
                "rtu", 7,
                struct.pack(">BB", 3, 2 * value) + b"".join(struct.pack(">H", r) for r in registers))
        if self.refuses:
            return request("rtu", 7, "86 02")
        self.setpoint = value
        return frame


class Client:
    """A master on TCP: `ask(pdu)` gives the PDU of the answer."""

    def __init__(self, port):
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=DEADLINE)

    def ask(self, pdu):
        body = bytes([1]) + bytes.fromhex(pdu)
        self._socket.sendall(struct.pack(">HHH", 1, 0, len(body)) + body)
        head = take(self._socket.recv, 6)
        return take(self._socket.recv, struct.unpack(">H", head[4:])[0])[1:]


class AsciiClient:

    def __init__(self, port):
        self._line = pyserial.Serial(port, timeout=DEADLINE)

    def ask(self, pdu):
        self._line.write(request("ascii", 9, pdu))
        return bytes.fromhex(self._line.read_until(b"\n")[1:-4].decode())[1:]


class RtuClient:
    """A client on functions that write and read frames. It reads two registers only."""

    def __init__(self, unit, write, read):
        self._unit, self._write, self._read = unit, write, read

    def ask(self, pdu):
        self._write(request("rtu", self._unit, pdu))
        head = take(self._read, 2)
        body = head + take(self._read, 7 if head[1] < 0x80 else 3)
        assert crc16(body[:-2]) == body[-2:]
        return body[1:-2]


def take(read, count):
    data = b""
    while len(data) < count:
        more = read(count - len(data))
        assert more, "closed, or nothing came"
        data += more
    return data


@pytest.fixture
def plant(project, tmp_path, request):
    """Device, client of the TCP server, clients of the servers in ASCII, RTU and RTU over TCP. The parameter:
    further keys of the TCP server's bank."""
    with contextlib.ExitStack() as stack:
        pairs = []
        for name in ("bus", "old", "wired"):
            (tmp_path / name).mkdir()
            pairs.append(stack.enter_context(endpoints.serial_pair(tmp_path / name)))
        bus, old, wired = pairs
        port, tunnel = endpoints.free_port(), endpoints.free_port()
        device = Device()
        stack.enter_context(SerialSlave(bus.b, device))
        running = stack.enter_context(
            start(
                "run",
                project(
                    PROJECT.format(line=bus.a, bank=getattr(request, "param", ""), port=port, tunnel=tunnel,
                                   ascii=old.b, rtu=wired.b))))
        for each in (port, tunnel):
            endpoints.wait_listening(each, running)
        client = Client(port)
        until(lambda: client.ask("03 0000 0003")[0] == 3, "values of the device")
        line = stack.enter_context(pyserial.Serial(wired.a, timeout=DEADLINE))
        stream = stack.enter_context(socket.create_connection(("127.0.0.1", tunnel), timeout=DEADLINE))
        yield device, client, [
            AsciiClient(old.a),
            RtuClient(5, line.write, line.read),
            RtuClient(6, stream.sendall, stream.recv)
        ]
        running.interrupt()


def test_values_are_those_of_one_moment_over_every_protocol(plant):
    device, client, others = plant
    seen = set()
    for turn in range(40):
        last, triple = struct.unpack(">Hf", client.ask("03 0000 0003")[2:])
        assert triple == 3 * last, "a request's members change together"
        for other in others[turn % 3:] + others[:turn % 3]:
            answer = other.ask("04 0000 0002")
            assert answer[0] == 4, answer.hex()
            count, triple = struct.unpack(">HH", answer[2:])
            assert triple == 3 * count
            assert last <= count <= device.count, "no protocol is behind another"
            last = count
        seen.add(last)
    assert len(seen) > 1, "the values move"


def test_old_values_are_not_shown_and_come_back(plant):
    device, client, others = plant
    device.dead = True
    until(lambda: client.ask("03 0000 0001") == bytes.fromhex("830B"), "exception 0x0B")
    assert [other.ask("04 0000 0002").hex() for other in others] == ["840b"] * 3
    assert client.ask("06 0003 0001") == bytes.fromhex("860B"), "it cannot be written"
    assert client.ask("03 0004 0001") == bytes.fromhex("03020003"), "a local is there"
    assert device.setpoint == 20
    device.dead = False
    until(lambda: client.ask("03 0000 0001")[0] == 3, "the values of the device that is back")


@pytest.mark.parametrize("plant", ["", ", retain: true"], indirect=True, ids=["plain", "retained"])
def test_a_write_reaches_the_device_before_it_is_answered(plant, tmp_path):
    device, client, _ = plant
    for value in (5, -7, 300):
        pdu = "06 0003 " + struct.pack(">h", value).hex()
        assert client.ask(pdu) == bytes.fromhex(pdu)
        assert device.setpoint == value & 0xFFFF
        assert client.ask("03 0003 0001")[2:] == struct.pack(">h",
                                                             value), "what was written is read back at once"
    device.refuses = True
    assert client.ask("06 0003 0001") == bytes.fromhex("8602"), "the answer of the device"
    until(lambda: client.ask("03 0003 0001") == bytes.fromhex("0302012C"), "the value of the device")
    assert client.ask("06 0000 0001") == bytes.fromhex("8602"), "it has no way back"
    audit = tmp_path / "net.audit"
    until(lambda: audit.read_text().count("\n") == 6, "the audit log")
    entries = [json.loads(line) for line in audit.read_text().splitlines()]
    assert [e["new"] for e in entries[:4]] == [[5], [0xFFF9], [300], [1]]
    assert [(e["event"], e["start"], e["exception"])
            for e in entries[4:]] == [("refused", 3, 2), ("refused", 0, 2)], "by the device"


ONE_DEVICE = """
takt: 1
lines:
  - name: far
    transport: tcp
    host: 127.0.0.1
    tcp_port: {device}
    devices:
      - name: D
        address: 7
        poll_period: 50ms
        response_timeout: 3s
        variables: [{{name: Setpoint, type: int16, register: 0, read: 0x03, write: 0x06}}]
servers:
  - name: near
    listen: 127.0.0.1
    tcp_port: {port}
    units:
      - address: 1
        banks: [{{area: holding_register, items: [0..0]}}]
        variables: [{{name: S, type: int16, area: holding_register, register: 0,
            source: {{variable: Setpoint}}, max_age: 20s,
                     writes_to: {{variable: Setpoint}}}}]
"""


def test_a_write_to_a_device_that_is_not_connected_is_refused_and_never_done(project):
    asked = []

    def answer(adu):
        asked.append(adu[7:])
        return tcp_answer(adu, "03 02 00 05" if adu[7] == 3 else adu[7:].hex())

    device, port = endpoints.free_port(), endpoints.free_port()
    with start("run", project(ONE_DEVICE.format(device=device, port=port))) as running:
        endpoints.wait_listening(port, running)
        client = Client(port)
        assert client.ask("06 0000 0064") == bytes.fromhex("860B"), "at once, not when a client connects"
        with TcpSlave(answer, device):
            until(lambda: client.ask("03 0000 0001") == bytes.fromhex("03020005"), "the value of the device")
            assert client.ask("06 0000 0065") == bytes.fromhex("06 0000 0065")
        until(lambda: client.ask("06 0000 0066") == bytes.fromhex("860B"), "the device is gone")
        with TcpSlave(answer, device):
            until(lambda: client.ask("03 0000 0001") == bytes.fromhex("03020005"),
                  "the value of the device that is back")
        assert [pdu for pdu in asked if pdu[0] == 6] == [bytes.fromhex("06 0000 0065")]
        running.interrupt()


def test_locals_are_written(plant):
    _, client, _ = plant
    assert client.ask("06 0004 FFFE") == bytes.fromhex("060004FFFE")
    assert client.ask("03 0004 0001") == bytes.fromhex("0302FFFE")
