"""A share of the kills of `./dev soak` (tests/kills), and mistakes that its judge must see."""
import pathlib
import subprocess
import sys

import pytest

from program import TAKT

KILLS = pathlib.Path(__file__).resolve().parent.parent / "kills"
sys.path.insert(0, str(KILLS))

import judge  # noqa: E402
from journal_files import GAP, Cursor, Record  # noqa: E402
from judge import Delivery  # noqa: E402
from ledger import Ledger, Violation, text_of  # noqa: E402
from wire import Item  # noqa: E402


def test_nothing_is_lost_by_kills(tmp_path):
    """Seven plants. The one whose quota is reached (seed 15) takes too long for a test."""
    command = [
        sys.executable, KILLS / "output_kills.py", "--takt", TAKT, "--kills", "70", "--plant-kills", "10",
        "--seed", "8", "--jobs", "4", "--kept",
        str(tmp_path)
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=1200, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_everything_at_once(tmp_path):
    command = [
        sys.executable, KILLS / "output_kills.py", "--takt", TAKT, "--kills", "4", "--plant-kills", "2",
        "--everything", "5", "--seed", "3", "--jobs", "2", "--kept",
        str(tmp_path)
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=1200, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


SECOND = 1_000_000_000
START = SECOND  # the first epoch is 1


class Program:
    """A run that writes three samples, in two records behind the gap of its start, and publishes them."""

    def __init__(self):
        self.events, self.received = [], []
        self.ledger = Ledger()
        self.delivery = Delivery(self.ledger)
        self.ledger.starts.append((START, START + 9 * SECOND))
        self.records = [gap(1, 0, 1), samples(2, 0, 1, [5, 6]), samples(3, 2, 1, [7])]
        self.ledger.add(self.records, cut=False)
        self.messages = [gap_item(1, 1), item(1, 1, 5), item(2, 1, 6), item(3, 1, 7)]
        self.delivery.epoch_of_run = 1

    def publish(self, messages=None, arrive=None):
        messages = self.messages if messages is None else messages
        self.events += [("connect", 1, None), *(("publish", 1, message) for message in messages)]
        self.received += messages if arrive is None else arrive
        self.delivery.check(self)

    def acknowledge(self, message):
        self.events.append(("acknowledge", 1, message))
        self.delivery.check(self)


def varint(number):
    return bytes((number, )) if number < 0x80 else bytes((number & 0x7F | 0x80, )) + varint(number >> 7)


def samples(sequence, before, epoch, values, name=b"x"):
    """A record as src/publish/outputs/sample_codec.cpp writes it: int16, all of one instant."""
    wall = START + sequence * SECOND
    series = b"\1" + len(name).to_bytes(2, "big") + name + 3 * b"\0\0" + b"\1\0"
    body = b"".join(b"\0" + bytes((1 | 2 << 4, 0)) + varint(2 * wall if i == 0 else 0) + varint(2 * value)
                    for i, value in enumerate(values))
    payload = b"\2" + series + varint(len(values)) + body
    return Record(1, len(values), sequence, before, wall, 0, epoch, payload)


def gap(sequence, before, epoch, cause=1, first=START):
    payload = GAP.pack(cause, 0, 0, 0, sequence, sequence, first, START)
    return Record(2, 0, sequence, before, START, 0, epoch, payload)


def item(seq, epoch, value, **changes):
    sequence = 2 if seq < 3 else 3
    sent = {
        "variable": "x",
        "value": value,
        "quality": "good",
        "time": text_of(START + sequence * SECOND),
        "seq": seq
    }
    return Item("sample", seq, 1, epoch, values={seq: sent | changes})


def gap_item(first, epoch):
    body = {"cause": "restart", "samples": 0, "first": text_of(START), "last": text_of(START)}
    return Item("gap", first, 0, epoch, gap=body)


@pytest.fixture
def program():
    return Program()


def test_a_run_without_a_mistake(program):
    program.publish()
    for message in program.messages:
        program.acknowledge(message)
    program.ledger.set_cursor(Cursor(1, 3, 3, 3, 0), program.delivery.acknowledged_to)
    assert program.delivery.missing() == [] and program.delivery.missing_gaps() == []
    program.delivery.check_counters({"sampled": 3, "delivered": 3, "waiting": 0, "dropped": 0}, exact=True)


def test_a_sample_that_did_not_arrive(program):
    program.publish(arrive=program.messages[:2])
    assert program.delivery.missing() == [2, 3]


@pytest.mark.parametrize("mistake, rule", [
    (lambda m: m + [item(4, 1, 8)], "not durable"),
    (lambda m: [m[0], m[2]], "not in order"),
    (lambda m: m[:2] + [m[3]], "not in order"),
    (lambda m: m[1:2] + m[1:2], "not in order"),
    (lambda m: [m[0], item(1, 1, 9)], "differs"),
    (lambda m: [m[0], item(1, 2, 5)], "another epoch"),
    (lambda m: [m[0], item(1, 1, 5, quality="bad")], "differs"),
    (lambda m: [gap_item(1, 2)], "not on the disk"),
    (lambda m: [gap_item(2, 1)], "not on the disk"),
])
def test_messages_with_a_mistake(program, mistake, rule):
    with pytest.raises(Violation, match=rule):
        program.publish(mistake(program.messages))


def test_a_repeat_without_a_mark(program):
    program.publish()
    with pytest.raises(Violation, match="repeat"):
        program.publish()


def test_a_cursor_before_the_acknowledgement(program):
    program.publish()
    program.acknowledge(program.messages[1])
    with pytest.raises(Violation, match="past the last"):
        program.ledger.set_cursor(Cursor(1, 2, 2, 2, 0), program.delivery.acknowledged_to)


@pytest.mark.parametrize("cursors, rule", [
    ([Cursor(1, 3, 3, 3, 1)], "add up"),
    ([Cursor(1, 3, 2, 2, 0)], "other samples"),
    ([Cursor(1, 3, 3, 3, 0), Cursor(2, 2, 2, 2, 0)], "went back"),
])
def test_cursors_with_a_mistake(program, cursors, rule):
    with pytest.raises(Violation, match=rule):
        for cursor in cursors:
            program.ledger.set_cursor(cursor)


@pytest.mark.parametrize("mistake, rule", [
    (lambda r: r[:2] + [samples(3, 2, 1, [8])], "used again"),
    (lambda r: r[:2], "missing at the end"),
    (lambda r: [r[0], r[2]], "missing"),
    (lambda r: r + [samples(4, 3, 2, [8])], "no gap of cause restart"),
    (lambda r: r + [gap(4, 3, 3, first=START + 3 * SECOND)], "does not follow"),
    (lambda r: r + [gap(4, 3, 2, first=START + 2 * SECOND)], "last durable record"),
    (lambda r: r + [samples(5, 4, 1, [8])], "missing on the disk"),
])
def test_a_disk_with_a_mistake(program, mistake, rule):
    with pytest.raises(Violation, match=rule):
        program.ledger.add(mistake(program.records), cut=False)


def test_a_record_that_is_removed_before_its_acknowledgement(program):
    program.ledger.add(program.records[2:], cut=False)
    with pytest.raises(Violation, match="before its time"):
        program.ledger.check_removed(100)


@pytest.mark.parametrize("counters", [(3, 2, 0, 0), (4, 4, 0, 0), (3, 2, 0, 1)])
def test_counters_with_a_mistake(program, counters):
    program.publish()
    with pytest.raises(Violation):
        program.delivery.check_counters(dict(zip(("sampled", "delivered", "waiting", "dropped"), counters)),
                                        exact=True)


@pytest.mark.parametrize("rows", [
    lambda rows: rows[:2],
    lambda rows: rows + rows[:1],
    lambda rows: [*rows[:2], ("x", rows[2][1], 8, "good")],
])
def test_a_history_with_a_mistake(program, rows):
    good = [("x", text_of(START + s * SECOND), value, "good") for s, value in ((2, 5), (2, 6), (3, 7))]
    judge.check_history(program.ledger, good, [])
    with pytest.raises(Violation, match="samples"):
        judge.check_history(program.ledger, rows(good), [])


class Devices(dict):
    """A device that sent 1, 2 and 3."""

    class Device:
        count = 3

        def was_late(self, _number):
            return False

    def __init__(self):
        super().__init__(x=self.Device())


@pytest.mark.parametrize("values, rule", [
    ([1, 2, 3], None),
    ([1, 1, 2], None),
    ([1, 3], "not sampled"),
    ([2, 1], "goes back"),
    ([4], "did not send"),
])
def test_samples_of_a_counter(values, rule):
    ledger = Ledger()
    ledger.starts.append((START, START + 9 * SECOND))
    ledger.add([gap(1, 0, 1), samples(2, 0, 1, values, b"x.Count")], cut=False)
    counting = judge.Counting(ledger, Devices())
    if rule is None:
        counting.check()
    else:
        with pytest.raises(Violation, match=rule):
            counting.check()


def test_a_history_with_a_gap_that_is_no_start(program):
    rows = [("x", text_of(START + s * SECOND), value, "good") for s, value in ((2, 5), (2, 6), (3, 7))]
    with pytest.raises(Violation, match="gaps"):
        judge.check_history(program.ledger, rows, [(text_of(START), text_of(START + SECOND))])
