"""A plant with everything at once: devices on TCP and a pseudo-terminal, a relay, a mirror, MQTT, a history
and three pages that edit. Its program is killed and stopped, and meets full disks, broken files and jumps of
the clock."""
import contextlib
import mmap
import random
import signal
import struct
import threading
import time

from endpoints import free_port
from field import CountingDevice, PtyField, TcpField
from journal_files import JournalFolder
from judge import Counting
from ledger import require
from life_clients import MirrorClient, PageClient, RelayClient
from plant import NOT_STORED, Plant

SECOND = 1_000_000_000
BROKEN = b"\n  - {: broken\n"
UNITS = {"Tcp": 1, "Pty": 2}
MIRRORS = 9  # the unit of the mirrored values
VALUES = {
    f"{name}.{value}": lambda text: int(text) if text else None
    for name in UNITS
    for value in ("Count", "Fixed")
}
TROUBLES = ("broker", "broker", "hold_up", "hold_down", "cut", "clock", "clock", "disk", "file", "reload")
PROJECT = """takt: 1
lines:
  - name: ethernet
    host: 127.0.0.1
    tcp_port: {tcp_port}
    devices:
      - name: Tcp
        address: {units[Tcp]}
        poll_period: 20ms
        high_register_first: true
        variables:
          - {{name: Tcp.Count, type: uint32, register: 0, read: 0x03}}
          - {{name: Tcp.Fixed, type: uint16, register: 2, read: 0x03}}
  - name: serial
    port: {pty}
    baud: 115200
    parity: none
    devices:
      - name: Pty
        address: {units[Pty]}
        poll_period: 50ms
        high_register_first: true
        variables:
          - {{name: Pty.Count, type: uint32, register: 0, read: 0x03}}
          - {{name: Pty.Fixed, type: uint16, register: 2, read: 0x03}}
locals:
  - {{name: Page0, type: int32, comment: "0"}}
  - {{name: Page1, type: int32, comment: "0"}}
  - {{name: Page2, type: int32, comment: "0"}}
servers:
  - name: gate
    listen: 127.0.0.1
    tcp_port: {gate}
    relay: [{{line: serial, units: [{units[Pty]}]}}]
    units:
      - address: {mirrors}
        high_register_first: true
        mirror: {{area: holding_register, devices: [Tcp]}}
outputs:
  - name: cloud
    transport: mqtt
    brokers: [mqtt://127.0.0.1:{broker}]
    topic: plant/{{device}}/{{variable}}
    retention: 7d
    devices: [Tcp, Pty]
    retain: false
  - name: hist
    transport: history
    devices: [Tcp, Pty]
"""


class Trouble:
    """The memory that the program shares (kill_points.cpp, TAKT_TROUBLE)."""

    def __init__(self, path):
        self.path = path
        path.write_bytes(bytes(16))
        with open(path, "r+b") as file:
            self._memory = mmap.mmap(file.fileno(), 16)

    def set_clock(self, offset_ns):
        struct.pack_into("<q", self._memory, 0, offset_ns)

    def set_disk_full(self, full):
        struct.pack_into("<q", self._memory, 8, full)


class LivingPlant(Plant):
    """`seed` decides everything but the moments at which the operating system runs the threads."""

    values = VALUES

    def __init__(self, takt, kill_points, folder, seed, seconds):
        self.seconds, self.offset, self.offsets = seconds, 0, [0]
        self._good = None  # the project, while its file is broken
        self.devices = {
            name: CountingDevice(unit, random.Random(seed * 10 + unit))
            for name, unit in UNITS.items()
        }
        self.gate, self.page = free_port(), free_port()
        self._stack = contextlib.ExitStack()
        self._tcp = self._stack.enter_context(TcpField(self.devices["Tcp"]))
        self._pty = self._stack.enter_context(PtyField(self.devices["Pty"]))
        super().__init__(takt, kill_points, folder, seed, "everything")
        # A full disk costs delivered records, which a replay after the death of a broker would need.
        spared = self.random.choice(("broker", "disk"))
        self.troubles = [kind for kind in TROUBLES if kind != spared]
        self.ledger.keeps = spared == "disk"
        self.counting = Counting(self.ledger, self.devices)
        self.trouble = Trouble(self.folder / "trouble")
        self.editing = threading.Lock()
        self.clients = [
            PageClient(seed + i, i, self.page, self.devices, self.editing) for i in range(3)
        ] + [
            RelayClient(seed + 3, self.gate, UNITS["Pty"]),
            MirrorClient(seed + 4, self.gate, MIRRORS, self.devices["Tcp"])
        ]

    def _journal_of(self, output):
        kept = self.folder / "removed" / output
        kept.mkdir(parents=True)
        return JournalFolder(self.folder / "plant.journal" / output, output, kept)

    def _write_project(self):
        self.retention = "7d"
        self.project.write_text(
            PROJECT.format(tcp_port=self._tcp.port, pty=self._pty.port, units=UNITS, gate=self.gate,
                           mirrors=MIRRORS, broker=self.wire.port))

    def run(self, lives, progress=lambda: None):
        for client in self.clients:
            client.start()
        try:
            return super().run(lives, progress)
        finally:
            for client in self.clients:
                client.ended = True
            for client in self.clients:
                client.join()
            self._stack.close()

    def _start(self, command, **popen):
        if command[0] == "run":
            command = [
                *command, "--web", f"127.0.0.1:{self.page}", "--allow-write", "--traffic",
                str(self.folder / f"traffic-{self.wire.run_number + 1}.txt")
            ]
        environment = popen.pop("env", {}) | {
            "TAKT_TROUBLE": str(self.trouble.path),
            "TAKT_REMOVED": str(self.folder / "removed")
        }
        return super()._start(command, env=environment, **popen)

    def _delay(self):
        return self.seconds * self.random.uniform(0.3, 1.7)

    def _kill_once(self, delay):
        """A life. Half of them end in order, also in the middle of troubles."""
        self.offsets = [self.offset]
        end = self.random.choice((None, signal.SIGTERM, signal.SIGINT, None))
        if end is None:
            super()._kill_once(delay)
        else:
            begin = time.time_ns()
            code = self._live(delay, end, {})
            require(code in (0, NOT_STORED), "the program ended with a failure", code, self._errors())
            self.counts["stops"] += 1
            self._judge(begin)
        for client in self.clients:
            if client.failure:
                raise client.failure

    def _live(self, delay, end, environment):
        code = super()._live(delay, end, environment)
        self.trouble.set_disk_full(False)
        self._mend_file()
        return code

    def _judge(self, begin, killed=False):
        super()._judge(begin, killed)
        self.counting.check()

    def _window(self, begin):
        first, last = super()._window(begin)
        return first + min(self.offsets), last + max(self.offsets)

    def _actions(self, delay):
        """One trouble in two seconds, and the end of each."""
        if self.broker.process is None:
            yield self.random.uniform(0, 1), self.broker.start
        for _ in range(max(1, round(delay / 2))):
            kind = self.random.choice(self.troubles)
            at = self.random.uniform(0.5, max(0.6, delay))
            back = at + self.random.uniform(0.05, 1.5)
            self.counts[f"trouble {kind}"] += 1
            if kind == "broker":
                yield at, self._kill_broker
                yield back, self.broker.start
            elif kind in ("hold_up", "hold_down", "cut"):
                yield at, lambda kind=kind: self._trouble(kind)
                yield back, lambda: self._trouble("pass")
            elif kind == "clock":
                yield at, self._set_clock
            elif kind == "disk":
                yield at, lambda: self.trouble.set_disk_full(True)
                yield back, lambda: self.trouble.set_disk_full(False)
            elif kind == "file":
                yield at, self._break_file
                yield back, self._mend_file
            else:
                yield at, self._reload

    def _set_clock(self):
        largest = self.random.choice((SECOND // 10, 3 * SECOND, 7200 * SECOND))
        self.offset = self.random.randint(-largest, largest)
        self.offsets.append(self.offset)
        self.trouble.set_clock(self.offset)

    def _reload(self):
        self.program.send_signal(signal.SIGHUP)

    def _break_file(self):
        """Another program leaves the project in half. The running project stays."""
        if self._good is not None:
            return
        with self.editing:
            self._good = self.project.read_bytes()
            self._replace(self._good[:self.random.randrange(len(self._good))] + BROKEN)
        self._reload()

    def _mend_file(self):
        if self._good is None:
            return
        with self.editing:
            require(self.project.read_bytes().endswith(BROKEN), "the page replaced a broken file")
            self._replace(self._good)
            self._good = None
        if self.program.poll() is None:
            self._reload()

    def _replace(self, content):
        fresh = self.folder / "fresh.yaml"
        fresh.write_bytes(content)
        fresh.rename(self.project)

    def _end_in_order(self):
        self.offsets = [self.offset]
        return super()._end_in_order()

    def _summary(self):
        counts = super()._summary() + self.counting.counts
        for client in self.clients:
            behind = client.counts.pop("values behind", 0)
            counts += client.counts
            counts["values behind at most"] = max(counts["values behind at most"], behind)
        return counts
