"""The slave on emulated boards, with masters that are not ours and with takt, over a pseudo-terminal."""
import contextlib
import json
import re
import subprocess

import pytest

from board import Board
from endpoints import wait_slave
from program import DEADLINE, takt, until

BAUD = "9600"
STACK_LIMIT = 1280  # tools/firmware
REPEATED = 8
ATTEMPTS = 3  # the host may stop the emulator inside a frame
UNIT = ["--unit", 1, "--timeout", "20s", "--attempts", ATTEMPTS]

# What QEMU logs of each board, with the values of stores, which its plugins do not get. The events to trace
# (-d trace:help); the lines of the driver switched on, of a character sent, of the driver switched off. Of
# peripherals that QEMU does not have, as the GPIO of mps2, it logs each store without an event.
MPS2 = (["cmsdk_apb_uart_write"], r"gpio: .* write .* 0x420, value 0x0*8\)$",
        r"uart_write .* offset 0x0 ", r"gpio: .* write .* 0x420, value 0x0*\)$")
DRIVER_LOG = {
    "microbit": (["nrf51_gpio_write", "nrf51_uart_write"], r"gpio_write offset 0x508 value 0x8$",
                 r"uart_write addr 0x51c ", r"gpio_write offset 0x50c value 0x8$"),
    "an385": MPS2,
    "an386": MPS2,
    "lm3s6965": (["pl061_write", "pl011_write"], r"pl061_write .* 0x80 value 0x20$",
                 r"pl011_write addr 0x0+ ", r"pl061_write .* 0x80 value 0x0$"),
}


def stores(log, board):
    """@returns the stores of the driver and of characters in their order, as "+", "." and "-" """
    found = []
    for line in log.read_text().splitlines():
        found += [sign for sign, pattern in zip("+.-", DRIVER_LOG[board][1:]) if re.search(pattern, line)]
    return "".join(found)


@contextlib.contextmanager
def answering(board, name, *options, framing="rtu"):
    """A board whose slave answers."""
    with Board(board, name, *options) as slave:
        wait_slave(slave.port, 1, framing, slave)
        yield slave


def takt_is_answered(folder, board):
    """The driver of the line is on from before the first character of a response to after its last one."""
    log = folder / "log"
    events, *_ = DRIVER_LOG[board]
    traced = ",".join(["unimp", *(f"trace:{event}" for event in events)])
    with answering(board, "test_rtu", "-D", log, "-d", traced) as slave:
        line = f"rtu://{slave.port}?baud={BAUD}&parity=none"
        takt("write", line, *UNIT, "holding", 5, 4711, 4712)
        read = takt("read", line, *UNIT, "holding", 5, 3, "--json").json
        assert read["values"] == [4711, 4712, 0]
        assert "08 00 00 12 34" in takt("raw", line, *UNIT, "0800001234").out
        refused = takt("read", line, *UNIT, "holding", 64, code=None)
        assert refused.code != 0 and "exception 2" in refused.out + refused.err
        used = takt("read", line, *UNIT, "input", 0, "--json").json["values"][0]
        assert 0 < used < STACK_LIMIT
        until(lambda: stores(log, board).endswith("-"), "the driver is off")
    assert re.fullmatch(r"(\+\.{5,}-){6,}", stores(log, board))


def takt_is_answered_in_ascii(_, board):
    with answering(board, "ascii", framing="ascii") as slave:
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


def mbpoll_is_answered(_):
    """mbpoll is a program of libmodbus."""
    with answering("microbit", "test_rtu") as slave:
        mbpoll(slave.port, ["-t", "4", "-r", "10"], "1", "2", "3")
        read = mbpoll(slave.port, ["-t", "4", "-r", "9", "-c", "5"])
        assert read == {9: "0", 10: "1", 11: "2", 12: "3", 13: "0"}
        mbpoll(slave.port, ["-t", "0", "-r", "3"], "1")
        assert mbpoll(slave.port, ["-t", "0", "-r", "2", "-c", "3"]) == {2: "0", 3: "1", 4: "0"}


def pymodbus_is_answered(_):
    from pymodbus.client import ModbusSerialClient
    with answering("microbit", "test_rtu") as slave:
        client = ModbusSerialClient(slave.port, baudrate=int(BAUD), timeout=20, retries=ATTEMPTS,
                                    retry_on_empty=True)
        assert client.connect()
        for i in range(REPEATED):
            assert not client.write_registers(20, [i, i + 1, i + 2], slave=1).isError()
            assert client.read_holding_registers(20, 3, slave=1).registers == [i, i + 1, i + 2]
        client.close()


def takt_polls_it(folder):
    with answering("microbit", "test_rtu") as slave:
        (folder / "plant.yaml").write_text(f"""takt: 1
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
        lines = takt("run", folder / "plant.yaml", "--for", "1500ms", "--json").lines
        device = json.loads(lines[-1])["lines"][0]["devices"][0]
        assert device["counters"]["answered"] > 5 and device["state"] == "answering", device


CASES = {f"takt, {board}": (takt_is_answered, board) for board in DRIVER_LOG} | {
    "takt in ASCII, microbit": (takt_is_answered_in_ascii, "microbit"),
    "takt in ASCII, an386": (takt_is_answered_in_ascii, "an386"),
    "mbpoll": (mbpoll_is_answered,),
    "pymodbus": (pymodbus_is_answered,),
    "takt polls": (takt_polls_it,)
}


@pytest.mark.parametrize("case", CASES)
def test_a_slave(results, case):
    results[case].result()
