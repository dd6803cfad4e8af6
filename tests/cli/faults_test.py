"""`takt serve --fault` and faults switched over the control socket."""
import socket
import struct
import time

import pytest
import serial as pyserial

import endpoints
from frames import crc16, request
from program import start, takt


class Raw:
    """A master that sees the bytes: `ask()` gives what came within `patience` seconds."""

    def __init__(self, port):
        self._socket = socket.create_connection(("127.0.0.1", port))

    def ask(self, patience=5.0):
        self._socket.sendall(bytes.fromhex("0001 0000 0006 01 03 0000 0001"))
        self._socket.settimeout(patience)
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
        assert Raw(port).ask(0.3 if fault == "silence" else 5.0) == bytes.fromhex(answer)
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
        with pyserial.Serial(pair.a, timeout=20) as line:
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
        assert struct.unpack(">B", raw.ask()[6:7]) == (2,)
        for bad in (("fault",), ("fault", "add"), ("fault", "add", "dog"), ("set", "a", "1"), ("fault", "clear", "x")):
            assert "error syntax" in takt("ctl", control, *bad, code=1).out
        takt("ctl", control, "quit")
        running.finish()


def test_a_fault_that_is_none(tmp_path):
    assert "delay=50ms..2s" in takt("serve", "--listen", "127.0.0.1:0", "--fault", "dog", code=2).err
