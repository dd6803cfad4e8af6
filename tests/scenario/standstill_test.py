"""A response that the system received in time counts, also when the program was stopped until after the
time-out."""
import pathlib
import signal
import threading

import pytest

from fake_slave import SerialSlave, TcpSlave, rtu_answers, tcp_answer
from program import start, takt, until
from projects import at, serial, tcp

INT = "type: int16, read: 0x03"
TIMEOUT = 0.1
STOPS = 8


class Stopping:
    """Answers as `answers` does. The program is stopped before each of the first answers, and goes on after
    its time-out."""

    def __init__(self, answers):
        self._answers, self.process, self.stops = answers, None, 0

    def __call__(self, frame):
        if self.stops < STOPS:
            until(lambda: self.process, "the program")
            self.stops += 1
            self.process.send_signal(signal.SIGSTOP)
            state = pathlib.Path(f"/proc/{self.process.pid}/stat")
            until(lambda: state.read_text().rpartition(")")[2].split()[0] == "T", "the program is stopped")
            threading.Timer(4 * TIMEOUT, self.process.send_signal, (signal.SIGCONT, )).start()
        return self._answers(frame)


def check(command, device):
    with start(*command, "--json") as run:
        device.process = run.process
        until(lambda: device.stops == STOPS, "all stops")
        run.wait_event(lambda e: e["event"] == "value" and e["name"] == "V1", "a value")
        summary = run.interrupt().lines[-1]
    assert '"timeouts":0' in summary, summary


def command(path, way, tmp_path):
    if way == "project":
        return ["run", path]
    table = tmp_path / "table.bin"
    takt("table", "build", path, "-o", table)
    return ["run", "--table", table]


SETTINGS = {"response_timeout": f"{TIMEOUT * 1000:g}ms", "attempts": 1, "poll_period": "20ms"}


@pytest.mark.parametrize("way", ["project", "table"])
def test_a_poll_over_tcp(project, tmp_path, way):
    device = Stopping(lambda adu: tcp_answer(adu, "03 02 00 07"))
    with TcpSlave(device) as slave:
        check(command(project(tcp(at([0], INT), slave.port, **SETTINGS)), way, tmp_path), device)


@pytest.mark.parametrize("way", ["project", "table"])
def test_a_poll_over_a_serial_line(project, tmp_path, pair, way):
    device = Stopping(rtu_answers({"03 0000 0001": "03 02 00 07"}))
    with SerialSlave(pair.b, device):
        check(command(project(serial(at([0], INT), port=pair.a, **SETTINGS)), way, tmp_path), device)


def test_a_single_read():
    device = Stopping(lambda adu: tcp_answer(adu, "03 02 00 07"))
    with TcpSlave(device) as slave:
        for _ in range(STOPS):
            device.process = None
            with start("read", f"tcp://127.0.0.1:{slave.port}", "holding", 0, "--timeout",
                       f"{TIMEOUT * 1000:g}ms") as run:
                device.process = run.process
                run.finish()
    assert device.stops == STOPS
