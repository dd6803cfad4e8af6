"""The gateway: clients over TCP, `takt run`, and slaves on a serial line, all of them real programs."""
import json
import signal
import socket
import struct
import threading
import time

from pymodbus.client import ModbusTcpClient
import pytest

import endpoints
from fake_slave import SerialPeer
from frames import crc16
from program import DEADLINE, PEERS, Running, start, takt, until

PROJECT = """
takt: 1
lines:
  - name: bus
    transport: serial
    port: {serial}
    framing: rtu
    baud: 115200
    parity: none
{devices}
servers:
  - name: gate
    listen: 127.0.0.1
    tcp_port: {port}
{own}
    relay:
      - {{line: bus, units: [{units}], map: [{{from: 100, to: 1}}]{options}}}
{access}
"""
OWN = "    units:\n      - {address: 2, banks: [{area: holding_register, items: [0..9]}]}"
POLLED = """    devices:
      - name: D
        address: 1
        response_timeout: 2s
        variables:
          - {name: Polled, type: uint16, register: 7, read: 3, period: 200ms}"""


class Bus(SerialPeer):
    """Slaves on a pty: register r of unit u holds 100·u + r until it is written. `dead` units do not answer,
    and no unit answers while `gate` is not set."""

    def __init__(self, port, units=(1, 3), delay=0.002):
        super().__init__(port)
        self.units, self.delay = units, delay
        self.dead, self.late = set(), {}
        self.written, self.seen = {}, []
        self.gate = threading.Event()
        self.gate.set()
        self._received = b""

    def __exit__(self, *error):
        self.gate.set()
        super().__exit__(*error)

    def _serve_once(self):
        self._received += self._line.read(1) + self._line.read(self._line.in_waiting)
        if len(self._received) < 8:
            return
        if crc16(self._received[:-2]) == self._received[-2:]:
            self._answer(self._received[0], self._received[1:-2])
        self._received = b""

    def _answer(self, unit, pdu):
        self.seen.append((unit, pdu))
        if unit == 0:
            self.written[pdu[1:3]] = pdu[3:5]
        if unit not in self.units or unit in self.dead:
            return
        time.sleep(self.late.pop(unit, self.delay))
        self.gate.wait()
        if pdu[0] == 3:
            first, count = struct.unpack(">HH", pdu[1:5])
            values = [self.written.get((unit, r), 100 * unit + r) for r in range(first, first + count)]
            answer = bytes([3, 2 * count]) + struct.pack(f">{count}H", *values)
        elif pdu[0] == 6:
            self.written[(unit, struct.unpack(">H", pdu[1:3])[0])] = struct.unpack(">H", pdu[3:5])[0]
            answer = pdu[:5]
        else:
            answer = bytes([pdu[0] | 0x80, 1])
        frame = bytes([unit]) + answer
        self._line.write(frame + crc16(frame))


@pytest.fixture
def gateway(project, pair):
    """Starts `takt run` for a relaying project; gives the running program and its TCP port."""
    started = []

    def run(devices=POLLED, own=OWN, options="", units="1..20", access=""):
        port = endpoints.free_port()
        path = project(
            PROJECT.format(serial=pair.a, units=units, devices=devices, own=own, port=port, options=options,
                           access=access))
        assert takt("check", path, code=None).code in (0, 1)
        running = start("run", path, "--json")
        started.append(running)
        endpoints.wait_listening(port, running)
        until(lambda: any(e["event"] == "link" and e["up"] for e in running.events()), "the line is open")
        return running, port

    yield run
    for running in started:
        with running:
            running.interrupt()


def ask(connection, unit, pdu, transaction=1):
    connection.sendall(struct.pack(">HHHB", transaction, 0, len(pdu) + 1, unit) + pdu)


def receive(connection):
    """@returns transaction, unit, PDU"""
    connection.settimeout(DEADLINE)
    head = b""
    while len(head) < 7:
        got = connection.recv(7 - len(head))
        assert got, "closed"
        head += got
    transaction, _, length, unit = struct.unpack(">HHHB", head)
    body = b""
    while len(body) < length - 1:
        body += connection.recv(length - 1 - len(body))
    return transaction, unit, body


def read(unit, register):
    return bytes([3]) + struct.pack(">HH", register, 1)


def value(unit, register):
    return bytes([3, 2]) + struct.pack(">H", 100 * unit + register)


def test_own_units_relayed_ones_and_none(gateway, pair):
    with Bus(pair.b) as bus:
        running, port = gateway(options=", response_timeout: 3s")
        client = ModbusTcpClient("127.0.0.1", port=port, timeout=DEADLINE)
        assert client.connect()
        assert client.read_holding_registers(5, 2, slave=1).registers == [105, 106]
        assert client.read_holding_registers(5, 2, slave=100).registers == [105, 106]
        assert client.read_holding_registers(5, 2, slave=3).registers == [305, 306]
        assert client.read_holding_registers(5, 2, slave=2).registers == [0, 0]
        assert not client.write_register(9, 77, slave=3).isError()
        assert client.read_holding_registers(9, 1, slave=3).registers == [77]
        assert client.read_holding_registers(0, 1, slave=4).exception_code == 0x0B
        assert client.read_holding_registers(0, 1, slave=50).exception_code == 0x0A
        assert client.read_coils(0, 1, slave=3).exception_code == 1
        client.close()
        until(
            lambda: any(e["event"] == "value" and e["name"] == "Polled" and e["value"] == 107
                        for e in running.events()), "polling goes on")
        assert {unit for unit, _ in bus.seen} == {1, 3, 4}
        running.interrupt()
        served = next(e for e in running.events() if e["event"] == "served")["served"]
        assert [(s["where"].split(":")[0], s["requests"], s["exceptions"]) for s in served] == [("tcp", 9, 3)]
        relayed = [e for e in running.events() if e["event"] == "relayed"]
        assert [(e["line"], e["asked"], e["sent"], e["no_answer"], e["shared"])
                for e in relayed] == [("bus", 7, 7, 1, 0)]


def test_many_clients_one_flooding_one_asking_a_dead_unit(gateway, pair):
    with Bus(pair.b) as bus:
        bus.dead = {3}
        _, port = gateway(options=", response_timeout: 2s")
        wrong, served, stop = [], {}, threading.Event()

        def work(number):
            unit = 3 if number == 0 else 1
            with socket.create_connection(("127.0.0.1", port)) as connection:
                for i in range(3 if number == 0 else 8):
                    ask(connection, unit, read(unit, 10 * number + i), i)
                    got = receive(connection)
                    expected = (i, unit, b"\x83\x0b" if unit == 3 else value(unit, 10 * number + i))
                    if got != expected:
                        wrong.append((number, got, expected))
                served[number] = True

        def flood():
            with socket.create_connection(("127.0.0.1", port)) as connection:
                connection.settimeout(0.05)
                requests = b"".join(struct.pack(">HHHB", i, 0, 6, 1) + read(1, 200 + i) for i in range(500))
                while not stop.is_set():
                    try:
                        connection.sendall(requests)
                    except socket.timeout:
                        pass

        flooding = threading.Thread(target=flood)
        flooding.start()
        clients = [threading.Thread(target=work, args=(n, )) for n in range(4)]
        for client in clients:
            client.start()
        for client in clients:
            client.join(DEADLINE)
        stop.set()
        flooding.join(DEADLINE)
        assert not wrong
        assert len(served) == 4
        # Between two requests of a client the flood has one; the rest of its own is what the clients leave.
        order = [
            "flood" if struct.unpack(">H", pdu[1:3])[0] >= 200 else "client" for unit, pdu in bus.seen
            if unit == 1
        ]
        assert order.count("flood") > 0


SELDOM = "    relay_interval: 1h\n" + POLLED.replace("200ms", "1h")


@pytest.mark.parametrize("devices", ["", SELDOM], ids=["not polled", "seldom polled"])
def test_pipelined_requests_are_sent_as_soon_as_the_line_is_free(gateway, pair, devices):
    """A request that waits for polling to wake the line, or for the interval, would get exception 6."""
    with Bus(pair.b):
        _, port = gateway(devices=devices, own="", options=", response_timeout: 20s")
        with socket.create_connection(("127.0.0.1", port)) as client:
            for number in range(12):
                ask(client, 3, read(3, number), number)
            for number in range(12):
                assert receive(client) == (number, 3, value(3, number))


def test_a_late_answer_is_not_anothers(gateway, pair):
    with Bus(pair.b) as bus:
        _, port = gateway(devices="", own="", options=", response_timeout: 2s")
        with socket.create_connection(("127.0.0.1", port)) as first, socket.create_connection(
            ("127.0.0.1", port)) as second:
            bus.late[3] = 2.6
            ask(first, 3, read(3, 11), 7)
            until(lambda: bus.seen, "it is asked")
            ask(second, 3, read(3, 12), 8)
            assert receive(first) == (7, 3, b"\x83\x0b")
            assert receive(second) == (8, 3, value(3, 12))


def test_equal_reads_are_one_and_the_cache_answers(gateway, pair):
    with Bus(pair.b, delay=0.03) as bus:
        _, port = gateway(devices="", own="", options=", cache: 1min, response_timeout: 20s")
        connections = [socket.create_connection(("127.0.0.1", port)) for _ in range(6)]
        for connection in connections:
            ask(connection, 3, read(3, 1))
        for connection in connections:
            assert receive(connection)[2] == value(3, 1)
        assert 1 <= len(bus.seen) <= 2
        asked = len(bus.seen)
        ask(connections[0], 3, read(3, 1))
        assert receive(connections[0])[2] == value(3, 1)
        assert len(bus.seen) == asked
        ask(connections[1], 3, bytes([6, 0, 1, 0, 9]))
        assert receive(connections[1])[2] == bytes([6, 0, 1, 0, 9])
        ask(connections[0], 3, read(3, 1))
        assert receive(connections[0])[2] == bytes([3, 2, 0, 9])
        for connection in connections:
            connection.close()


def test_a_client_that_is_cut_off_takes_its_request_with_it(gateway, pair):
    with Bus(pair.b) as bus:
        _, port = gateway(devices="", options=", response_timeout: 20s")
        bus.gate.clear()
        staying = socket.create_connection(("127.0.0.1", port))
        going = socket.create_connection(("127.0.0.1", port))
        ask(staying, 1, read(1, 1))
        until(lambda: bus.seen, "it is asked")
        ask(going, 1, bytes([6, 0, 5, 0, 1]))
        going.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # close() resets
        going.close()
        with socket.create_connection(("127.0.0.1", port)) as probe:  # all earlier bytes were processed
            ask(probe, 2, read(2, 0))
            assert receive(probe)[2] == bytes([3, 2, 0, 0])
        bus.gate.set()
        assert receive(staying)[2] == value(1, 1)
        ask(staying, 1, read(1, 5))
        assert receive(staying)[2] == value(1, 5)
        assert all(pdu[0] == 3 for _, pdu in bus.seen)
        staying.close()


def test_a_half_closed_client_gets_its_answer(gateway, pair):
    with Bus(pair.b) as bus:
        _, port = gateway(devices="")
        bus.gate.clear()
        client = socket.create_connection(("127.0.0.1", port))
        ask(client, 1, read(1, 1))
        client.shutdown(socket.SHUT_WR)
        until(lambda: bus.seen, "it is asked")
        bus.gate.set()
        assert receive(client)[2] == value(1, 1)
        assert client.recv(1) == b""
        client.close()


def test_the_line_goes_away(project):
    near = endpoints.free_port()
    serial = socket.create_server(("127.0.0.1", near))
    port = endpoints.free_port()
    path = project(f"""
takt: 1
lines:
  - {{name: bus, transport: tcp, host: 127.0.0.1, tcp_port: {near}, framing: rtu}}
servers:
  - {{name: gate, listen: 127.0.0.1, tcp_port: {port}, relay: [{{line: bus}}]}}
""")
    assert takt("check", path).code == 0
    with start("run", path, "--json") as running:
        endpoints.wait_listening(port, running)
        far, _ = serial.accept()
        until(lambda: any(e["event"] == "link" and e["up"] for e in running.events()), "the line is open")
        with socket.create_connection(("127.0.0.1", port)) as client, socket.create_connection(
            ("127.0.0.1", port)) as other:
            ask(client, 5, bytes([6, 0, 5, 0, 1]), 3)
            frame = bytes([5, 6, 0, 5, 0, 1])
            assert far.recv(100) == frame + crc16(frame)
            ask(other, 5, read(5, 1), 4)
            time.sleep(0.02)
            serial.close()
            far.close()
            assert receive(client) == (3, 5, b"\x86\x0b"), "it was sent: its result is unknown"
            assert receive(other) == (4, 5, b"\x83\x0a")
            ask(client, 5, read(5, 1), 5)
            assert receive(client) == (5, 5, b"\x83\x0a")
        running.interrupt()


def test_from_rtu_to_ascii(project, pair, tmp_path):
    """A serial server relays to another serial line, where `takt serve` is the device."""
    folder = tmp_path / "other"
    folder.mkdir()
    with endpoints.serial_pair(folder) as other:
        device = project(
            f"""
takt: 1
servers:
  - name: device
    transport: serial
    port: {other.b}
    framing: ascii
    baud: 115200
    units:
      - {{address: 17, banks: [{{area: holding_register, items: [0..9]}}]}}
""", name="device.yaml")
        path = project(f"""
takt: 1
lines:
  - {{name: bus, transport: serial, port: {other.a}, framing: ascii, baud: 115200}}
servers:
  - {{name: converter, transport: serial, port: {pair.b}, relay: [
      {{line: bus, response_timeout: 20s, map: [{{from: 5, to: 17}}]}}]}}
""")
        with start("serve", device) as serving, start("run", path, "--json") as running:
            target = f"rtu://{pair.a}?baud=19200&parity=even"
            until(
                lambda: takt("raw", target, "--unit", 5, "--timeout", "5s", "06 0003 002A", code=None).out.
                strip() == "06 00 03 00 2A", "the write goes through")
            assert takt("raw", target, "--unit", 5, "--timeout", "5s",
                        "03 0003 0001").out.strip() == "03 02 00 2A"
            running.interrupt()
            serving.interrupt()


def test_a_libmodbus_slave_and_a_broadcast(gateway, pair):
    with Running([PEERS / "libmodbus_server", "rtu", pair.b, 115200, "N", 5]) as slave:
        slave.wait_line(lambda line: line == "ready", "the slave is ready")
        _, port = gateway(devices="", own="", units="0..20", options=", response_timeout: 20s")
        client = ModbusTcpClient("127.0.0.1", port=port, timeout=DEADLINE)
        assert client.connect()
        assert client.read_holding_registers(100, 125, slave=5).registers == list(range(100, 225))
        assert client.read_coils(1, 8, slave=5).bits == [True, False] * 4
        assert not client.write_registers(10, [7, 8, 9], slave=5).isError()
        assert not client.write_register(13, 4711, slave=0).isError()
        assert client.read_holding_registers(10, 4, slave=5).registers == [7, 8, 9, 4711]
        assert client.read_holding_registers(9999, 2, slave=5).exception_code == 2
        assert client.read_holding_registers(0, 1, slave=0).exception_code == 1
        client.close()


ACCESS = """
    audit: gate.audit
    access:
      - {units: [1], functions: [read], rule: allow}
      - {units: [2, 3], area: holding_register, items: [0..9], rule: allow}
      - {units: [3], area: coil, rule: allow}
"""


def test_access_rules_and_the_audit_log_hold_for_relayed_units(gateway, pair, tmp_path):
    with Bus(pair.b) as bus:
        running, port = gateway(devices="", options=", response_timeout: 20s", access=ACCESS)

        def exchange(unit, pdu):
            with socket.create_connection(("127.0.0.1", port)) as connection:
                ask(connection, unit, bytes.fromhex(pdu))
                return receive(connection)[2].hex()

        assert exchange(1, "0300200001") == value(1, 0x20).hex()
        assert exchange(1, "0600050001") == "8601"
        assert exchange(3, "0600050007") == "0600050007"
        assert exchange(3, "0600200007") == "8601"
        assert exchange(2, "0600010008") == "0600010008"
        assert exchange(3, "050004FF00") == "8501", "the device has no coils"
        assert [pdu for _, pdu in bus.seen if pdu[0] == 6] == [bytes.fromhex("0600050007")]
        path = tmp_path / "project.yaml"
        path.write_text(path.read_text().replace("functions: [read]", "functions: [write]"))
        running.process.send_signal(signal.SIGHUP)
        until(lambda: exchange(1, "0300200001") == "8301", "the rules are read again")
        running.interrupt()
    log = [json.loads(line) for line in (tmp_path / "gate.audit").read_text().splitlines()]
    entries = [(e["event"], e["unit"], e["function"], e.get("start")) for e in log]
    assert entries[:5] == [("refused", 1, 6, 5), ("write", 3, 6, 5), ("refused", 3, 6, 32),
                           ("write", 2, 6, 1), ("refused", 3, 5, 4)]
    assert log[1]["request"] == "0600050007"
    assert (log[4]["why"], log[4]["exception"]) == ("exception", 1)
    assert {entry[0] for entry in entries[5:]} == {"refused"}


BYPASSES = """
    access:
      - {units: [1], functions: [read], rule: allow}
      - {units: [3], area: holding_register, items: [0], rule: deny}
      - {units: [3], area: holding_register, items: [10..19], rule: allow, rate: 1, burst: 5}
      - {units: [3], rule: allow}
"""


def test_what_the_rules_deny_never_reaches_the_line(gateway, pair):
    with Bus(pair.b) as bus:
        _, port = gateway(devices="", own="", units="0..20", options=", response_timeout: 20s",
                          access=BYPASSES)
        with socket.create_connection(("127.0.0.1", port)) as connection:

            def exchange(unit, pdu):
                ask(connection, unit, bytes.fromhex(pdu))
                return receive(connection)[2].hex()

            for unit, pdu in ((0, "0600050007"), (0, "10000500010200ff"), (0, "1500"), (100, "0600050007"),
                              (1, "2b0d000001"), (100, "2b0d000001"), (3, "10ffff00020400010002"),
                              (3, "4100010002"), (3, "2b0d000001"), (3, "17000a0001ffff00020400010002"),
                              (2, "0300050001"), (255, "0300050001")):
                assert exchange(unit, pdu) in (f"{int(pdu[:2], 16) | 0x80:02x}01",
                                               f"{int(pdu[:2], 16) | 0x80:02x}0a"), pdu
            assert not bus.seen
            assert exchange(100, "0300050001") == value(1, 5).hex()
            begun = time.monotonic()
            answers = [exchange(3, "10000900020400010002") for _ in range(30)]
            seconds = time.monotonic() - begun
        assert answers.count("9001") == sum(pdu[0] == 16
                                            for _, pdu in bus.seen), "the device knows no function 16"
        assert answers[:5] == ["9001"] * 5 and set(answers) == {"9001", "9006"}
        assert answers.count("9001") <= 5 + seconds, "the rate of the second rule counts too"


def answered_meanwhile(port):
    """A request without a route: earlier bytes of clients were read."""
    with socket.create_connection(("127.0.0.1", port)) as probe:
        ask(probe, 50, read(50, 1))
        assert receive(probe)[2] == b"\x83\x0a"


def test_the_audit_log_tells_what_became_of_relayed_writes(gateway, pair, tmp_path):
    with Bus(pair.b) as bus:
        bus.dead = {4}
        running, port = gateway(devices="", own="", units="0..20", options=", response_timeout: 2s",
                                access="    audit: gate.audit\n")
        with socket.create_connection(("127.0.0.1", port)) as connection:
            for unit, pdu in ((3, "0600050007"), (3, "050004ff00"), (4, "0600050007"), (0, "0600050007"),
                              (100, "0600060008"), (3, "060005000700")):
                ask(connection, unit, bytes.fromhex(pdu))
                receive(connection)
            bus.gate.clear()
            before = len(bus.seen)
            ask(connection, 1, read(1, 1))
            until(lambda: len(bus.seen) > before, "it is asked")
            going = socket.create_connection(("127.0.0.1", port))
            ask(going, 1, bytes.fromhex("0600060009"))
            answered_meanwhile(port)
            going.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # close() resets
            going.close()
            answered_meanwhile(port)
            bus.gate.set()
            receive(connection)
        running.interrupt()
        assert not any(pdu == bytes.fromhex("0600060009") for _, pdu in bus.seen)
    log = [json.loads(line) for line in (tmp_path / "gate.audit").read_text().splitlines()]
    got = [(e["event"], e["unit"], e["relayed_to"], e["outcome"], e.get("why"), e.get("exception"),
            e.get("broadcast")) for e in log]
    assert sorted(got, key=str) == sorted([("write", 3, 3, "done", None, None, None),
                                           ("refused", 3, 3, "refused", "exception", 1, None),
                                           ("write", 4, 4, "unknown", None, None, None),
                                           ("write", 0, 0, "sent", None, None, True),
                                           ("write", 100, 1, "done", None, None, None),
                                           ("refused", 3, 3, "not_sent", "exception", 3, None),
                                           ("refused", 1, 1, "not_sent", "disconnected", 0, None)], key=str)


def test_rules_that_are_read_again_stop_what_was_not_sent(gateway, pair, tmp_path):
    with Bus(pair.b) as bus:
        running, port = gateway(devices="", own="", units="0..20", options=", response_timeout: 20s",
                                access="    access:\n      - {rule: allow}\n")
        bus.gate.clear()
        with socket.create_connection(("127.0.0.1", port)) as reader, socket.create_connection(
            ("127.0.0.1", port)) as writer:
            ask(reader, 1, read(1, 1))
            until(lambda: bus.seen, "it is asked")
            ask(writer, 3, bytes.fromhex("0600050007"))
            answered_meanwhile(port)
            path = tmp_path / "project.yaml"
            path.write_text(path.read_text().replace("{rule: allow}", "{rule: read_only}"))
            running.process.send_signal(signal.SIGHUP)
            assert receive(writer)[2].hex() == "8601", "while the line is still taken"
            bus.gate.set()
            assert receive(reader)[2] == value(1, 1), "what was sent is answered"
        assert len(bus.seen) == 1
