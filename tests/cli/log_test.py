"""The log of a run: one readable line for each failure, repeated ones summarised."""
import re

from endpoints import free_port
from fake_slave import TcpSlave
from program import DEADLINE, start, until

PROJECT = """
takt: 1
lines:
  - name: plant
    transport: tcp
    host: 127.0.0.1
    tcp_port: {port}
    devices:
      - name: Boiler
        address: 16
        poll_period: 100ms
        response_timeout: {timeout}
        backoff: 100ms
        attempts: 3
        variables:
          - {{name: Temperature, type: float, register: 500, read: 0x03}}
"""


def logged(folder, port, condition, *options, timeout="10s"):
    path, log = folder / "plant.yaml", folder / "takt.log"
    path.write_text(PROJECT.format(port=port, timeout=timeout))
    with start("run", path, "--json", "--log", log, *options) as running:
        until(lambda: log.exists() and condition(log.read_text()), "the line in the log")
        running.process.terminate()
        assert running.process.wait(DEADLINE) == 0, running
    return log.read_text().splitlines()


def test_a_host_that_refuses_connections(tmp_path):
    port = free_port()
    lines = logged(tmp_path, port, lambda text: "refused" in text)
    assert re.search(rf"warning host: line plant: 127\.0\.0\.1:{port}: cannot be opened: connection refused$",
                     lines[0]), lines
    assert not any("cannot_open" in line for line in lines), lines


def test_a_silent_device(tmp_path):
    with TcpSlave(lambda request: None) as slave:
        lines = logged(tmp_path, slave.port,
                       lambda text: text.count("attempt") > 5 or "not answering" in text, timeout="50ms")
    failed = [line for line in lines if "read holding registers 500..501" in line]
    pattern = r"info host: line plant, device Boiler \(unit 16\): " \
        r"read holding registers 500\.\.501: no response, after \d+(\.\d)? ms, attempt {} of 3$"
    for attempt in (1, 2, 3):
        assert any(re.search(pattern.format(attempt), line) for line in failed), lines
    assert any(line.endswith("line plant, device Boiler: not answering") for line in lines), lines


def test_repeated_failures_are_one_line_and_a_count(tmp_path):
    requests = []

    def refuse(request):
        requests.append(request)
        return request[:4] + bytes([0, 3, request[6], request[7] | 0x80, 2])

    with TcpSlave(refuse) as slave:
        lines = logged(tmp_path, slave.port, lambda text: len(requests) > 8)
    refused = [line for line in lines if "exception 2" in line]
    assert len(refused) == 2, lines
    assert "exception 2: illegal data address, after" in refused[0], lines
    assert re.search(
        r"exception 2: illegal data address, attempt 1 of 3: last message repeated \d+ times in \d+ s$",
        refused[1]), lines


def test_it_speaks_the_language_of_the_program(tmp_path):
    port = free_port()
    lines = logged(tmp_path, port, lambda text: "plant" in text, "--lang", "ru")
    assert "линия plant:" in lines[0], lines
