"""The instrument on `microbit`: its measurements, and what wakes it (docs/firmware.md, "Low power")."""
import os
import time
import tty

import pytest

from board import Board, addresses, plugin, run, script
from frames import crc16
from program import takt, until

NAME = "test_instrument"
RECEIVED_OR_SENT, SILENCE, SENSOR = INTERRUPTS = ("uart_interrupt", "one_shot_interrupt", "timer2_interrupt")
TOLERANCE = 0.03  # of the instructions, from one compiler to another
REST = 0.5  # seconds
HOUR = 3_600_000_000  # microseconds
ATTEMPTS = 10  # the host may stop the emulator at any time
OWN, OTHER = 1, 6


def frame(unit, pdu):
    body = bytes([unit]) + bytes.fromhex(pdu)
    return body + crc16(body)


class Instrument:
    """The board, with a master that sends a character when the last one was received."""

    def __init__(self, folder):
        self.trace = folder / "trace"
        self.read, self.seen = 0, []  # of the trace
        self.names = {address: name for name, address in addresses("microbit", NAME, *INTERRUPTS).items()}
        options = plugin(folder, *(f"at={address:x}" for address in self.names))
        self.board = Board("microbit", NAME, *options, folder=folder)

    def __enter__(self):
        self.board.__enter__()
        self.port = os.open(self.board.port, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.port)
        os.set_blocking(self.port, False)
        until(self.trace.exists, "the plugin runs")
        self.board.resume()
        self.send(frame(OTHER, "0400050001"))  # the silence at the start
        return self

    def __exit__(self, *error):
        os.close(self.port)
        self.board.__exit__(*error)

    def interrupts(self):
        """@returns name, instructions and WFI so far, for each interrupt"""
        with open(self.trace, "rb") as trace:
            trace.seek(self.read)
            whole, end, _ = trace.read().rpartition(b"\n")
        self.read += len(whole + end)
        lines = [line.split() for line in whole.splitlines()]
        self.seen += [(self.names[int(line[0], 16)], int(line[1]), int(line[2])) for line in lines]
        return self.seen

    def since(self, first):
        """@returns the names of the interrupts from that index on"""
        return [name for name, _, _ in self.interrupts()[first:]]

    def send(self, characters):
        """@returns the index of the silence behind the frame; None: the host made another one inside"""
        first = len(self.interrupts())
        for character in characters:
            before = len(self.interrupts())
            os.write(self.port, bytes([character]))
            until(lambda: RECEIVED_OR_SENT in self.since(before), "the character is received")
        last = before + self.since(before).index(RECEIVED_OR_SENT)
        until(lambda: SILENCE in self.since(last), "the end of the frame")
        end = last + self.since(last).index(SILENCE)
        return None if SILENCE in self.since(first)[:end - first] else end

    def receive(self, size):
        received = b""

        def complete():
            nonlocal received
            try:
                received += os.read(self.port, size - len(received))
            except BlockingIOError:
                pass
            return len(received) == size

        until(complete, "the response")
        return received

    def ask(self, pdu, size):
        """@returns the PDU of the response, of `size` bytes or an exception"""
        end = until(lambda: self.send(frame(OWN, pdu)), "a whole frame")
        response = self.receive(2)
        response += self.receive(3 if response[1] & 0x80 else size + 1)
        until(lambda: self.since(end).count(RECEIVED_OR_SENT) == len(response), "the last character is sent")
        assert frame(OWN, response[1:-2].hex()) == response
        return response[1:-2].hex()


@pytest.fixture(name="instrument", scope="module")
def instrument_fixture(tmp_path_factory):
    with Instrument(tmp_path_factory.mktemp("board")) as instrument:
        yield instrument


START, RESET, ONLY_THE_STATE, MEASUREMENT = "0600000001", "0600000002", "0400000002", "0400020003"
BUSY, STALE = "8406", "840b"


def test_old_measurements_are_refused(instrument):
    assert instrument.ask(MEASUREMENT, 8) == STALE
    seen = set()

    def measured():
        seen.add(instrument.ask(MEASUREMENT, 8))
        return seen != {BUSY}

    numbers = 0
    while numbers < ATTEMPTS and not (BUSY in seen and any(pdu.startswith("0406") for pdu in seen)):
        seen.clear()
        assert instrument.ask(START, 5) == START
        numbers += 1
        until(measured, "the measurement")
    assert len(seen) == 2 and STALE not in seen
    until(lambda: instrument.ask(MEASUREMENT, 8) == STALE, "the measurement is too old")
    assert instrument.ask(ONLY_THE_STATE, 6) == f"04040003{numbers:04x}"
    assert instrument.ask("0400000006", 14) == STALE
    assert instrument.ask("0600000003", 5) == "8603"
    assert instrument.ask("0600010001", 5) == "8602"
    assert instrument.ask(RESET, 5) == RESET
    assert instrument.ask(ONLY_THE_STATE, 6) == "040400000000"
    assert instrument.ask(MEASUREMENT, 8) == STALE
    assert instrument.ask("0300000001", 4) == "03020000"


def read(quantity):
    return [(OWN, f"040005{quantity:04x}", 2 + 2 * quantity)]


def foreign(quantity):
    return [(OTHER, f"040005{quantity:04x}", 0), (OTHER, f"04{2 * quantity:02x}" + "0000" * quantity, 0)]


EXCHANGES = {
    "read 1": read(1),
    "read 16": read(16),
    "command": [(OWN, RESET, 5)],
    "foreign 1": foreign(1),
    "foreign 16": foreign(16),
}


def measure(instrument, exchange, pause=0.0):
    """@returns interrupts, instructions and WFI from the first character to that of the next frame"""

    def play(unit, pdu, size):
        if size:
            assert len(instrument.ask(pdu, size)) == 2 * size
        else:
            instrument.send(frame(unit, pdu))

    first = len(instrument.interrupts())
    for step in exchange:
        play(*step)
    time.sleep(pause)
    following = len(instrument.interrupts())
    play(OTHER, RESET, 0)
    interrupts = instrument.interrupts()
    _, begun, waits_then = interrupts[first]
    _, ended, waits_now = interrupts[following]
    return following - first, ended - begun, waits_now - waits_then


def measure_twice(*arguments):
    """Until two in a row are equal: the host may stop the emulator between an interrupt and WFI."""
    last = None
    for _ in range(ATTEMPTS):
        measured = measure(*arguments)
        if measured == last:
            return measured
        last = measured
    raise AssertionError(f"{arguments} differs, at last {last}")


def calculated(folder, registers):
    (folder / "board.yaml").write_text(f"""core_clock: 16000000
wakeup_time: 2us
uart_clock_ppm: 100
request_period: 10s
registers: {registers}
active_ua_per_mhz: 100
sleep_na: 1000
""")
    return takt("check", "--firmware", folder / "board.yaml", "--json").json["firmware"]


def test_what_wakes_it(instrument, tmp_path):
    """A character, the end of a frame, and nothing else. The calculator has the same figures."""
    costs = {name: measure_twice(instrument, exchange) for name, exchange in EXCHANGES.items()}
    for registers in (1, 16):
        figures = calculated(tmp_path, registers)
        for name, key in (("read", "own"), ("foreign", "foreign")):
            interrupts, instructions, _ = costs[f"{name} {registers}"]
            assert interrupts == figures[key]["wakeups"], name
            assert instructions == pytest.approx(figures[key]["instructions"], rel=TOLERANCE), name
    # QEMU sends without time: only the characters received and the ends of frames end a sleep there.
    received = {"read 1": 8, "read 16": 8, "command": 8, "foreign 1": 8 + 7, "foreign 16": 8 + 37}
    ends = {"foreign 1": 2, "foreign 16": 2}
    for name, (_, _, waits) in costs.items():
        assert waits == received[name] + ends.get(name, 1), name
    interrupts, _, _ = costs["command"]
    assert interrupts == 8 + 1 + 8


def test_nothing_wakes_it_at_rest(instrument):
    cost = measure_twice(instrument, read(1))
    assert any(measure(instrument, read(1), REST) == cost for _ in range(ATTEMPTS))


def test_nothing_wakes_the_slave_in_an_hour(tmp_path):
    """The same exactly, in virtual time: an hour costs no instruction more than 50 ms."""
    marks = addresses("microbit", "test_silences", *INTERRUPTS)
    trace = plugin(tmp_path, *(f"at={address:x}" for address in marks.values()))
    costs = []
    for hours in (0, 1):
        pauses = [50_000, 50_000, 50_000 + hours * HOUR]
        steps = [(pause if i == 0 else 1042, character)
                 for pause in pauses for i, character in enumerate(frame(OWN, "0300010001"))]
        (tmp_path / "script").write_bytes(script(9600, False, False, steps))
        _, sent = run("microbit", "test_silences", tmp_path, *trace)
        assert len(sent) == 3 * 7
        lines = [line.split() for line in (tmp_path / "trace").read_text().splitlines()]
        first = [line for line in lines if int(line[0], 16) == marks[SENSOR]][::8]
        costs.append([int(after[i]) - int(before[i])
                      for before, after in zip(first, first[1:]) for i in (1, 2)])
    assert costs[0] == costs[1]
    assert costs[0][1] == costs[0][3] == 8 + 1
