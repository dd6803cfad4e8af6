"""Endpoints for tests: reserved TCP ports, and pairs of serial ports whose traffic is recorded."""
import contextlib
import fcntl
import os
import pathlib
import re
import socket
import subprocess
import tempfile

from frames import request
from program import until

_LOCKS = pathlib.Path(tempfile.gettempdir()) / f"takt-test-ports-{os.getuid()}"
_held = []


def free_port():
    """A TCP port of 127.0.0.1 below those that the kernel chooses by itself; reserved until this process
    ends."""
    _LOCKS.mkdir(exist_ok=True)
    first = 20000 + os.getpid() * 7 % 10000
    for port in range(first, first + 2000):
        lock = open(_LOCKS / str(port), "w")  # noqa: SIM115: held open on purpose
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            with socket.socket() as probe:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                probe.bind(("127.0.0.1", port))
        except OSError:
            lock.close()
            continue
        _held.append(lock)
        return port
    raise AssertionError("no free port")


def wait_listening(port, process=None):
    """Returns when a server accepts connections on `port`."""

    def connects():
        assert process is None or process.process.poll() is None, f"ended before it listened\n{process!r}"
        with socket.socket() as s:
            return s.connect_ex(("127.0.0.1", port)) == 0

    until(connects, f"a listener on port {port}")


class SerialPair:
    """Two pseudo-terminals joined by socat. Masters use `a`, slaves `b`; `sent()` and `answered()` are the
    bytes that passed, by socat's own record."""

    def __init__(self, folder, record=True):
        self.a, self.b, self._log = (str(pathlib.Path(folder) / name)
                                     for name in ("line-a", "line-b", "line.log"))
        with open(self._log, "w") as log:
            self._socat = subprocess.Popen(
                ["socat", *["-x"] * record, f"pty,raw,echo=0,link={self.a}", f"pty,raw,echo=0,link={self.b}"],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log)
        until(lambda: os.path.exists(self.a) and os.path.exists(self.b), "the links of socat")
        # A pseudo-terminal without an open descriptor ends socat and loses its settings.
        self._open_ends = [os.open(end, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK) for end in (self.a, self.b)]

    def break_off(self):
        """Both ports are gone, as when an adapter is pulled."""
        self._socat.terminate()
        self._socat.wait()

    def close(self):
        for end in self._open_ends:
            os.close(end)
        self._socat.terminate()
        self._socat.wait()

    def passed(self):
        """(from b, bytes) for each chunk that passed, in turn."""
        found, written = [], pathlib.Path(self._log).read_text()
        for line in written[:written.rfind("\n") + 1].splitlines():  # socat may be within a line
            if re.match(r"[<>] \d", line):
                found.append((line[0] == "<", b""))
            elif found:
                found[-1] = (found[-1][0], found[-1][1] + bytes.fromhex(line))
        return found

    def sent(self):
        return b"".join(data for from_b, data in self.passed() if not from_b)

    def answered(self):
        return b"".join(data for from_b, data in self.passed() if from_b)


@contextlib.contextmanager
def serial_pair(folder, record=True):
    """`record=False`: without `sent()` and `answered()`, which take time for each byte."""
    pair = SerialPair(folder, record)
    try:
        yield pair
    finally:
        pair.close()


def wait_slave(port, unit, framing="rtu", process=None):
    """Returns when `unit` answers on the serial port `port` with any answer."""
    import serial  # only here: most tests need no serial port
    probe = request(framing, unit, "03 00 00 00 01")
    with serial.Serial(port, timeout=0.2) as line:

        def answers():
            assert process is None or process.process.poll() is None, f"ended before it answered\n{process!r}"
            line.write(probe)
            return line.read(1)

        until(answers, f"an answer of unit {unit} on {port}")
        while line.read(1):
            pass


@contextlib.contextmanager
def swallowing_host():
    """The port of a listener whose queue is full: the kernel silently drops further connection attempts."""
    with socket.socket() as listener, contextlib.ExitStack() as queue:
        listener.bind(("127.0.0.1", 0))
        listener.listen(0)
        for _ in range(3):
            client = queue.enter_context(socket.socket())
            client.setblocking(False)
            client.connect_ex(listener.getsockname())
        yield listener.getsockname()[1]
