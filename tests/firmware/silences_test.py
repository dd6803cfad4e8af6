"""The silences of RTU and the pauses of ASCII at exact times, on a Cortex-M0 in virtual time."""
import pytest

from board import plugin, run, script
from frames import crc16

BITS = 10


class Line:
    """The times of a line without parity, in microseconds (MODBUS over Serial Line, section 2.5.1.1)."""

    def __init__(self, baud):
        self.baud = baud
        self.character = BITS * 1_000_000 / baud
        self.half_longer = 1.5 * self.character if baud <= 19200 else 750
        self.end = 3.5 * self.character if baud <= 19200 else 1750


def rtu(pdu):
    frame = b"\x01" + bytes.fromhex(pdu)
    return frame + crc16(frame)


def ascii_frame(pdu):
    frame = b"\x01" + bytes.fromhex(pdu)
    return b":" + (frame + bytes([-sum(frame) & 0xFF])).hex().upper().encode() + b"\r\n"


def read(register):
    return f"03{register:04x}0001"


def value(register):
    return f"0302{register:04x}"


def played(tmp_path, line, strict, frames, framing=rtu, options=()):
    """@param frames  (characters, silence in the middle or 0)"""
    steps = []
    for characters, silence in frames:
        for i, character in enumerate(characters):
            pause = 10 * line.end + 20_000 if i == 0 else silence if i == len(characters) // 2 else 0
            steps.append((round(line.character + pause), character))
    (tmp_path / "script").write_bytes(script(line.baud, strict, framing is ascii_frame, steps))
    return run("microbit", "test_silences", tmp_path, *options)


ERRORS = "08000c0000"


def counted(number):
    return f"08000c{number:04x}"


@pytest.mark.parametrize("baud", [1200, 9600, 19200, 115200])
def test_pauses_of_a_strict_rtu_slave(tmp_path, baud):
    line = Line(baud)
    good = [0, line.half_longer - 10]
    one_error = [line.half_longer + 10, line.end - 10]
    two_errors = [line.end + 10]  # each piece is broken
    silences = [*good, *one_error, *two_errors]
    frames = [(rtu(read(i)), silence) for i, silence in enumerate(silences)] + [(rtu(ERRORS), 0)]
    times, sent = played(tmp_path, line, True, frames)
    errors = len(one_error) + 2 * len(two_errors)
    assert sent == b"".join(rtu(value(i)) for i in range(len(good))) + rtu(counted(errors))
    # A UART reports a character at its end: one that began within t3.5 ends a character time later.
    least = line.end + line.character
    assert least - 1 <= times["soonest"] <= times["latest"] <= least + 500


def test_pauses_of_a_lenient_rtu_slave(tmp_path):
    line = Line(9600)
    silences = [0, line.half_longer + 10, line.end - 10, line.end + 10]
    frames = [(rtu(read(i)), silence) for i, silence in enumerate(silences)] + [(rtu(ERRORS), 0)]
    _, sent = played(tmp_path, line, False, frames)
    assert sent == b"".join(rtu(value(i)) for i in range(3)) + rtu(counted(2))


def test_pauses_of_an_ascii_slave(tmp_path):
    line = Line(9600)
    silences = [0, 999_990, 1_000_010]
    frames = [(ascii_frame(read(i)), silence) for i, silence in enumerate(silences)]
    frames.append((ascii_frame(ERRORS), 0))
    _, sent = played(tmp_path, line, False, frames, ascii_frame)
    assert sent == b"".join(ascii_frame(value(i)) for i in range(2)) + ascii_frame(counted(1))


def test_two_runs_are_equal(tmp_path):
    line = Line(9600)
    frames = [(rtu(read(i)), i * 500) for i in range(8)]
    assert played(tmp_path, line, True, frames) == played(tmp_path, line, True, frames)


# TXD of the UART, OUTSET and OUTCLR of the GPIO
UART_SENDS, DRIVER_ON, DRIVER_OFF = "4000251c", "50000508", "5000050c"


@pytest.mark.parametrize("framing", [rtu, ascii_frame])
def test_the_driver_is_on_from_the_first_to_the_last_character(tmp_path, framing):
    """The stores to the registers in their order, seen by a plugin of QEMU."""
    frames = [(framing(read(i)), 0) for i in range(3)]
    _, sent = played(tmp_path, Line(9600), True, frames, framing, plugin(tmp_path, "stores=on"))
    stores = (tmp_path / "trace").read_text().split()
    # The very first one sets the pin of the UART high.
    first = stores.index(DRIVER_ON, stores.index(DRIVER_ON) + 1)
    seen = [store for store in stores[first:] if store in (UART_SENDS, DRIVER_ON, DRIVER_OFF)]
    one = [DRIVER_ON, *[UART_SENDS] * (len(sent) // 3), DRIVER_OFF]
    assert seen == 3 * one
