"""`takt serve --fault` and faults switched over the control socket."""
import socket
import struct
import time

import pytest
import serial as pyserial

import endpoints
from frames import crc16, request
from program import DEADLINE, start, takt


class Raw:
    """A master that sees the bytes: `ask()` gives what came within so many seconds."""

    def __init__(self, port):
        self._socket = socket.create_connection(("127.0.0.1", port))

    def ask(self, seconds=DEADLINE):
        self._socket.sendall(bytes.fromhex("0001 0000 0006 01 03 0000 0001"))
        self._socket.settimeout(seconds)
        try:
            return self._socket.recv(100)
        except TimeoutError:
            return b""


GOOD = bytes.fromhex("0001 0000 0005 01 03 02 0000")


def serve(*options):
    port = endpoints.free_port()
    running = start("serve", "--listen", f"127.0.0.1:{port}", *options)
    endpoints.wait_listening(port, running)
    return running, port


@pytest.mark.parametrize("fault, answer", [
    ("exception=6", "0001 0000 0003 01 83 06"),
    ("wrong_unit", "0001 0000 0005 02 03 02 0000"),
    ("cut", "0001 0000 0005"),
    ("silence", ""),
    ("bad_crc", GOOD.hex()),
    ("silence:0%", GOOD.hex()),
    ("silence@1h", GOOD.hex()),
])
def test_over_tcp(fault, answer):
    running, port = serve("--fault", fault)
    with running:
        assert Raw(port).ask(0.3 if fault == "silence" else DEADLINE) == bytes.fromhex(answer)
        running.interrupt()


def test_a_delay(tmp_path):
    running, port = serve("--fault", "delay=150ms..200ms")
    with running:
        begun = time.monotonic()
        assert Raw(port).ask() == GOOD
        assert time.monotonic() - begun >= 0.15
        running.interrupt()


@pytest.mark.parametrize("fault, change", [
    ("bad_crc", lambda frame: frame[:-1] + bytes([frame[-1] ^ 0xFF])),
    ("wrong_unit", lambda frame: request("rtu", 10, frame[1:-2])),
    ("cut", lambda frame: frame[:(len(frame) + 1) // 2]),
    ("exception=2", lambda frame: request("rtu", 9, "83 02")),
])
def test_on_a_serial_line(pair, fault, change):
    with start("serve", "--port", pair.b, "--unit", 9, "--control", pair.b + ".control") as running:
        endpoints.wait_slave(pair.a, 9, "rtu", running)
        takt("ctl", pair.b + ".control", "fault", "add", fault)
        good = request("rtu", 9, "03 02 00 00")
        assert good[-2:] == crc16(good[:-2])
        wanted = change(good)
        with pyserial.Serial(pair.a, timeout=DEADLINE) as line:
            line.write(request("rtu", 9, "03 0000 0001"))
            assert line.read(len(wanted)) == wanted
            line.timeout = 0.1
            assert line.read(1) == b""
        running.interrupt()


def test_switched_while_it_runs(tmp_path):
    control = tmp_path / "control"
    running, port = serve("--control", control, "--fault", "exception=4")
    with running:
        raw = Raw(port)
        assert raw.ask()[7] == 0x83
        assert takt("ctl", control, "fault", "list").out == "ok exception=4\n"
        assert takt("ctl", control, "fault", "clear").out == "ok\n"
        assert raw.ask() == GOOD
        assert takt("ctl", control, "fault", "add", "wrong_unit:100%").out == "ok wrong_unit\n"
        assert takt("ctl", control, "fault", "add", "delay=1ms@1min").out == "ok wrong_unit delay=1ms@60s\n"
        assert struct.unpack(">B", raw.ask()[6:7]) == (2, )
        for bad in (("fault", ), ("fault", "add"), ("fault", "add", "dog"), ("set", "a", "1"),
                    ("fault", "clear", "x")):
            assert "error syntax" in takt("ctl", control, *bad, code=2).out
        takt("ctl", control, "quit")
        running.finish()


def test_a_fault_that_is_none(tmp_path):
    assert "delay=50ms..2s" in takt("serve", "--listen", "127.0.0.1:0", "--fault", "dog", code=2).err


PLANT = """\
takt: 1
lines:
  - name: A
    transport: tcp
    host: 127.0.0.1
    tcp_port: {first}
    framing: tcp
    devices:
      - name: Meter
        address: 1
        variables:
          - {{name: Pressure, type: float, register: 0, read: 0x03, scale: 0.1, byte_order: ABCD}}
          - {{name: Count, type: int, register: 10, read: 0x03}}
      - {{name: Boiler 2, address: 2, variables: [{{name: T 1, type: int, register: 0, read: 0x03}}]}}
  - name: B
    transport: tcp
    host: 127.0.0.1
    tcp_port: {second}
    framing: tcp
    devices:
      - {{name: Meter, address: 1, variables: [{{name: Level, type: int, register: 0, read: 0x03}}]}}
"""


@pytest.fixture
def plant(project, tmp_path):
    """`takt serve` as the devices of two lines, with commands from its standard input and a socket."""
    ports = endpoints.free_port(), endpoints.free_port()
    path = project(PLANT.format(first=ports[0], second=ports[1]))
    control = tmp_path / "control"
    with start("serve", path, "--stdin", "--control", control) as running:
        for port in ports:
            endpoints.wait_listening(port, running)
        yield running, ports, control, path
        if running.process.poll() is None:
            running.interrupt()


def ask(running, command):
    """The answer to a command on standard input."""
    before = len(running.out)
    running.send(command)
    return running.wait_line(lambda line: True, f"an answer to {command}", after=before)


def read(port, unit, start=0, *options, code=0):
    """The JSON of a read of one value."""
    timeout = "300ms" if code == 4 else "20s"
    return takt("read", f"tcp://127.0.0.1:{port}", "--unit", unit, "holding", start, "--timeout", timeout,
                "--json", *options, code=code).json


def test_a_fault_of_one_device(plant):
    running, (first, second), control, _ = plant
    assert ask(running, "fault add A/Meter:silence") == "ok A/Meter:silence"
    read(first, 1, code=4)
    read(first, 255, code=4)  # the host itself is its first device
    assert "error" not in read(first, 2) and "error" not in read(second, 1), "the other devices answer"
    assert takt("ctl", control, "fault", "add",
                "Boiler 2:exception=6").out == 'ok A/Meter:silence "Boiler 2":exception=6\n'
    read(first, 2, code=5)
    assert ask(running, "fault clear A/Meter") == 'ok "Boiler 2":exception=6'
    assert "error" not in read(first, 1)


def test_a_fault_of_one_variable(plant):
    running, (first, _), _, _ = plant
    assert ask(running, "fault add Pressure:exception=4") == "ok Pressure:exception=4"
    assert "exception 4" in read(first, 1, 1, code=5)["error"]["text"], "a register of it"
    assert "error" not in read(first, 1, 10), "another variable of the device"
    assert "error syntax" in ask(running, "fault add Pressure:bad_crc")


def test_a_value_of_one_variable(plant):
    running, (first, _), control, _ = plant
    assert ask(running, "set Pressure 5") == "ok Pressure 5"
    arguments = "--type", "float", "--order", "ABCD"
    assert read(first, 1, 0, *arguments)["values"] == [50.0], "by its scale and its byte order"
    assert takt("ctl", control, "set", "T 1", "-7").out == 'ok "T 1" -7\n'
    assert read(first, 2, 0, "--type", "int16")["values"] == [-7]
    assert takt("ctl", control, "--json", "get", "Pressure").json["value"] == 5
    assert read(first, 1, 0, *arguments)["values"] == [50.0], "it does not move any more"
    assert "error overflow" in ask(running, "set Count 70000")
    assert "error not_found" in ask(running, "set Nothing 1")
    assert "A/Meter, B/Meter" in ask(running, "fault add Meter:silence")
    running.send("quit")
    running.finish()


@pytest.mark.parametrize("framing", ["rtu", "ascii"])
def test_a_damaged_frame_of_one_device_on_a_serial_line(project, pair, framing):
    path = project(f"""\
takt: 1
lines:
  - name: L
    port: {pair.b}
    framing: {framing}
    baud: 19200
    parity: none
    data_bits: {7 if framing == "ascii" else 8}
    stop_bits: {2 if framing == "ascii" else 1}
    devices:
      - {{name: Good, address: 17, variables: [{{name: G, type: int, register: 0, read: 0x03}}]}}
      - {{name: Bad, address: 27, variables: [{{name: X, type: int, register: 0, read: 0x03}}]}}
""")
    with start("serve", path, "--stdin") as running:
        endpoints.wait_slave(pair.a, 17, framing, running)
        assert ask(running, "fault add Bad:bad_crc") == "ok Bad:bad_crc"
        ask(running, "set G 4711")
        url = f"{framing}://{pair.a}?baud=19200&parity=none" + ("&stop_bits=2" if framing == "ascii" else "")
        assert takt("read", url, "--unit", 17, "holding", 0, "--json", "--timeout",
                    "20s").json["values"] == [4711]
        takt("read", url, "--unit", 27, "holding", 0, "--timeout", "5s", code=6)
        running.interrupt()


def test_the_devices_of_one_line(plant, project):
    running, (first, second), _, path = plant
    running.interrupt()
    with start("serve", path, "--line", "B") as one:
        endpoints.wait_listening(second, one)
        assert "error" not in read(second, 1)
        takt("read", f"tcp://127.0.0.1:{first}", "holding", 0, code=3)
        one.interrupt()
    other = endpoints.free_port()
    assert "--line" in takt("serve", path, "--listen", f"127.0.0.1:{other}", code=2).err
    with start("serve", path, "--line", "A", "--listen", f"127.0.0.1:{other}") as one:
        endpoints.wait_listening(other, one)
        assert "error" not in read(other, 2)
        one.interrupt()
    assert "A, B" in takt("serve", path, "--line", "C", code=2).err
