"""examples/console.yaml (a master) and examples/relay-unit.yaml (its slave) against each other, on a line that the test may damage."""
import os
import pty
import select
import threading
import time
import tty

import pytest

import endpoints
from program import ROOT, start, takt, until

PART = bytes.fromhex("010400000001 31CA")
READ = bytes.fromhex("010400000002 71CB")
ANSWER = bytes.fromhex("01040400020003 1A45")


class DamagedLine:
    """Two pseudo-terminals, joined byte by byte. `damage` holds, for each request to come, which frame loses a bit: "request",
    "answer" or None. `seen` has the requests with their time, `answers` the answers, as they were sent."""

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


def played(folder, line, damage, seconds, period="2s"):
    """Runs both for some periods. The requests that the console sent, as seconds since the first one, and its log."""
    relay = example(folder, "relay-unit", line.relay)
    console = example(
        folder, "console", line.console, **{
            "poll_period: 1min": f"poll_period: {period}",
            "backoff: 1min": f"backoff: {period}"
        })
    log = folder / "console.log"
    with start("run", relay) as slave:
        endpoints.wait_slave(line.console, 1, process=slave)
        line.forget()
        line.damage = list(damage)
        return watched(line, console, log, seconds)


def watched(line, console, log, seconds):
    with start("run", console, "--json", "--log", log) as running:
        until(lambda: line.seen, "the first request")
        time.sleep(seconds)
        running.process.terminate()
        assert running.process.wait(10) == 0, running
    requests = list(line.seen)
    assert requests[0][1] == READ and {data for _, data in requests} <= {READ, PART}
    # A part and the whole that follows it at once are one turn.
    turns = requests[:1] + [
        now for before, now in zip(requests, requests[1:]) if before[1] != PART or now[0] - before[0] > 0.3
    ]
    return [round(t - requests[0][0], 1) for t, _ in turns], log.read_text(), running


def parts(line):
    return [data for _, data in line.seen].count(PART)


def test_the_examples_poll_each_minute(tmp_path):
    for name in ("console", "relay-unit"):
        takt("check", ROOT / "examples" / f"{name}.yaml")
    plan = takt("plan", ROOT / "examples" / "console.yaml", "--json").json["lines"][0]
    assert [(r["function"], r["start"], r["quantity"], r["period_ms"]) for r in plan["requests"]
            if r["period_ms"]] == [(4, 0, 2, 60000)]


def test_without_damage_each_period_has_one_exchange(tmp_path, line):
    sent, log, _ = played(tmp_path, line, [], 4.6)
    assert sent == pytest.approx([0, 2, 4], abs=0.4)
    assert set(line.answers) == {ANSWER}
    assert "attempt" not in log
    assert parts(line) == 0


@pytest.mark.parametrize("frame, why", [("request", "no response"), ("answer", "bad checksum")])
def test_a_damaged_frame_is_repeated_once(tmp_path, line, frame, why):
    sent, log, _ = played(tmp_path, line, [frame], 2.6)
    assert len(sent) == 3 and sent[1] < 1.2 and sent[2] == pytest.approx(2, abs=0.4), sent
    # A part has another length than the answer that may be late. One with a wrong checksum has come.
    assert parts(line) == (frame == "request")
    assert f"device Relay unit (unit 1): read input registers 0..1: " in log and why in log and "attempt 1 of 2" in log, log


def test_after_the_repetition_it_waits_for_a_period(tmp_path, line):
    sent, log, _ = played(tmp_path, line, ["request", "request"], 5.4, "3s")
    assert sent[1] < 1.2 and 4 <= sent[2] <= 5, sent  # a device that answers again is read at once
    assert "attempt 2 of 2" in log and "not answering" in log, log
    assert log.rstrip().endswith("answering"), log
