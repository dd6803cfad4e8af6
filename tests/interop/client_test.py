"""`takt read`, `write`, `raw` and `run` with slaves that are not ours: libmodbus, pymodbus, modbus-serial and
jsmodbus; over TCP, RTU and ASCII."""
import contextlib
import sys

import pytest

import endpoints
from node_peer import node
from overheard import overheard
from program import PEERS, ROOT, Running, start, takt, until
from projects import serial, tcp

NODE = ["modbus_serial-tcp", "modbus_serial-rtu", "jsmodbus-tcp", "jsmodbus-rtu"]
FURTHER = ["libmodbus-tcp", "libmodbus-rtu", "pymodbus-tcp", "pymodbus-rtu",
           "pymodbus-ascii"]  # with functions 22 and 23
SLAVES = FURTHER + NODE


def slave_program(maker, framing, endpoint, unit):
    if maker in ("modbus_serial", "jsmodbus"):
        return node(f"{maker}_server", framing, endpoint, unit)
    command = [PEERS / "libmodbus_server"
               ] if maker == "libmodbus" else [sys.executable, ROOT / "tests/peers/pymodbus_server.py"]
    settings = ["19200", "E"] if (maker, framing) == ("libmodbus", "rtu") else []
    return Running([*command, framing, endpoint, *settings, unit])


@pytest.fixture(scope="module")
def slave_target(tmp_path_factory):
    """Call it with a kind, get the target of its slave, the same for all tests of the file: each test writes
    registers of its own."""
    made = {}
    with contextlib.ExitStack() as stack:

        def target(kind):
            if kind not in made:
                pair = None
                if not kind.endswith("tcp"):
                    pair = stack.enter_context(endpoints.serial_pair(tmp_path_factory.mktemp(kind)))
                made[kind] = stack.enter_context(slave(kind, pair))
            return made[kind]

        yield target


@contextlib.contextmanager
def slave(kind, pair, unit=1):
    """A slave of that kind, filled with the ramp; gives the target for takt."""
    maker, framing = kind.split("-")
    endpoint = endpoints.free_port() if framing == "tcp" else pair.b
    with slave_program(maker, framing, endpoint, unit) as peer:
        peer.wait_line(lambda line: line == "ready", "ready")
        with overheard(framing, endpoint if framing == "tcp" else pair.a, pair) as tapped:
            if framing == "tcp":
                yield f"tcp://127.0.0.1:{tapped}"
            else:
                yield f"{framing}://{tapped}?baud=19200&parity=even" + ("&data_bits=7"
                                                                        if framing == "ascii" else "")


PATIENT = ("--timeout", "30s")  # the peers are slow on a busy machine


def read(target, *arguments):
    return takt("read", target, *PATIENT, *arguments, "--json").json["values"]


def write(target, *arguments):
    takt("write", target, *PATIENT, *arguments)


def raw(target, request, code=0):
    return takt("raw", target, *PATIENT, request, code=code).out.strip()


@pytest.mark.parametrize("kind", SLAVES)
def test_read_and_write(slave_target, kind):
    target = slave_target(kind)
    for area in ("holding", "input"):
        assert read(target, area, 300, 5) == [300, 301, 302, 303, 304]
    for area in ("coils", "discrete"):
        assert [int(v) for v in read(target, area, 5, 11)] == [a & 1 for a in range(5, 16)]
    write(target, "holding", 210, 4711)
    write(target, "holding", 211, 1, 2, 3)
    assert read(target, "holding", 209, 6) == [209, 4711, 1, 2, 3, 214]
    write(target, "coils", 20, 1)
    write(target, "coils", 21, 0, 1, 1)
    assert [int(v) for v in read(target, "coils", 20, 5)] == [1, 0, 1, 1, 0]
    write(target, "--type", "float", "holding", 100, "2.5")
    assert read(target, "--type", "float", "holding", 100) == [2.5]


@pytest.mark.parametrize("kind", SLAVES)
def test_many_values(slave_target, kind):
    target = slave_target(kind)
    assert read(target, "holding", 1001, 300) == list(range(1001, 1301))
    assert [int(v) for v in read(target, "coils", 1001, 2500)] == [a & 1 for a in range(1001, 3501)]


@pytest.mark.parametrize("kind", FURTHER)
def test_raw(slave_target, kind):
    """Mask write and read/write, the examples of the Modbus specification; function 0x11 returns the id of
    libmodbus."""
    target = slave_target(kind)
    write(target, "holding", 4, 0x12)
    assert raw(target, "16 0004 00F2 0025") == "16 00 04 00 F2 00 25"
    assert read(target, "holding", 4) == [0x17]
    answer = raw(target, "17 0003 0006 000E 0003 06 00FF 00FF 00FF")
    assert answer == "17 0C 00 03 00 17 00 05 00 06 00 07 00 08"
    assert read(target, "holding", 14, 3) == [0xFF] * 3
    if kind.startswith("libmodbus"):
        assert raw(target, "11").split()[0] == "11"


@pytest.mark.parametrize("kind", [kind for kind in SLAVES if not kind.startswith("jsmodbus")])
def test_a_refusal(slave_target, kind):
    target = slave_target(kind)
    result = takt("read", target, *PATIENT, "holding", 9999, 2, code=5)
    assert "2" in result.err
    assert read(target, "holding", 9999) == [9999], "and it goes on"


@pytest.mark.parametrize("kind", ["pymodbus-rtu", "pymodbus-ascii", "modbus_serial-rtu"])
def test_another_unit_is_silent(slave_target, kind):
    """Not libmodbus and jsmodbus: see docs/interop.md."""
    target = slave_target(kind)
    takt("read", target, "--unit", 9, "--timeout", "200ms", "holding", 0, code=4)
    assert read(target, "holding", 7) == [7], "and the line goes on"


# The further functions of pymodbus, and what it answers; it keeps neither files nor queues.
PYMODBUS_ANSWERS = [
    ("07", "07 00"),
    ("08 0000 A537", "08 00 00 A5 37"),
    ("08 0001 0000", "08 00 01 00 00"),
    ("08 0002 0000", "08 00 02 00 00"),
    ("08 0003 0A00", "08 00 03 0A 00"),
    ("08 000A 0000", "08 00 0A 00 00"),
    ("08 000B 0000", "08 00 0B 00 00"),
    ("08 000C 0000", "08 00 0C 00 00"),
    ("08 000D 0000", "08 00 0D 00 00"),
    ("08 000E 0000", "08 00 0E 00 00"),
    ("08 000F 0000", "08 00 0F 00 00"),
    ("08 0010 0000", "08 00 10 00 00"),
    ("08 0011 0000", "08 00 11 00 00"),
    ("08 0012 0000", "08 00 12 00 00"),
    ("08 0014 0000", "08 00 14 00 00"),
    ("0B", "0B 00 00 00 00"),
    ("0C", "0C 06 00 00 00 00 00 00"),
    ("11", "11 09 50 79 6D 6F 64 62 75 73 FF"),
    ("15 09 06 0004 0007 0001 06AF", "15 09 06 00 04 00 07 00 01 06 AF"),
    ("18 04DE", "18 00 02 00 00"),
    ("2B 0E 01 00", "2B 0E 01 83 00 00 00"),
]


@pytest.mark.parametrize("kind", ["pymodbus-tcp", "pymodbus-rtu", "pymodbus-ascii"])
def test_raw_of_pymodbus(slave_target, kind):
    target = slave_target(kind)
    for request, answer in PYMODBUS_ANSWERS:
        assert raw(target, request) == answer, request
    takt("raw", target, "--timeout", "3s", "14 07 06 0004 0001 0002", code=6)  # its answer has no records
    assert read(target, "holding", 7) == [7], "and it goes on"


@pytest.mark.parametrize("kind", NODE)
def test_raw_of_slaves_from_npm(slave_target, kind):
    """Their only further function is 43/14."""
    target = slave_target(kind)
    objects = {0: b"Acme", 1: b"T1", 2: b"1.0", 5: b"Model M"}
    assert bytes.fromhex(raw(target, "2B 0E 02 00")) == b"\x2b\x0e\x02\x82\0\0\x04" + b"".join(
        bytes([number, len(text)]) + text for number, text in objects.items())
    if kind.startswith("modbus_serial"):
        assert raw(target, "16 0004 00F2 0025", code=5) == "96 01"
        assert raw(target, "2B 0E 04 09", code=5) == "AB 02"
    assert read(target, "holding", 7) == [7]


@pytest.mark.parametrize("kind", ["jsmodbus-tcp", "jsmodbus-rtu"])
def test_a_short_answer_is_reported(slave_target, kind):
    """jsmodbus answers with what it has of what is asked for, and without an exception."""
    target = slave_target(kind)
    for start, count in (9999, 2), (20000, 1):
        takt("read", target, "--timeout", "3s", "holding", start, count, code=6)
    assert read(target, "holding", 9999) == [9999], "and it goes on"


def test_rtu_over_tcp(pair):
    """socat as the box between a network and a serial line, libmodbus behind it."""
    port = endpoints.free_port()
    with slave("libmodbus-rtu", pair), Running(
        ["socat", f"TCP-LISTEN:{port},bind=127.0.0.1,reuseaddr", f"{pair.a},raw,echo=0"]):
        command = ["read", f"rtu+tcp://127.0.0.1:{port}", *PATIENT, "holding", 1, 300, "--json"]
        done = until(lambda: (r := takt(*command, code=None)).code != 3 and r, "a connection")
    assert done.code == 0, done
    assert done.json["values"] == list(range(1, 301))


VARIABLES = [
    "name: Word, type: uint16, register: 300, read: 0x03",
    "name: Next, type: uint16, register: 301, read: 0x03",
    "name: Input, type: int16, register: 77, read: 0x04",
    "name: Long, type: uint32, register: 2, read: 0x03",  # registers 2, 3: 2 + 3 * 65536
    "name: Odd, type: bool, coil: 33, read: 0x01",
    "name: Even, type: bool, coil: 34, read: 0x02",
    "name: Bit, type: bool, register: 4096, bit: 12, read: 0x03",  # register 4096 holds 0x1000
    "name: Scaled, type: int16, register: 250, read: 0x03, scale: 0.1, offset: -5",
    "name: Given, type: float, register: 500, read: 0x03, write: 0x10, write_on_change: true",
]
VALUES = {
    "Word": 300,
    "Next": 301,
    "Input": 77,
    "Long": 196610,
    "Odd": True,
    "Even": False,
    "Bit": True,
    "Scaled": 20.0
}


@pytest.mark.parametrize("kind", SLAVES)
def test_run_polls_and_writes(project, slave_target, kind):
    target, framing = slave_target(kind), kind.split("-")[1]
    if framing == "tcp":
        text = tcp(VARIABLES, int(target.rsplit(":")[-1]))
    else:
        port = target.split("://")[1].split("?")[0]
        text = serial(VARIABLES, port=port, framing=framing, address=1) \
            .replace("baud: 115200", "baud: 19200").replace("parity: none", "parity: even")
    is_value = lambda e, name, value: e["event"] == "value" and e["name"] == name and e["quality"] == "good" \
        and e["value"] == pytest.approx(value)
    with start("run", project(text), "--json", "--stdin") as run:
        for name, value in VALUES.items():
            run.wait_event(lambda e, n=name, v=value: is_value(e, n, v), f"{name} = {value}")
        run.send("set Given -12.5")
        run.wait_event(lambda e: is_value(e, "Given", -12.5), "the written value read back")
        run.interrupt()
    assert read(target, "--type", "float", "holding", 500) == [-12.5]
