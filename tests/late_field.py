#!/usr/bin/env python3
"""A field whose devices answer late, beside `takt run`: an independent slave with real byte times, and a
judge of every published value.

The slave shares no code with takt. Its units are on a pseudo-terminal (RTU), or behind a gateway (RTU over
TCP). Each frame takes its time at the bit rate. A share of the answers of some units comes `factor` time-outs
after its request. In order: the requests that follow wait behind it, as in a device with one task. Out of
order: they are answered at once.

Each value holds the identity of its register and the moment of its reading, so a published value proves its
origin and its age. `wrong`: a good value of another register. `old`: a good value that was read before the
request for it can have been sent. What the slave itself sent too late, because the machine was busy, is added
to the age allowed.

By hand: tests/late_field.py [--seconds 60] [--factor 1.2 4 40] [--share 40 4] [--order in out] [--late 1 3]
[--transport pty tcp]: all combinations one after the other. --share N: one in N answers. TAKT names the
program. --before PROGRAM: another version runs in the same field beside it, and the right values a second of
both are compared.
"""
import argparse
import concurrent.futures
import datetime
import heapq
import itertools
import json
import multiprocessing
import os
import pathlib
import random
import select
import struct
import sys
import tempfile
import time

import program
from frames import crc16
from peer_base import PtyPeer, TcpPeer
from program import start, until

BAUD = 19200
CHARACTER = 10 / BAUD
SILENCE = 3.5 * CHARACTER
TURNAROUND = 0.003
TIMEOUT = 0.1
UNITS = (1, 2, 3)
# Function and first register of each variable: three requests of one shape, and two of other shapes.
SHAPES = {"a": (3, 0, 2), "b": (3, 100, 2), "c": (3, 200, 2), "d": (4, 0, 2), "e": (3, 300, 4)}
CLOCK_BITS = 22  # milliseconds: more than an hour
START = time.time()


def now_ms():
    return int((time.time() - START) * 1000) & ((1 << CLOCK_BITS) - 1)


def identity(unit, function, register):
    """Ten bits that no other value of the field has."""
    return (unit << 8 | function << 5 | register // 100 << 2) & 0x3FF


def words(unit, function, start, count):
    """Registers in pairs: the upper ten bits of each pair identify it, the others are the time of the read. A
    read may end within a pair."""
    moment = now_ms()
    made = b""
    for register in range(start, start + count, 2):
        made += struct.pack(">I", (identity(unit, function, start) | (register - start) // 2) << CLOCK_BITS
                            | moment)
    return made[:2 * count]


class Lateness:
    """How the late units answer."""

    def __init__(self, factor=4.0, share=40, order="in", late=1, seed=1, timeout=TIMEOUT):
        self.factor, self.share, self.order, self.timeout = factor, share, order, timeout
        self.units = UNITS[:late]
        self.random = random.Random(seed)

    def delay(self, unit):
        late = unit in self.units and self.random.random() < 1 / self.share
        return self.factor * self.timeout if late else 0.0


class Field:
    """The units on one line. `_send(bytes)` writes to the master; `take(bytes)` gets what the master sent."""

    def __init__(self, lateness):
        self.lateness = lateness
        self.asked = self.late = 0
        self.slip = 0.0  # by how many seconds an answer was sent too late at most
        self._waiting = []  # (when its transmission may begin, number, frame)
        self._number = itertools.count()
        self._line_free = 0.0
        self._unit_free = dict.fromkeys(UNITS, 0.0)
        self._held = b""

    def take(self, data):
        self._held += data
        while len(self._held) >= 8:
            frame, self._held = self._held[:8], self._held[8:]
            if crc16(frame[:6]) == frame[6:]:
                self._answer(frame)
            else:
                self._held = b""

    def _answer(self, frame):
        self.asked += 1
        unit, function, start, count = struct.unpack(">BBHH", frame[:6])
        received = max(time.monotonic(), self._line_free) + 8 * CHARACTER
        self._line_free = received
        if unit not in UNITS:
            return
        delay = self.lateness.delay(unit)
        self.late += delay > 0
        begins = max(received,
                     self._unit_free[unit] if self.lateness.order == "in" else 0.0) + TURNAROUND + delay
        self._unit_free[unit] = begins
        body = bytes([unit, function, 2 * count]) + words(unit, function, start, count)
        heapq.heappush(self._waiting, (begins, next(self._number), body + crc16(body)))

    def run_until(self, stopped, readable, receive, send):
        """Serves until `stopped()`; waits for input with `readable(seconds)`."""
        on_wire = None  # (its end, frame)
        while not stopped():
            now = time.monotonic()
            if on_wire and on_wire[0] <= now:
                send(on_wire[1])
                self.slip = max(self.slip, time.monotonic() - on_wire[0])
                on_wire = None
            if not on_wire and self._waiting and max(self._waiting[0][0], self._line_free + SILENCE) <= now:
                frame = heapq.heappop(self._waiting)[2]
                on_wire = (now + len(frame) * CHARACTER, frame)
                self._line_free = on_wire[0]
            next_event = on_wire[0] if on_wire else now + 0.02
            if not on_wire and self._waiting:
                next_event = min(next_event, max(self._waiting[0][0], self._line_free + SILENCE))
            if readable(max(0.0, min(next_event - now, 0.02))):
                data = receive()
                if data is None:
                    return
                self.take(data)


class PtyField(PtyPeer):
    """A field on a pseudo-terminal; `line` is what the project says of it."""

    def __init__(self, lateness):
        self.field = Field(lateness)

    @property
    def line(self):
        return f"transport: serial, port: {self.port}, framing: rtu, baud: {BAUD}"

    def _run(self):
        self.field.run_until(self._stop.is_set, self._readable, lambda: os.read(self._master, 300),
                             lambda frame: os.write(self._master, frame))


class GatewayField(TcpPeer):
    """A field behind a gateway that passes RTU frames over TCP, one connection at a time."""

    def __init__(self, lateness):
        self.field = Field(lateness)
        super().__init__()
        self.line = f"transport: tcp, host: 127.0.0.1, tcp_port: {self.port}, framing: rtu"

    def _connected(self, peer):
        with peer:
            try:
                self.field.run_until(self._stop.is_set, lambda s: select.select([peer], [], [], s)[0],
                                     lambda: peer.recv(300) or None, peer.sendall)
            except ConnectionError:
                pass


TRANSPORTS = {"pty": PtyField, "tcp": GatewayField}


def project_text(line, period_ms, units=UNITS, shapes=tuple(SHAPES), timeout=TIMEOUT):
    """Every device has each of the shapes; nothing is grouped."""
    text = f"takt: 1\nlines:\n  - {{name: field, {line}, devices: [\n"
    for unit in units:
        text += (f"      {{name: D{unit}, address: {unit}, poll_period: {period_ms}ms, response_timeout: "
                 f"{int(timeout * 1000)}ms, strategy: classic, high_register_first: true, variables: [\n")
        for name, (function, start, count) in ((s, SHAPES[s]) for s in shapes):
            for i in range(count // 2):
                text += (f"        {{name: d{unit}{name}{i}, type: uint32, register: {start + 2 * i}, "
                         f"read: 0x0{function}}},\n")
        text += "      ]},\n"
    return text + "    ]}\n"


class Verdict:
    """Counts of the published values. `uncertain` counts those that are neither good nor bad."""

    def __init__(self, timeout=TIMEOUT, slip=0.0):
        # A request has waited for 1.15 time-outs at most. The rest is the host's.
        self.oldest = 1.65 * timeout + slip
        self.good = self.wrong = self.old = self.uncertain = 0
        self.first_good_ms = self.last_good_ms = None
        self.examples = []

    def judge(self, event):
        if event.get("event") != "value" or not event["name"].startswith("d"):
            return
        if event["quality"] != "good":
            self.uncertain += event["quality"] == "uncertain"
            return
        self.good += 1
        self.first_good_ms = event["time_ms"] if self.first_good_ms is None else self.first_good_ms
        self.last_good_ms = event["time_ms"]
        name, value = event["name"], event["value"]
        function, start, _ = SHAPES[name[2]]
        expected = identity(int(name[1]), function, start) | int(name[3])
        seen = value >> CLOCK_BITS
        published = datetime.datetime.fromisoformat(event["time"]).timestamp() - START
        age = published - (value & ((1 << CLOCK_BITS) - 1)) / 1000 - event["age_ms"] / 1000
        if seen != expected:
            self.wrong += 1
            self._example(
                f"{name} at {event['time_ms']:.0f} ms: of unit {seen >> 8}, function {seen >> 5 & 7}, "
                f"register {(seen >> 2 & 7) * 100 + 2 * (seen & 3)}")
        elif age > self.oldest:
            self.old += 1
            self._example(f"{name} at {event['time_ms']:.0f} ms: read {age * 1000:.0f} ms before")

    def _example(self, text):
        if len(self.examples) < 5:
            self.examples.append(text)

    def __str__(self):
        return f"good {self.good} wrong {self.wrong} old {self.old} uncertain {self.uncertain}"


def run_field(transport="pty", seconds=4.0, period_ms=50, units=3, shapes="abcde", **lateness):
    """@returns (verdict, requests the field has seen, answers that were late, values a second, the
    summary)"""
    with TRANSPORTS[transport](Lateness(**lateness)) as served, tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "field.yaml"
        timeout = served.field.lateness.timeout
        text = project_text(served.line, period_ms, UNITS[:units], shapes, timeout)
        path.write_text(text, encoding="utf-8")
        with start("run", path, "--json") as run:
            time.sleep(seconds)
            until(lambda: served.field.late > 0 or not served.field.lateness.units, "a late answer")
            result = run.interrupt(code=None)
        verdict = Verdict(timeout, served.field.slip)
        summary = None
        for line in result.lines:
            event = json.loads(line)
            verdict.judge(event)
            summary = event if event.get("event") == "summary" else summary
        assert summary, repr(result)
        return verdict, served.field.asked, served.field.late, verdict.good / seconds, summary


def run_with(executable, field):
    """run_field() in a process of its own. @returns (verdict, right values a second)"""
    program.TAKT = executable
    verdict, _, _, rate, _ = run_field(**field)
    return verdict, rate * (1 - (verdict.wrong + verdict.old) / max(1, verdict.good))


def compare(before, field):
    """Both versions at the same time, each in a field of its own, so that what else the machine does slows
    both."""
    with concurrent.futures.ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        old, new = pool.map(run_with, [before, program.TAKT], [field, field])
    return (f"before {old[1]:.1f} right values/s ({old[0].wrong} wrong of {old[0].good}), "
            f"now {new[1]:.1f} ({new[0].wrong} of {new[0].good}), ratio {new[1] / max(old[1], 0.01):.2f}")


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--period", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--factor", type=float, nargs="+", default=[1.2, 4, 40])
    parser.add_argument("--share", type=int, nargs="+", default=[40, 4])
    parser.add_argument("--order", nargs="+", default=["in", "out"], choices=["in", "out"])
    parser.add_argument("--late", type=int, nargs="+", default=[1, 3], choices=[0, 1, 2, 3])
    parser.add_argument("--units", type=int, default=3, choices=[1, 2, 3])
    parser.add_argument("--shapes", default="abcde",
                        help="which requests of each unit: a, b and c look alike")
    parser.add_argument("--transport", nargs="+", default=["pty", "tcp"], choices=list(TRANSPORTS))
    parser.add_argument("--before", metavar="PROGRAM")
    options = parser.parse_args()
    failed = 0
    for transport, late, order, share, factor in itertools.product(options.transport, options.late,
                                                                   options.order, options.share,
                                                                   options.factor):
        name = f"{transport}, {late} late, 1 in {share}, {factor:g} time-outs, {order} order"
        field = {
            "transport": transport,
            "seconds": options.seconds,
            "period_ms": options.period,
            "units": options.units,
            "shapes": options.shapes,
            "factor": factor,
            "share": share,
            "order": order,
            "late": late,
            "seed": options.seed
        }
        if options.before:
            print(f"{name}: {compare(options.before, field)}", flush=True)
            continue
        verdict, asked, was_late, rate, _ = run_field(**field)
        failed += verdict.wrong + verdict.old > 0
        print(f"{name}: {verdict}, asked {asked}, late {was_late}, {rate:.1f} values/s", flush=True)
        for example in verdict.examples:
            print(f"  {example}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
