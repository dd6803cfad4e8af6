"""docs/serial-line.md: noise around answers, damaged answers, devices that come back."""
import statistics
import time

import pytest

from fake_slave import SerialSlave, rtu_answers
from program import start, takt, until
from projects import serial

INT = "type: int16, read: 0x03"
HONEST = rtu_answers({"03 0000 0001": "03 02 0007"})


def value(name, wanted=None, quality="good"):
    return lambda e: e["event"] == "value" and e["name"] == name and e["quality"] == quality and wanted in (
        None, e["value"])


def state(name):
    return lambda e: e["event"] == "device" and e["state"] == name


@pytest.mark.parametrize("before, after", [(b"\x00", b""), (b"\xff", b"\xff"), (b"", b"\x00"),
                                           (b"\x10\x03\x20", b"")])
def test_answers_are_found_in_noise(project, pair, before, after):
    path = project(serial([f"register: 0, {INT}, period: 100ms"], port=pair.a))
    with SerialSlave(pair.b,
                     lambda frame: before + HONEST(frame) + after) as slave, start("run", path,
                                                                                   "--json") as run:
        run.wait_event(value("V1", 7), "a good value")
        until(lambda: len(slave.seen) >= 8, "eight requests")
        run.interrupt()
        counters = run.events()[-1]["lines"][0]["counters"]
    assert counters["checksums"] == counters["timeouts"] == 0, counters
    assert (counters["unsolicited_bytes"] > 0) == bool(after)


NAMED = "1 byte of noise before the answers of Node1: check bias and driver enable"


def test_noise_before_answers_is_named(project, pair, tmp_path):
    """It is an event and in the log, in `ctl status` and in the summary."""
    log = tmp_path / "takt.log"
    control = tmp_path / "control"
    path = project(serial([f"register: 0, {INT}, period: 100ms"], port=pair.a))
    with SerialSlave(pair.b, lambda frame: b"\x00" + HONEST(frame)), start("run", path, "--json", "--log",
                                                                           log, "--control", control) as run:
        event = run.wait_event(lambda e: e["event"] == "noise", "the noise is named")
        assert NAMED in takt("ctl", control, "status").out
        run.interrupt()
        device = run.events()[-1]["lines"][0]["devices"][0]
    assert event["device"] == "Node1" and event["text"] == NAMED
    assert event["least_bytes"] == event["most_bytes"] == 1
    assert len([e for e in run.events() if e["event"] == "noise"]) == 1
    assert "noise" in log.read_text()
    assert device["noise"] == {"least_bytes": 1, "most_bytes": 1}
    assert device["noise_bytes"] == device["noisy_answers"] >= 3


def test_noise_before_answers_is_in_the_summary_as_text(project, pair):
    path = project(serial([f"register: 0, {INT}, period: 100ms"], port=pair.a))
    with SerialSlave(pair.b, lambda frame: b"\x00" + HONEST(frame)), start("run", path) as run:
        run.wait_line(lambda x: NAMED in x, "the noise is named")
        assert "  " + NAMED in run.interrupt().lines


def test_a_single_read_finds_its_answer_in_noise(pair):
    with SerialSlave(pair.b, lambda frame: b"\x00" + HONEST(frame) + b"\xff"):
        result = takt("read", f"rtu://{pair.a}?baud=115200&parity=none", "--unit", 16, "holding", 0)
    assert result.code == 0 and "7" in result.out, result


def test_a_damaged_answer_is_not_waited_for(project, pair):
    """Every third answer has a wrong checksum, every fourth a wrong unit. Where a busy machine passes on an
    answer in pieces, its end is not seen, and the time-out is waited for; most are not."""
    asked = []

    def answers(frame):
        asked.append(time.monotonic())
        good = HONEST(frame)
        if len(asked) % 3 == 0:
            return good[:-1] + bytes([good[-1] ^ 1])
        return bytes([good[0] ^ 0x80]) + good[1:] if len(asked) % 4 == 0 else good

    path = project(
        serial([f"register: 0, {INT}, period: 100ms"], port=pair.a, attempts=10, response_timeout="5s"))
    with SerialSlave(pair.b, answers), start("run", path, "--json") as run:
        until(lambda: len(asked) >= 24, "24 requests")
        run.interrupt()
        counters = run.events()[-1]["lines"][0]["counters"]
    pauses = [b - a for n, (a, b) in enumerate(zip(asked, asked[1:]), 1) if n % 3 == 0 or n % 4 == 0]
    assert statistics.median(pauses) < 5 / 2, pauses
    assert counters["checksums"] + counters["timeouts"] >= 8, counters
    assert counters["timeouts"] <= sum(pause > 4.5 for pause in pauses), counters


def test_a_device_that_comes_back_is_polled_at_once(project, pair):
    """The back-off is a day: nothing but a probe in spare time finds the device."""
    alive = [False]
    path = project(
        serial([f"register: 0, {INT}"], port=pair.a, poll_period="200ms", response_timeout="500ms",
               attempts=2, backoff="24h"))
    with SerialSlave(pair.b, lambda frame: HONEST(frame)
                     if alive[0] else None), start("run", path, "--json") as run:
        run.wait_event(state("not_answering"), "it does not answer")
        seen = len(run.out)
        alive[0] = True
        run.wait_event(state("answering"), "it answers again", after=seen)
        run.wait_event(value("V1", 7), "a good value", after=seen)
        run.interrupt()
