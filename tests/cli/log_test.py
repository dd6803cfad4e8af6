"""The log of a run: one readable line for each failure, repeated ones summarised."""
import re
import time

from endpoints import free_port
from fake_slave import TcpSlave
from peer_base import TcpPeer
from program import DEADLINE, start, takt, until

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


def logged(folder, port, condition, *options, timeout="10s", keys=""):
    path, log = folder / "plant.yaml", folder / "takt.log"
    text = PROJECT.format(port=port, timeout=timeout)
    path.write_text(text.replace("    devices:", f"    {keys}\n    devices:"))
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
    assert any(line.endswith("line plant, device Boiler: not answering (time-out)") for line in lines), lines


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


def test_a_connection_that_the_program_closes_has_its_reason(tmp_path):
    asked = []

    def answer(request):
        asked.append(request)
        length = 7 if len(asked) % 2 else 6
        return request[:4] + bytes([0, length]) + request[6:8] + bytes([4, 0, 0, 0, 0])

    with TcpSlave(answer) as slave:
        lines = logged(tmp_path, slave.port, lambda text: "differs by one" in text)
    reason = rf"warning host: line plant: 127\.0\.0\.1:{slave.port}: the length in the header of " \
        r"a response, bytes 5 and 6, differs by one from the response: " \
        r"received .. .. 00 00 00 06 10 03 \(.*\)$"
    assert any(re.search(reason, line) for line in lines), lines


def test_a_header_with_a_wrong_field_is_shown_with_what_was_expected(tmp_path):
    with TcpSlave(lambda request: request[:2] + b"\x01" + request[3:]) as slave:
        lines = logged(tmp_path, slave.port, lambda text: "received" in text)
    message = r"the peer does not speak Modbus TCP: received (.. ..) 01 00 00 06 10 03 \(.*\), " \
        r"expected the protocol identifier 00 00 as bytes 3 and 4$"
    assert any(re.search(message, line) for line in lines), lines


class Hasty(TcpPeer):
    """Closes each connection 100 ms after it was made."""

    count = 0

    def _connected(self, peer):
        self.count += 1
        self._begin(self._close_soon, peer)

    def _close_soon(self, peer):
        with peer:
            time.sleep(0.1)


def test_a_peer_that_closes_before_the_first_request_may_be_sent(tmp_path):
    with Hasty() as peer:
        lines = logged(tmp_path, peer.port, lambda text: "pause_after" in text and peer.count > 2,
                       keys="pause_after_connect: 1s")
    early = [line for line in lines if "pause_after_connect" in line]
    assert len(early) == 1, lines
    assert re.search(
        r"warning host: line plant: the peer closed the connection \d+(\.\d)? ms after it was opened, "
        r"before `pause_after_connect` \(1000 ms\) had passed: no request was sent\. ", early[0]), lines


def test_what_a_profile_leaves_out(tmp_path):
    path, log = tmp_path / "plant.yaml", tmp_path / "takt.log"
    devices = "".join(f"      - {{name: D{n}, address: {n}, variables: []}}\n" for n in range(1, 35))
    path.write_text("takt: 1\nprofile: owen-kc1\nlines:\n  - name: L\n    port: /dev/takt-no-such-port\n"
                    f"    devices:\n{devices}")
    takt("run", path, "--log", log, code=3)  # there is no such port
    lines = [line for line in log.read_text().splitlines() if "project" in line and "32" in line]
    assert ["D33" in line or "D34" in line for line in lines] == [True, True], lines


def test_it_speaks_the_language_of_the_program(tmp_path):
    port = free_port()
    lines = logged(tmp_path, port, lambda text: "plant" in text, "--lang", "ru")
    assert "линия plant:" in lines[0], lines
