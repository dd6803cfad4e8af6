"""docs/specification.md, section 9: an acknowledged write survives a restart, however the server ended."""
import contextlib
import json
import os
import random
import resource
import socket
import struct
import threading
import time

import serial as pyserial

import endpoints
from frames import crc16
from program import DEADLINE, start, takt, until
from projects import slave

LIVES = int(os.environ.get("TAKT_KILLS", "12"))  # thousands of them: TAKT_KILLS=2000
SLICE = 8  # registers of each client: it writes the same number to all of them at once


def exchange(connection, transaction, pdu):
    body = bytes([1]) + pdu
    connection.sendall(struct.pack(">HHH", transaction & 0xFFFF, 0, len(body)) + body)
    head = connection.recv(6, socket.MSG_WAITALL)
    if len(head) < 6:
        raise ConnectionError
    answer = connection.recv(struct.unpack(">HHH", head)[2], socket.MSG_WAITALL)
    if len(answer) < 3:
        raise ConnectionError
    return answer[1:]


def ask(port, pdu):
    with socket.create_connection(("127.0.0.1", port), timeout=DEADLINE) as connection:
        return exchange(connection, 1, bytes.fromhex(pdu) if isinstance(pdu, str) else pdu)


def read(port, first, count):
    answer = ask(port, struct.pack(">BHH", 3, first, count))
    assert answer[0] == 3, answer.hex()
    return struct.unpack(f">{count}H", answer[2:])


def write_pdu(number, first, values):
    return struct.pack(">BHHB", 16, first, len(values), 2 * len(values)) + struct.pack(
        f">{len(values)}H", *values)


def retaining(state, place, retain="0..99", coils="", durability="ack"):
    """A project beside its file of retained registers."""
    banks = (f"banks: [{{area: holding_register, items: [0..65535], retain: [{retain}]}}, "
             f"{{area: coil, items: [0..1023]{coils}}}]")
    path = state.with_suffix(".yaml")
    path.write_text(slave(place, [f"state: {state}", f"durability: '{durability}'"], banks), encoding="utf-8")
    return path


def on_port(port):
    return ["listen: 127.0.0.1", f"tcp_port: {port}"]


@contextlib.contextmanager
def keeping(state, *options, port=None, retain="0..99", coils="", durability="ack", **popen):
    port = port or endpoints.free_port()
    path = retaining(state, on_port(port), retain, coils, durability)
    with start("serve", path, *options, **popen) as device:
        until(lambda: any("serving" in line for line in device.err), f"that it serves: {device!r}")
        yield port, device


class Writer(threading.Thread):
    """Writes 1, 2, 3, … to its own registers, and knows what was sent and what was acknowledged."""

    def __init__(self, port, first, last):
        super().__init__(daemon=True)
        self.port, self.first, self.sent, self.acknowledged = port, first, last, last

    def run(self):
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", self.port),
                                                                    timeout=DEADLINE) as connection:
            while True:
                self.sent += 1
                answer = exchange(connection, self.sent, write_pdu(16, self.first,
                                                                   [self.sent % 65536] * SLICE))
                assert answer[0] == 16, answer.hex()
                self.acknowledged = self.sent


def test_acknowledged_writes_survive_kills(tmp_path):
    chance = random.Random(20261121)
    state = tmp_path / "registers"
    endpoint = endpoints.free_port()
    last = [0] * 4
    written = 0
    for life in range(LIVES):
        with keeping(state, port=endpoint) as (port, device):
            for client, value in enumerate(last):
                found = read(port, client * SLICE, SLICE)
                assert set(found) == {value % 65536}, (life, client, value, found)
            writers = [Writer(port, client * SLICE, value) for client, value in enumerate(last)]
            for writer in writers:
                writer.start()
            until(
                lambda: all(w.acknowledged > w.sent - 2 and w.acknowledged > last[i]
                            for i, w in enumerate(writers)), "each wrote")
            time.sleep(chance.random() * 0.05)
            device.process.kill()
            for writer in writers:
                writer.join(DEADLINE)
        with keeping(state, port=endpoint) as (port, device):
            for client, writer in enumerate(writers):
                found = read(port, client * SLICE, SLICE)
                assert len(set(found)) == 1, f"a mixture of two requests: {found}"
                kept = [n for n in range(writer.acknowledged, writer.sent + 1) if n % 65536 == found[0]]
                assert kept, (life, writer.acknowledged, found, writer.sent)
                last[client] = kept[0]
            device.process.kill()
        written += sum(writer.acknowledged for writer in writers)
    assert written > 0


def test_acknowledged_writes_survive_kills_on_a_serial_line(tmp_path):
    state = tmp_path / "registers"
    last = 0
    with endpoints.serial_pair(tmp_path) as pair:
        for _ in range(4):
            path = retaining(state, ["transport: serial", f"port: {pair.b}", "baud: 115200"], "0..9")
            with start("serve", path) as device, \
                    pyserial.Serial(pair.a, 115200, timeout=DEADLINE) as port:
                until(lambda: any("serving" in line for line in device.err), "that it serves")
                body = bytes.fromhex("010300000001")
                port.write(body + crc16(body))
                answer = port.read(7)
                assert struct.unpack(">H", answer[3:5])[0] == last
                for _ in range(10):
                    last += 1
                    frame = struct.pack(">BBHH", 1, 6, 0, last)
                    port.write(frame + crc16(frame))
                    assert port.read(8) == frame + crc16(frame)
                device.process.kill()


def test_every_function_and_overlaid_coils(tmp_path):
    state = tmp_path / "registers"
    writes = [
        "06 0000 1234", "10 0001 0002 04 5678 9ABC", "16 0003 0000 00FF", "17 0000 0001 0004 0001 02 0BAD",
        "05 0050 FF00", "0F 0061 0003 01 05"
    ]  # coils 80 (register 5, bit 0), 97..99 (register 6, bits 1..3)
    with keeping(state, coils=", overlay: holding_register") as (port, device):
        for pdu in writes:
            assert ask(port, pdu)[0] < 0x80, pdu
        device.process.kill()
    with keeping(state, coils=", overlay: holding_register") as (port, device):
        assert read(port, 0, 7) == (0x1234, 0x5678, 0x9ABC, 0x00FF, 0x0BAD, 1, 0b1010)
        device.interrupt()


def test_coils_and_items_without_retain(tmp_path):
    state = tmp_path / "registers"
    with keeping(state, coils=", retain: [3..20]") as (port, device):
        for pdu in ("05 0004 FF00", "0F 0012 0004 01 0F", "06 0063 0007", "06 0064 0008"):
            assert ask(port, pdu)[0] < 0x80
        device.process.kill()
    with keeping(state, coils=", retain: [3..20]") as (port, device):
        assert ask(port, "01 0000 0018") == bytes.fromhex("01 03 10 00 1C")
        assert read(port, 99, 2) == (7, 0)
        device.interrupt()


def test_a_failing_disk_refuses_and_takes_back(tmp_path):
    state = tmp_path / "registers"
    with keeping(state, restore_signals=False) as (port, device):  # SIGXFSZ stays ignored
        assert ask(port, "06 0000 0001")[0] == 6
        unlimited = resource.prlimit(device.process.pid, resource.RLIMIT_FSIZE)
        resource.prlimit(device.process.pid, resource.RLIMIT_FSIZE, (1024, unlimited[1]))
        assert ask(port, "06 0000 0002") == bytes([0x86, 4])
        assert read(port, 0, 1) == (1, )
        assert ask(port, "10 0000 0002 04 0003 0003") == bytes([0x90, 4])
        assert read(port, 0, 2) == (1, 0)
        resource.prlimit(device.process.pid, resource.RLIMIT_FSIZE, unlimited)
        assert ask(port, "06 0001 0004")[0] == 6
        device.process.kill()
        device.process.wait()
        assert any("exception 4" in line for line in device.err), repr(device)
    with keeping(state) as (port, device):
        assert read(port, 0, 2) == (1, 4)
        device.interrupt()


def test_durability_none_writes_at_the_end_and_counts(tmp_path):
    state = tmp_path / "registers"
    with keeping(state, "--json", durability="none") as (port, device):
        for number in range(1, 20):
            assert ask(port, write_pdu(16, 0, [number]))[0] == 16
        result = device.interrupt()
    assert result.json["retained"] == [{
        "unit": 1,
        "file": str(state),
        "commits": 1,
        "bytes": 3 * 4096,
        "failures": 0
    }]
    with keeping(state, durability="100ms") as (port, device):
        assert read(port, 0, 1) == (19, )
        assert ask(port, "06 0000 0042")[0] == 6
        device.interrupt()
    with keeping(state) as (port, device):
        assert read(port, 0, 1) == (0x42, )
        device.interrupt()


def test_the_state_of_the_file_is_reported(tmp_path):
    state = tmp_path / "registers"
    with keeping(state) as (port, device):
        assert ask(port, "06 0005 0007")[0] == 6
        assert any("new file" in line for line in device.err)
        second = takt("serve", retaining(state, on_port(endpoints.free_port())), "--for", "1s", code=3)
        assert str(state) in second.err
        device.interrupt()
    whole = state.read_bytes()
    with keeping(state, retain="5..9") as (port, device):  # another layout
        assert read(port, 5, 1) == (7, )
        assert any("5 retained items were taken over" in line for line in device.err), repr(device)
        device.interrupt()
    assert (tmp_path / "registers.old-1").read_bytes() == whole
    torn = bytearray(whole)  # the newer copy is the second
    torn[8192 + 40] ^= 1
    state.write_bytes(torn)
    with keeping(state) as (port, device):
        assert read(port, 5, 1) == (0, )
        assert any("one copy" in line for line in device.err), repr(device)
        device.process.kill()
    torn[4096 + 40] ^= 1
    state.write_bytes(torn)
    with keeping(state) as (port, device):
        assert read(port, 5, 1) == (0, )
        assert any("is damaged and was kept" in line for line in device.err), repr(device)
        device.interrupt()
    assert (tmp_path / "registers.damaged-1").read_bytes() == bytes(torn)
    for lines in (1, 2000):
        state.write_text("not registers\n" * lines)
        foreign = takt("serve", retaining(state, on_port(endpoints.free_port())), code=2)
        assert "not a file of retained registers" in foreign.err
        assert state.read_text() == "not registers\n" * lines
    state.unlink()
    os.mkfifo(state)
    foreign = takt("serve", retaining(state, on_port(endpoints.free_port())), code=2)
    assert "not a file of retained registers" in foreign.err and state.is_fifo()


def test_servers_of_a_project(project, tmp_path):
    port = endpoints.free_port()
    path = project(f"""
takt: 1
servers:
  - name: plant
    listen: 127.0.0.1
    tcp_port: {port}
    units:
      - address: 1
        durability: ack
        banks:
          - {{area: holding_register, items: [0..9, 100..109], retain: [5..9, 100..101]}}
          - {{area: coil, items: [0..7], retain: [0..7]}}
        variables:
          - {{name: Setpoint, type: int, area: holding_register, register: 100, default: 33}}
      - address: 2
        state: second.registers
        banks: [{{area: holding_register, items: [0..1], retain: [0]}}]
""")
    for expected, kept in (((33, 0), 0), ((1, 2), 3)):
        with start("serve", path) as device:
            endpoints.wait_listening(port, device)
            assert read(port, 100, 2) == expected
            assert ask(port, "01 0000 0008")[2] == (0x80 if kept else 0)
            for pdu in ("10 0064 0002 04 0001 0002", "05 0007 FF00", "06 0004 0009"):
                assert ask(port, pdu)[0] < 0x80
            takt("write", f"tcp://127.0.0.1:{port}", "--unit", 2, "holding", 0, 3)
            device.process.kill()
    assert (tmp_path / "project.plant-1.registers").exists() and (tmp_path / "second.registers").exists()
    with start("serve", path, "--json") as device:
        endpoints.wait_listening(port, device)
        assert takt("read", f"tcp://127.0.0.1:{port}", "--unit", 2, "holding", 0, 2).out.split()[-1] == "0"
        assert read(port, 4, 1) == (0, ), "not retained"
        summary = json.loads(device.interrupt().out)
        assert [unit["unit"] for unit in summary["retained"]] == [1, 2]
