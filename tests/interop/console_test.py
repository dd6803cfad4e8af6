"""examples/console.yaml (a master) and examples/relay-unit.yaml (its slave) against each other, on a line
that the test may damage."""
import contextlib
import os
import pty
import select
import threading
import time
import tty

import pytest

import endpoints
from program import ROOT, WITHOUT_WAITING, start, takt, until

PART = bytes.fromhex("010400000001 31CA")
READ = bytes.fromhex("010400000002 71CB")
ANSWER = bytes.fromhex("01040400020003 1A45")


class DamagedLine:
    """Two pseudo-terminals, joined byte by byte. `damage` holds, for each request to come, which frame loses
    a bit: "request", "answer" or None. `seen` has the requests with their time, `answers` the answers, as
    they were sent."""

    def __init__(self):
        self.damage, self.seen, self.answers = [], [], []
        self._near, self._far = pty.openpty(), pty.openpty()
        for end in (*self._near, *self._far):
            tty.setraw(end)
        self.console, self.relay = (os.ttyname(pair[1]) for pair in (self._near, self._far))
        self._stop, self._stopping = os.pipe()
        self._thread = threading.Thread(target=self._forward)
        self._thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.write(self._stopping, b"x")
        self._thread.join()
        for end in (*self._near, *self._far, self._stop, self._stopping):
            os.close(end)

    def forget(self):
        self.seen.clear()
        self.answers.clear()

    def _forward(self):
        near, far, now = self._near[0], self._far[0], None
        while True:
            ready = select.select([near, far, self._stop], [], [])[0]
            if self._stop in ready:
                return
            if near in ready:
                data = os.read(near, 256)
                self.seen.append((time.monotonic(), data))
                now = self.damage.pop(0) if self.damage else None
                os.write(far, flipped(data) if now == "request" else data)
            if far in ready:
                data = os.read(far, 256)
                self.answers.append(data)
                os.write(near, flipped(data) if now == "answer" else data)


def flipped(frame):
    return frame[:3] + bytes([frame[3] ^ 0x10]) + frame[4:]


@pytest.fixture
def line():
    with DamagedLine() as joined:
        yield joined


def example(folder, name, port, **changes):
    """The example on `port`, with other times where the test cannot wait for minutes."""
    text = (ROOT / "examples" / f"{name}.yaml").read_text()
    changes["/dev/ttyUSB1" if name == "relay-unit" else "/dev/ttyUSB0"] = port
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    path = folder / f"{name}.yaml"
    path.write_text(text)
    return path


@contextlib.contextmanager
def running(folder, line, damage, minute="1min"):
    """Both examples at work, on a line that damages the first frames. Yields the running console, and its
    log."""
    changes = {"response_timeout: 500ms": "response_timeout: 2s"}  # a busy machine loses no frame
    if minute != "1min":
        changes |= {f"{key}: 1min": f"{key}: {minute}" for key in ("poll_period", "backoff")}
    relay = example(folder, "relay-unit", line.relay, **{"byte_timeout: 30ms": "byte_timeout: 1s"})
    console, log = example(folder, "console", line.console, **changes), folder / "console.log"
    with start("run", relay) as slave:
        endpoints.wait_slave(line.console, 1, process=slave)
        line.forget()
        line.damage = list(damage)
        with start("run", console, "--json", "--log", log) as run:
            yield run, log
            requests = [data for _, data in line.seen]
            assert requests[0] == READ and set(requests) <= {READ, PART}


def read_times(line):
    """When the console asked for both values. A part of them may be asked for before."""
    return [t for t, data in line.seen if data == READ]


def parts(line):
    return [data for _, data in line.seen].count(PART)


def values(run):
    return [e for e in run.events() if e["event"] == "value" and e["quality"] == "good"]


def test_the_examples_poll_each_minute(tmp_path):
    for name in ("console", "relay-unit"):
        takt("check", ROOT / "examples" / f"{name}.yaml")
    plan = takt("plan", ROOT / "examples" / "console.yaml", "--json").json["lines"][0]
    assert [(r["function"], r["start"], r["quantity"], r["period_ms"]) for r in plan["requests"]
            if r["period_ms"]] == [(4, 0, 2, 60000)]


def test_without_damage_each_period_has_one_exchange(tmp_path, line):
    with running(tmp_path, line, [], "1s") as (run, log):
        until(lambda: len(line.answers) >= 4, "four periods")
        run.interrupt()
    times = read_times(line)
    # The first may be late on a busy machine, none is early.
    assert all(t - times[0] > n - 1.1 for n, t in enumerate(times)), times
    assert set(line.answers) == {ANSWER}
    assert "attempt" not in log.read_text()
    assert parts(line) == 0


@pytest.mark.parametrize("frame, why", [("request", "no response"), ("answer", "bad checksum")])
def test_a_damaged_frame_is_repeated_once(tmp_path, line, frame, why):
    """At once: the next period is a minute away."""
    with running(tmp_path, line, [frame]) as (run, log):
        until(lambda: len(values(run)) >= 2, "both values", WITHOUT_WAITING)
        run.interrupt()
    # A part has another length than the answer that may be late. One with a wrong checksum has come.
    expected = [READ, PART, READ] if frame == "request" else [READ, READ]
    assert [data for _, data in line.seen][:len(expected)] == expected
    assert parts(line) == (frame == "request")
    assert frame == "request" or len(line.seen) == 2
    text = log.read_text()
    assert "device Relay unit (unit 1): read input registers 0..1: " in text and why in text, text
    assert "attempt 1 of 2" in text and "attempt 2 of 2" not in text, text


def test_after_the_repetition_it_waits_for_a_period(tmp_path, line):
    with running(tmp_path, line, ["request", "request"], "3s") as (run, log):
        until(lambda: len(values(run)) >= 2, "both values")
        run.interrupt()
    assert [data for _, data in line.seen][:3] == [READ, PART, READ]
    pause = line.seen[2][0] - line.seen[1][0]
    assert pause >= 2 + 3 - 0.1, "from the time-out of the second attempt on"
    text = log.read_text()
    assert text.index(": answering") > text.index(": not answering")
    assert "attempt 2 of 2" in text and text.count("not answering") == 1, text
