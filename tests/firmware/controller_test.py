"""A controller on an emulated board: its master polls a real slave, its second UART shows the buffer and
takes new tables."""
import contextlib
import struct

import pytest

from board import Board
from endpoints import wait_slave
from program import start, takt, until

TABLE_AT = 0x200000  # firmware/boards/mps2/board.cpp
BUFFER, LOADER = 1, 2  # units
STATE, ERROR, ENTRIES, ITEMS, STACK = range(5)  # input registers of the loader
RUNNING, LOAD = 1, 1
GOOD = 1  # table::Quality
STACK_LIMIT = 16 * 1024

PROJECT = """takt: 1
lines:
  - name: bus
    transport: serial
    port: /dev/ttyS0
    baud: 9600
    parity: none
    devices:
      - name: Meter
        address: 1
        poll_period: 100ms
        response_timeout: 3s
        read_modify_write: true
        variables:
          - {name: A, type: int16, register: FIRST, read: 0x03}
          - {name: C, type: int16, register: 60, read: 0x03, write: 0x06, write_on_change: true}
          - {name: D, type: int16, register: 61, read: 0x03, read_trigger: Again}
          - {name: W, type: int16, register: 62, read: 0x03}
          - {name: B, type: bool, register: 62, bit: 3, read: 0x03, write: 0x06, write_on_change: true}
locals:
  - {name: Again, type: bool}
"""
AGAIN, A, C, D, W, B = range(6)  # items, and their words
ITEM_COUNT = 6


def table_of(folder, first, *options):
    project = folder / "plant.yaml"
    project.write_text(PROJECT.replace("FIRST", str(first)))
    path = folder / f"table-{first}"
    takt("table", "build", project, "-o", path, "--no-names" if not options else "--profile", *options)
    return path


class Slave:
    """The controller as its masters see it."""

    def __init__(self, port):
        self.line = f"rtu://{port}?baud=115200&parity=none"

    def _on(self, unit, *arguments, code=0):
        options = ["--unit", unit, "--timeout", "20s", "--attempts", 3]  # the host may stop the emulator
        return takt(arguments[0], self.line, *options, *arguments[1:], code=code)

    def read(self, unit, area, first, count):
        return self._on(unit, "read", area, first, count, "--json").json["values"]

    def write(self, first, *values, code=0):
        return self._on(BUFFER, "write", "holding", first, *values, code=code)

    def buffer(self):
        return self.read(BUFFER, "holding", 0, ITEM_COUNT)

    def qualities(self):
        return self.read(BUFFER, "input", 0, 2 * ITEM_COUNT)[1::2]

    def shown(self):
        return self.read(LOADER, "input", 0, 5)

    def load(self, image, before=b""):
        """Writes the table as records of file 1, except what the file has from before, then the command."""
        image += b"\0" * (len(image) % 2)
        for at in range(0, len(image), 200):
            part = image[at:at + 200]
            if part == before[at:at + 200]:
                continue
            head = struct.pack(">BHHH", 6, 1, at // 2, len(part) // 2)
            pdu = bytes([0x15, len(head + part)]) + head + part
            self._on(LOADER, "raw", pdu.hex())
        self.command(LOAD)

    def command(self, number, code=0):
        return self._on(LOADER, "write", "holding", 0, number, code=code)


@contextlib.contextmanager
def controller(folder, table, board="an385"):
    loader = ["-device", f"loader,file={table},addr={TABLE_AT},force-raw=on"] if table else []
    with Board(board, "test_controller", *loader, ports=2) as running:
        meter = f"rtu://{running.ports[0]}?baud=9600&parity=none"
        with start("serve", "--port", meter, "--unit", 1, "--fill", "ramp") as slave:
            until(lambda: any("serving" in line for line in slave.out + slave.err), "the slave serves")
            wait_slave(running.ports[1], LOADER, process=running)
            yield Slave(running.ports[1])
            slave.interrupt()


def the_buffer_is_shown_and_written(folder, board):
    with controller(folder, table_of(folder, 3), board) as shown:
        until(lambda: shown.buffer() == [0, 3, 60, 61, 62, 1], "the values of the meter")
        assert shown.qualities() == [GOOD] * ITEM_COUNT
        shown.write(C, 77)
        until(lambda: shown.buffer()[C] == 77, "the meter has the new value")
        refused = shown.write(A, 5, code=None)
        assert refused.code != 0 and "exception 2" in refused.out + refused.err
        shown.write(AGAIN, 1)
        assert shown.buffer()[AGAIN] == 1
        state, error, entries, items, stack = shown.shown()
        assert (state, error, entries, items) == (RUNNING, 0, 5, ITEM_COUNT)
        assert 0 < stack < STACK_LIMIT


def a_new_table_replaces_the_running_one(folder):
    with controller(folder, table_of(folder, 3)) as shown:
        until(lambda: shown.buffer()[A] == 3, "the old table runs")
        shown.load(table_of(folder, 7).read_bytes())
        until(lambda: shown.shown()[STATE] == RUNNING and shown.buffer()[A] == 7, "the new table runs")
        refused = shown._on(BUFFER, "read", "holding", ITEM_COUNT - 1, 2, code=None)
        assert "exception 2" in refused.err, "only the registers of the table exist"
        assert shown.shown()[ERROR] == 0


def a_broken_table_is_refused_and_the_old_one_goes_on(folder):
    with controller(folder, table_of(folder, 3)) as shown:
        until(lambda: shown.buffer()[A] == 3, "the old table runs")
        image = table_of(folder, 7).read_bytes()
        before = b""
        for at in (0, 9, 13, 40, len(image) - 1):
            broken = image[:at] + bytes([image[at] ^ 1]) + image[at + 1:]
            shown.load(broken, before)
            before = broken
            assert shown.shown()[ERROR] != 0
        assert "exception 3" in shown.command(2, code=None).err
        shown.write(C, 5)
        until(lambda: shown.buffer()[:3] == [0, 3, 5], "the old table goes on")
        assert shown.shown()[STATE] == RUNNING


def a_table_of_owen_kc1_is_loaded_where_none_is(folder):
    with controller(folder, None) as shown:
        refused = shown._on(BUFFER, "read", "holding", 0, 1, code=None)
        assert refused.code != 0 and "exception 2" in refused.out + refused.err
        assert shown.shown()[:2] == [0, 0]
        shown.load(table_of(folder, 9, "owen-kc1").read_bytes())
        until(lambda: shown.buffer() == [0, 9, 60, 61, 62, 1], "the table runs")
        assert shown.shown()[:2] == [RUNNING, 0]
        shown.write(B, 0)
        until(lambda: shown.buffer()[W:] == [62 - 8, 0], "the bit was written, and its neighbours stay")


CASES = {
    "buffer, an385": (the_buffer_is_shown_and_written, "an385"),
    "buffer, an386": (the_buffer_is_shown_and_written, "an386"),
    "new table": (a_new_table_replaces_the_running_one,),
    "broken table": (a_broken_table_is_refused_and_the_old_one_goes_on,),
    "no table": (a_table_of_owen_kc1_is_loaded_where_none_is,)
}


@pytest.mark.parametrize("case", CASES)
def test_a_controller(results, case):
    results[case].result()
