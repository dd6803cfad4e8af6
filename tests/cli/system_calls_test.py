"""The system calls of the thread that polls and serves, in steady state: none that may wait for another
thread or a disk."""
import pathlib
import re
import signal
import subprocess

import pytest

from endpoints import free_port, serial_pair, wait_listening
from program import DEADLINE, TAKT, start, until

# Waiting for events and timers, and the bytes of sockets and serial ports. `write` may go to a serial port or
# an eventfd only: see DESCRIPTORS.
ALLOWED = {
    "epoll_wait", "epoll_pwait", "epoll_pwait2", "epoll_ctl", "timerfd_settime", "read", "write", "recvfrom",
    "sendto", "ioctl", "clock_nanosleep", "restart_syscall"
}
# The runtime of the sanitizers has memory of its own, and probes addresses with a pipe. Another test counts
# allocations.
SANITIZER = {"mmap", "munmap", "madvise", "pipe2", "pipe", "close"}
DESCRIPTORS = re.compile(
    r"^(/dev/(pts|tty)|socket:|TCP|UNIX|anon_inode:\[(eventfd|timerfd|eventpoll|signalfd)\])")

PROJECT = """takt: 1
lines:
  - name: serial
    transport: serial
    port: {port}
    baud: 115200
    devices:
      - {{name: Boiler, address: 1, poll_period: 10ms, turnaround: 2ms, response_timeout: 10s, variables: [
          {{name: Level, type: int, register: 0, read: 0x03}}]}}
  - name: network
    transport: tcp
    host: 127.0.0.1
    tcp_port: {tcp_port}
    devices:
      - {{name: Meter, address: 1, poll_period: 10ms, response_timeout: 10s, variables: [
          {{name: Power, type: int, register: 0, read: 0x03}}]}}
"""


def io_thread(process):
    """The thread named takt-io; the only one that works in `takt serve` is the first."""
    tasks = pathlib.Path(f"/proc/{process.process.pid}/task")
    return until(
        lambda: next(
            (int(t.name) for t in tasks.iterdir() if (t / "comm").read_text().strip() == "takt-io"), None),
        "the I/O thread")


def trace(thread, path, calls=600):
    """(name, the rest of the line) of at least so many system calls of a thread."""
    command = ["strace", "-y", "-s", "0", "-o", str(path), "-p", str(thread)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as strace:
        try:
            until(lambda: path.exists() and path.read_text().count("\n") >= calls, f"{calls} system calls")
        finally:
            strace.send_signal(signal.SIGINT)
            strace.wait(DEADLINE)
    lines = path.read_text().splitlines()
    return [found.groups() for found in (re.match(r"(\w+)\((.*)$", line) for line in lines) if found]


def may_wait(name, rest, allowed):
    if name == "futex":  # a wake-up of another thread does not wait, as of the one that logs a late device
        return "FUTEX_WAKE" not in rest
    return name not in allowed or (name == "close" and "<pipe:" not in rest)


def expect_only_allowed(calls):
    sanitized = b"__asan_init" in pathlib.Path(TAKT).read_bytes()
    allowed = ALLOWED | SANITIZER if sanitized else ALLOWED
    others = [call for call in calls if may_wait(*call, allowed)]
    assert not others, others[:10]
    for name, rest in calls:
        if name in ("write", "read"):
            target = re.match(r"\d+<([^>]*)>", rest)
            assert target and (DESCRIPTORS.match(target.group(1)) or
                               (sanitized and target.group(1).startswith("pipe:"))), (name, rest)


@pytest.fixture
def plant(tmp_path):
    """A project polled over a serial and a TCP line, and the two programs that serve its devices."""
    port = free_port()
    with serial_pair(tmp_path) as pair, start("serve", "--port", f"rtu://{pair.b}?baud=115200") as serial, \
            start("serve", "--listen", f"127.0.0.1:{port}", "--capture", tmp_path / "serve.pcapng",
                  "--traffic", tmp_path / "serve.log") as network:
        wait_listening(port, network)
        path = tmp_path / "plant.yaml"
        path.write_text(PROJECT.format(port=pair.a, tcp_port=port))
        yield path, serial, network


def test_of_run_and_serve(plant, tmp_path):
    path, serial, network = plant
    with start("run", path, "--json", "--capture", tmp_path / "run.pcapng", "--log", tmp_path / "takt.log",
               "--traffic", tmp_path / "run.log") as run:
        run.wait_event(lambda e: e.get("name") == "Power", "a value of the TCP line")
        run.wait_event(lambda e: e.get("name") == "Level", "a value of the serial line")
        calls = trace(io_thread(run), tmp_path / "run.strace")
        expect_only_allowed(calls)
        assert {name
                for name, _ in calls} >= {"write", "read", "recvfrom", "sendto"}, "both lines were polled"
        for name, process in (("serial", serial), ("network", network)):
            expect_only_allowed(trace(process.process.pid, tmp_path / f"{name}.strace", 200))
        run.interrupt()
