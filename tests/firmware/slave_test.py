"""The slave on emulated boards, with masters that are not ours and with takt, over a pseudo-terminal."""
import json
import re
import subprocess

import pytest

from board import Board
from program import DEADLINE, takt

BOARDS = ["microbit", "an385", "an386", "lm3s6965"]
BAUD = "9600"
STACK_LIMIT = 1280  # tools/firmware
REPEATED = 20
ATTEMPTS = 3  # the host may stop the emulator inside a frame
UNIT = ["--unit", 1, "--timeout", "20s", "--attempts", ATTEMPTS]  # QEMU looks for a master once a second


@pytest.mark.parametrize("board", BOARDS)
def test_takt_is_answered(board):
    with Board(board, "test_rtu") as slave:
        line = f"rtu://{slave.port}?baud={BAUD}&parity=none"
        takt("write", line, *UNIT, "holding", 5, 4711, 4712)
        read = takt("read", line, *UNIT, "holding", 5, 3, "--json").json
        assert read["values"] == [4711, 4712, 0]
        assert "08 00 00 12 34" in takt("raw", line, *UNIT, "0800001234").out
        refused = takt("read", line, *UNIT, "holding", 64, code=None)
        assert refused.code != 0 and "exception 2" in refused.out + refused.err
        used = takt("read", line, *UNIT, "input", 0, "--json").json["values"][0]
        assert 0 < used < STACK_LIMIT


@pytest.mark.parametrize("board", ["microbit", "an386"])
def test_takt_is_answered_in_ascii(board):
    with Board(board, "ascii") as slave:
        line = f"ascii://{slave.port}?baud={BAUD}&parity=none&data_bits=8"
        takt("write", line, *UNIT, "holding", 5, 4711)
        assert takt("read", line, *UNIT, "holding", 5, "--json").json["values"] == [4711]


def mbpoll(port, *arguments):
    command = ["mbpoll", "-m", "rtu", "-b", BAUD, "-P", "none", "-0", "-1", "-a", "1", "-o", "5"]
    for _ in range(ATTEMPTS):
        done = subprocess.run([*command, *arguments[0], port, *arguments[1:]], capture_output=True,
                              timeout=DEADLINE, text=True, check=False)
        if done.returncode == 0:
            break
    assert done.returncode == 0, done.stdout + done.stderr
    return {int(r): v for r, v in re.findall(r"^\[(\d+)\]:\s+(\S+)", done.stdout, re.MULTILINE)}


def test_mbpoll(port_of_microbit):
    """mbpoll is a program of libmodbus."""
    mbpoll(port_of_microbit, ["-t", "4", "-r", "10"], "1", "2", "3")
    read = mbpoll(port_of_microbit, ["-t", "4", "-r", "9", "-c", "5"])
    assert read == {9: "0", 10: "1", 11: "2", 12: "3", 13: "0"}
    mbpoll(port_of_microbit, ["-t", "0", "-r", "3"], "1")
    assert mbpoll(port_of_microbit, ["-t", "0", "-r", "2", "-c", "3"]) == {2: "0", 3: "1", 4: "0"}


def test_pymodbus(port_of_microbit):
    from pymodbus.client import ModbusSerialClient
    client = ModbusSerialClient(port_of_microbit, baudrate=int(BAUD), timeout=20, retries=ATTEMPTS,
                                retry_on_empty=True)
    assert client.connect()
    for i in range(REPEATED):
        assert not client.write_registers(20, [i, i + 1, i + 2], slave=1).isError()
        assert client.read_holding_registers(20, 3, slave=1).registers == [i, i + 1, i + 2]
    client.close()


@pytest.fixture
def port_of_microbit():
    with Board("microbit", "test_rtu") as slave:
        yield slave.port


def test_takt_polls_it(tmp_path):
    with Board("microbit", "test_rtu") as slave:
        (tmp_path / "plant.yaml").write_text(f"""takt: 1
lines:
  - name: bus
    transport: serial
    port: {slave.port}
    baud: {BAUD}
    parity: none
    devices:
      - name: Board
        address: 1
        poll_period: 200ms
        response_timeout: 5s
        variables:
          - {{name: A, type: uint16, register: 0, read: 0x03}}
          - {{name: B, type: float, register: 40, read: 0x03}}
""")
        lines = takt("run", tmp_path / "plant.yaml", "--for", "3s", "--json").lines
        device = json.loads(lines[-1])["lines"][0]["devices"][0]
        assert device["counters"]["answered"] > 5 and device["state"] == "answering", device


