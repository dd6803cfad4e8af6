"""`takt serve` with masters that are not ours: mbpoll, libmodbus, pymodbus; over TCP, RTU and ASCII."""
import contextlib
import re
import subprocess

import pytest

import endpoints
from frames import request, split_rtu
from overheard import overheard
from program import DEADLINE, PEERS, start, takt
from projects import at, tcp

BAUD = "19200"  # 19200 8E1, the field's default


@contextlib.contextmanager
def device(framing, pair, fill="ramp"):
    """A blank device, unit 1; gives the endpoint a master opens: a TCP port or the near end of the serial
    pair."""
    if framing == "tcp":
        endpoint = endpoints.free_port()
        command = ["--listen", f"127.0.0.1:{endpoint}"]
    else:
        endpoint = pair.a
        command = [
            "--port",
            f"{framing}://{pair.b}?baud={BAUD}&parity=even" + ("&data_bits=7" if framing == "ascii" else "")
        ]
    with start("serve", *command, "--unit", 1, "--fill", fill) as running:
        if framing == "tcp":
            endpoints.wait_listening(endpoint, running)
        else:
            endpoints.wait_slave(endpoint, 1, framing, running)
        with overheard(framing, endpoint, pair) as tapped:
            yield tapped
        running.interrupt()


# --- libmodbus


@pytest.mark.parametrize("framing", ["tcp", "rtu"])
def test_libmodbus_client(pair, framing):
    with device(framing, pair) as endpoint:
        arguments = ["tcp", "127.0.0.1", endpoint, 1] if framing == "tcp" else ["rtu", endpoint, BAUD, "E", 1]
        done = subprocess.run([str(PEERS / "libmodbus_client"), *map(str, arguments)], capture_output=True,
                              timeout=DEADLINE, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("unit", [0, 255])
def test_units_0_and_255_address_the_tcp_server_itself(pair, unit):
    """docs/specification.md, section 8."""
    with device("tcp", pair) as endpoint:
        done = subprocess.run(
            [str(PEERS / "libmodbus_client"), "tcp", "127.0.0.1",
             str(endpoint), str(unit)], capture_output=True, timeout=DEADLINE, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


# --- broadcast, which none of the peers can do


def test_a_broadcast_is_done_and_not_answered(pair):
    with device("rtu", pair, fill="zero") as endpoint:
        answered = len(pair.answered())
        takt("write", f"rtu://{endpoint}", "--unit", 0, "holding", 3, 4711)
        assert takt("read", f"rtu://{endpoint}", "holding", 3, "--json").json["values"] == [4711]
        assert split_rtu(pair.answered()[answered:], [7]) == [request("rtu", 1, "03 02 1267")]


# --- mbpoll


def mbpoll(framing, endpoint, *arguments):
    """Runs mbpoll once with zero-based references; gives {reference: value} of what it printed."""
    where = ["-m", "tcp", "-p", str(endpoint), "127.0.0.1"] if framing == "tcp" \
        else ["-m", "rtu", "-b", BAUD, "-P", "even", str(endpoint)]
    done = subprocess.run([
        "mbpoll", "-0", "-1", "-a", "1", "-o", "5", *where[:-1], *map(str, arguments[0]), where[-1],
        *map(str, arguments[1:])
    ], capture_output=True, timeout=DEADLINE, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return {int(r): v for r, v in re.findall(r"^\[(\d+)\]:\s+(\S+)", done.stdout, re.MULTILINE)}


@pytest.mark.parametrize("framing", ["tcp", "rtu"])
def test_mbpoll(pair, framing):
    with device(framing, pair) as endpoint:
        for area in (3, 4):
            assert mbpoll(framing, endpoint,
                          ["-t", area, "-r", 40, "-c", 125]) == {r: str(r)
                                                                 for r in range(40, 165)}
        for area in (0, 1):
            assert mbpoll(framing, endpoint,
                          ["-t", area, "-r", 3, "-c", 100]) == {r: str(r & 1)
                                                                for r in range(3, 103)}
        mbpoll(framing, endpoint, ["-t", 4, "-r", 500], 4711)
        mbpoll(framing, endpoint, ["-t", 4, "-r", 501], 1, 2, 3)
        assert mbpoll(framing, endpoint, ["-t", 4, "-r", 499, "-c", 6]) \
            == {499: "499", 500: "4711", 501: "1", 502: "2", 503: "3", 504: "504"}
        mbpoll(framing, endpoint, ["-t", 0, "-r", 600], 1)
        mbpoll(framing, endpoint, ["-t", 0, "-r", 601], 0, 1, 1)
        assert mbpoll(framing, endpoint, ["-t", 0, "-r", 600, "-c", 5]) == {
            600: "1",
            601: "0",
            602: "1",
            603: "1",
            604: "0"
        }


def test_mbpoll_reads_the_device_identification(pair):
    """Function 17, which it has on serial lines only."""
    with device("rtu", pair) as endpoint:
        done = subprocess.run(
            ["mbpoll", "-m", "rtu", "-b", BAUD, "-P", "even", "-a", "1", "-o", "5", "-u", endpoint],
            capture_output=True, timeout=DEADLINE, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.findall(r"^(Length|Id) *: (\S+)", done.stdout, re.MULTILINE) == [("Length", "6"),
                                                                               ("Id", "0x01")]


def test_mbpoll_floats(pair):
    """mbpoll puts the low register first by default: the order 2143."""
    with device("tcp", pair) as endpoint:
        mbpoll("tcp", endpoint, ["-t", "4:float", "-r", 10], 1.5, 2.25)
        assert mbpoll("tcp", endpoint, ["-t", "4:float", "-r", 10, "-c", 2]) == {10: "1.5", 12: "2.25"}


# --- pymodbus


def pymodbus_client(framing, endpoint):
    from pymodbus.client import ModbusSerialClient, ModbusTcpClient
    from pymodbus.transaction import ModbusAsciiFramer, ModbusRtuFramer
    if framing == "tcp":
        return ModbusTcpClient("127.0.0.1", port=endpoint, timeout=DEADLINE)
    return ModbusSerialClient(endpoint, framer=ModbusRtuFramer if framing == "rtu" else ModbusAsciiFramer,
                              baudrate=int(BAUD), timeout=DEADLINE)  # no parity: docs/interop.md, pyserial


@contextlib.contextmanager
def connected(framing, endpoint):
    client = pymodbus_client(framing, endpoint)
    assert client.connect()
    try:
        yield client
    finally:
        client.close()


def good(response):
    assert not response.isError(), response
    return response


FRAMINGS = ["tcp", "rtu", "ascii"]


@pytest.mark.parametrize("framing", FRAMINGS)
def test_the_three_cases_of_specification_section_8(pair, framing):
    with device(framing, pair, fill="zero") as endpoint, connected(framing, endpoint) as client:
        assert good(client.read_holding_registers(0, 5, slave=1)).registers == [0] * 5
        good(client.write_registers(0, [100, 200, 300, 400, 500], slave=1))
        assert good(client.read_holding_registers(0, 5, slave=1)).registers == [100, 200, 300, 400, 500]
        assert good(client.read_input_registers(0, 5, slave=1)).registers == [0] * 5
        assert good(client.read_coils(0, 5, slave=1)).bits[:5] == [False] * 5
        assert good(client.read_discrete_inputs(0, 5, slave=1)).bits[:5] == [False] * 5


@pytest.mark.parametrize("framing", FRAMINGS)
def test_pymodbus_client_every_function(pair, framing):
    with device(framing, pair) as endpoint, connected(framing, endpoint) as client:
        most = 125
        assert good(client.read_holding_registers(1000, most,
                                                  slave=1)).registers == list(range(1000, 1000 + most))
        assert good(client.read_input_registers(65535, 1, slave=1)).registers == [65535]
        assert good(client.read_coils(7, 9, slave=1)).bits[:9] == [bool(a & 1) for a in range(7, 16)]
        assert good(client.read_discrete_inputs(0, 2000,
                                                slave=1)).bits[:2000] == [bool(a & 1) for a in range(2000)]
        good(client.write_coil(10, True, slave=1))
        good(client.write_coils(11, [False, True, True], slave=1))
        assert good(client.read_coils(10, 5, slave=1)).bits[:5] == [True, False, True, True, False]
        good(client.write_register(10, 0xBEEF, slave=1))
        assert good(client.read_holding_registers(10, 2, slave=1)).registers == [0xBEEF, 11]
        good(client.write_register(11, 0x12, slave=1))
        good(client.mask_write_register(address=11, and_mask=0xF2, or_mask=0x25, unit=1))
        assert good(client.read_holding_registers(11, 1, slave=1)).registers == [0x17]
        answer = good(
            client.readwrite_registers(read_address=19, read_count=4, write_address=20,
                                       write_registers=[7, 8], unit=1))
        assert answer.registers == [19, 7, 8, 22]


def test_rtu_over_tcp(project):
    from pymodbus.client import ModbusTcpClient
    from pymodbus.transaction import ModbusRtuFramer
    port = endpoints.free_port()
    path = project(
        tcp(at([0, 1, 2], "type: int16, read: 0x03, write: 0x10"),
            port).replace("framing: tcp", "framing: rtu"))
    with start("serve", path) as running:
        endpoints.wait_listening(port, running)
        client = ModbusTcpClient("127.0.0.1", port=port, framer=ModbusRtuFramer, timeout=DEADLINE)
        good(client.write_registers(0, [7, 8, 9], slave=1))
        assert len(good(client.read_holding_registers(0, 3, slave=1)).registers) == 3
        client.close()
        running.interrupt()


@pytest.mark.parametrize("framing", FRAMINGS)
def test_pymodbus_client_is_refused_properly(pair, framing):
    with device(framing, pair) as endpoint, connected(framing, endpoint) as client:
        beyond = client.read_holding_registers(65535, 2, slave=1)
        assert beyond.isError() and beyond.exception_code == 2
        assert good(client.read_holding_registers(0, 1, slave=1)).registers == [0], "and it goes on"
