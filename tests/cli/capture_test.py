"""Captures of takt: run and serve --capture, opened by tshark and measured by takt latency."""
import json
import os
import shutil
import signal
import socket
import struct
import subprocess
import sys

import pytest

from captures import adu, blocks, packets_in
from endpoints import free_port, wait_listening
from frames import crc16
from peer_base import PtyPeer
from program import DEADLINE, TAKT, environment, start, takt, until

LINE = """  - name: {name}
    transport: {transport}
    framing: {framing}
{more}
    devices:
      - name: {device}
        address: {unit}
        poll_period: 50ms
        turnaround: 2ms
        variables:
          - {{name: {device} level, type: int, register: 0, read: 0x03, write: {write}}}
"""


def line(name, device, unit, framing="rtu", transport="simulated", more="", write="0x06"):
    return LINE.format(name=name, device=device, unit=unit, framing=framing, transport=transport, write=write,
                       more="\n".join("    " + m for m in more.split("; ") if m))


def project(tmp_path, *lines):
    path = tmp_path / "plant.yaml"
    path.write_text("takt: 1\nlines:\n" + "".join(lines))
    return path


def tshark(path, *options):
    done = subprocess.run(["tshark", "-n", "-r", str(path), *options], capture_output=True, text=True,
                          timeout=DEADLINE, check=True)
    warnings = [w for w in done.stderr.splitlines() if "Running as user" not in w]
    assert not warnings, warnings
    return done.stdout


def fields(path, *names):
    """The first value of each field in each packet. Fails if Wireshark reports a warning, an error or a
    note, also about checksums. A comment is less than a note."""
    checks = ("-o", "ip.check_checksum:TRUE", "-o", "tcp.check_checksum:TRUE")
    judged = ("_ws.expert.severity", "_ws.malformed", "tcp.analysis.flags")
    options = (part for name in (*judged, *names) for part in ("-e", name))
    rows = tshark(path, *checks, "-T", "fields", "-E", "occurrence=a", "-E", "aggregator=\x1f", *options)
    found = []
    for row in rows.splitlines():
        severities, *others = row.split("\t")
        assert all(int(s, 0) < 0x400000 for s in severities.split("\x1f") if s), row
        assert others[:2] == ["", ""], row
        found.append([value.split("\x1f")[0] for value in others[2:]])
    return found


@pytest.mark.parametrize("framing, more", [("rtu", ""), ("ascii", "data_bits: 7")])
def test_a_serial_line_is_decoded_and_measured(tmp_path, framing, more):
    capture = tmp_path / "run.pcapng"
    with start("run", project(tmp_path, line("rs485-1", "Boiler", 16, framing, more=more)), "--stdin",
               "--json", "--capture", capture) as run:
        run.wait_event(lambda e: e.get("name") == "Boiler level", "a value")
        run.send("write \"Boiler level\" 1234")
        run.wait_event(lambda e: e.get("outcome") == "done", "the outcome of the write")
        run.send("quit")
        run.finish()
    rows = fields(capture, "frame.interface_name", "modbus.func_code", "mbtcp.unit_id",
                  "modbus.response_time", "frame.comment", "frame.packet_flags_direction")
    assert {(r[0], r[2]) for r in rows} == {("rs485-1", "16")}
    assert {r[1] for r in rows} >= {"3", "6"}
    responses = [r for r in rows if r[3]]
    assert responses and all(float(r[3]) > 0.002 for r in responses)
    assert {int(r[5], 0) & 3
            for r in responses} == {1} and {int(r[5], 0) & 3
                                            for r in rows if not r[3]} == {2}
    start_of_frame = "Boiler | 10 03" if framing == "rtu" else "Boiler | :1003"
    assert rows[0][4].startswith(start_of_frame), rows[0]
    total = takt("latency", capture, "--json").json["total"]
    assert total["answered"] == len(responses)
    assert total["min_ms"] > 2


def test_the_clients_of_a_server_are_connections_of_their_own(tmp_path):
    port, capture = free_port(), tmp_path / "serve.pcapng"
    with start("serve", "--listen", f"127.0.0.1:{port}", "--capture", capture) as serve:
        wait_listening(port, serve)
        clients = [socket.create_connection(("127.0.0.1", port)) for _ in range(3)]
        for number in range(20):
            for client in clients:
                client.sendall(adu(number, 1, "03 0000 0002"))
            for client in clients:
                assert len(client.recv(100)) == 13
        ports = {client.getsockname()[1] for client in clients}
        for client in clients:
            client.close()
        serve.interrupt()
    rows = fields(capture, "tcp.srcport", "ip.src", "ip.dst")
    assert {int(r[0]) for r in rows if r[0] != "502"} == ports
    assert {tuple(r[1:]) for r in rows} == {("127.0.0.1", "127.0.0.1")}
    report = takt("latency", capture, "--json").json
    assert (report["total"]["requests"], report["total"]["answered"]) == (60, 60)
    assert report["total"]["max_ms"] > 0
    assert report["capture"]["connections"] == 3


class Noisy(PtyPeer):
    """Answers every other request with a damaged checksum."""

    asked = 0

    def _run(self):
        while not self._stop.is_set():
            if not self._readable(0.02):
                continue
            request = os.read(self._master, 300)
            answer = bytes([request[0], 3, 2, 0, 7])
            self.asked += 1
            os.write(self._master, answer + (b"\xEE\xEE" if self.asked % 2 else crc16(answer)))


def test_damaged_bytes_are_in_the_capture(tmp_path):
    capture = tmp_path / "run.pcapng"
    with Noisy() as slave:
        text = line("field", "Pump", 5, transport="serial", more=f"port: {slave.port}; baud: 115200")
        path = project(tmp_path, text.replace("turnaround: 2ms", "response_timeout: 1s"))
        with start("run", path, "--quiet", "--capture", capture) as run:
            until(lambda: slave.asked >= 6, "six requests")
            run.interrupt()
    rows = fields(capture, "_ws.col.Protocol", "frame.comment", "data.data", "exported_pdu.exported_pdu")
    damaged = [r for r in rows if "dropped: checksum" in r[1]]
    assert damaged and all(r[2] == "0503020007eeee" for r in damaged), rows[:8]
    report = takt("latency", capture, "--json", code=None).json
    assert report["capture"]["damaged_frames"] == len(damaged)
    assert report["total"]["answered"] > 0


def test_files_are_rotated_and_bounded(tmp_path):
    capture = tmp_path / "run.pcapng"
    lines = [
        line(f"line-{n}", f"Device{n}", n + 1, more="baud: 115200").replace("50ms", "5ms") for n in range(4)
    ]
    with start("run", project(tmp_path, *lines), "--quiet", "--capture", capture, "--capture-size", "20k",
               "--capture-files", 3) as run:
        oldest = tmp_path / "run.2.pcapng"
        until(oldest.exists, "a third file")
        first = oldest.stat().st_ino
        until(lambda: oldest.exists() and oldest.stat().st_ino != first, "the next rotation")
        run.interrupt()
    files = sorted(tmp_path.glob("*.pcapng"))
    assert [f.name for f in files] == ["run.1.pcapng", "run.2.pcapng", "run.pcapng"]
    assert all(f.stat().st_size <= 20_000 for f in files)
    _, oldest, newest = (fields(file, "frame.time_epoch") for file in files)
    assert float(oldest[-1][0]) <= float(newest[0][0])


def test_a_full_disk_ends_in_an_error_and_polling_goes_on(tmp_path):
    with start("run", project(tmp_path, line("rs485-1", "Boiler", 16)), "--capture", "/dev/full") as run:
        run.wait_line(lambda text: "Boiler: answering" in text, "an answer")
        result = run.interrupt(code=3)
    assert "/dev/full" in result.err, result


@pytest.mark.parametrize("option", ["--capture", "--traffic"])
def test_a_full_disk_is_reported_while_it_is_full(tmp_path, option):
    with start("run", project(tmp_path, line("rs485-1", "Boiler", 16)), "--quiet", option,
               "/dev/full") as run:
        until(lambda: any("no space left" in text and "Frames are lost" in text for text in run.err),
              "the report")
        result = run.interrupt(code=3)
    assert result.err.count("Frames are lost") == 1 and result.err.count("no space left") == 2, result


@pytest.mark.parametrize("option", ["--capture", "--traffic"])
def test_a_file_of_frames_is_of_one_program(tmp_path, option):
    file, path, port = tmp_path / "frames", project(tmp_path, line("rs485-1", "Boiler", 16)), free_port()
    file.write_text("of an ended program")
    with start("serve", "--listen", f"127.0.0.1:{port}", option, file) as first:
        wait_listening(port, first)
        kept = until(lambda: option == "--traffic" or file.read_bytes(), "the beginning of the capture")
        for command in (["serve", "--listen", "127.0.0.1:0"], ["run", path, "--for", "1s"]):
            result = takt(*command, option, file, code=3)
            assert f"{file}: used by another program" in result.err and "Boiler" not in result.out, result
        assert kept is True or file.read_bytes() == kept
        first.interrupt()
    with start("run", path, "--quiet", option, file) as run:
        until(lambda: b"Boiler" in file.read_bytes(), "a frame in the file")
        run.interrupt()


@pytest.mark.parametrize("options, words", [(["--capture", "/none/a.pcapng"], "/none/a.pcapng"),
                                            (["--capture-size", "1M"], "--capture"),
                                            (["--capture", "a", "--capture-size", "5"], "10k"),
                                            (["--capture", "a", "--capture-size", "10x"], "10k"),
                                            (["--capture", "a", "--capture-files", "0"], "1")])
def test_wrong_options(tmp_path, options, words):
    result = takt("run", project(tmp_path, line("rs485-1", "Boiler", 16)), "--for", "100ms", *options,
                  code=None)
    assert result.code in (2, 3) and words in result.err, result


@pytest.mark.parametrize("framing", ["rtu", "ascii"])
def test_a_line_of_others_is_overheard_without_a_byte(tmp_path, framing):
    """Both directions of a line reach a third pseudo-terminal, which nothing may come back from."""
    capture = tmp_path / "line.pcapng"
    requests, answers = (frame(1, f"03 00 0{n} 00 01", framing)
                         for n in range(5)), (frame(1, f"03 02 00 0{n}", framing) for n in range(5))
    with Bus() as bus, start("capture", f"{framing}://{bus.port}?baud=115200", "-o", capture) as listener:
        until(lambda: any("listening on" in text for text in listener.err), "listening")
        written = frame(1, "06 00 05 12 34", framing)
        passed = [*(data for pair in zip(requests, answers) for data in pair), written, written]
        for number, data in enumerate(passed, 1):
            bus.pass_on(data)
            # The next frame follows when this one was recorded: a busy program would receive both without a
            # silence.
            until(lambda n=number: packets_in(capture) == n, f"frame {number} in the file")
        listener.interrupt()
        assert bus.heard() == b""
    rows = fields(capture, "modbus.func_code", "modbus.response_time", "frame.packet_flags_direction")
    assert [r[0] for r in rows] == ["3"] * 10 + ["6"] * 2
    assert [bool(r[1]) for r in rows] == [False, True] * 6
    assert not any(int(r[2] or "0", 0) & 3 for r in rows)
    assert takt("latency", capture, "--json", "--timeout", "1min").json["total"]["answered"] == 6


class Bus(PtyPeer):
    """The test is all other stations of the line."""

    def _run(self):
        self._stop.wait()

    def pass_on(self, data):
        os.write(self._master, data)

    def heard(self):
        return os.read(self._master, 100) if self._readable(0) else b""


def frame(unit, pdu, framing):
    body = bytes([unit]) + bytes.fromhex(pdu)
    if framing == "rtu":
        return body + crc16(body)
    return b":" + (body + bytes([-sum(body) & 0xFF])).hex().upper().encode() + b"\r\n"


def test_an_interface_is_recorded(tmp_path, blank_device):
    capture, port = tmp_path / "lo.pcapng", blank_device()
    with start("capture", "--interface", "lo", "-o", capture) as listener:
        until(
            lambda: any("listening on lo" in text
                        for text in listener.err) or listener.process.poll() is not None, "listening")
        if listener.process.poll() is not None:
            pytest.skip("needs CAP_NET_RAW")
        with socket.create_connection(("127.0.0.1", port)) as client:
            for number in range(20):
                client.sendall(adu(number, 1, "03 0000 0002"))
                assert len(client.recv(100)) == 13
        listener.interrupt()
    mine = tshark(capture, "-Y", f"tcp.port == {port} and tcp.len > 0", "-d",
                  f"tcp.port=={port},mbtcp").splitlines()
    assert len(mine) == 40
    report = takt("latency", capture, "--port", port, "--json", code=None).json
    assert [s["answered"] for s in report["series"] if s["server"] == f"127.0.0.1:{port}"] == [20]


def test_each_file_of_an_interface_has_its_own_statistics(tmp_path):
    capture = tmp_path / "lo.pcapng"
    # Also the first packet, which is larger than a file, follows the begin of one.
    with start("capture", "--interface", "lo", "-o", capture, "--size", "20k", "--files", 1000) as listener, \
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        until(
            lambda: any("listening on lo" in text
                        for text in listener.err) or listener.process.poll() is not None, "listening")
        if listener.process.poll() is not None:
            pytest.skip("needs CAP_NET_RAW")

        sender.sendto(b"\0" * 60_000, ("127.0.0.1", 9))

        def send_until_rotated():
            sender.sendto(b"\0" * 900, ("127.0.0.1", 9))
            return (tmp_path / "lo.2.pcapng").exists()

        until(send_until_rotated, "a third file")
        listener.interrupt()
    for file in tmp_path.glob("*.pcapng"):
        tshark(file)
        packets = sum(kind == 6 for kind, _ in blocks(file))
        (statistics, ) = (body for kind, body in blocks(file) if kind == 5)
        received, dropped = (struct.unpack_from("=Q", statistics, at)[0] for at in (16, 28))
        assert packets > 0 and received - dropped == packets, file


@pytest.fixture
def recording(tmp_path):
    """takt capture --interface lo, listening; its file is lo.pcapng."""
    with start("capture", "--interface", "lo", "-o", tmp_path / "lo.pcapng") as listener:
        wait_listening_on_lo(listener)
        yield listener


def wait_listening_on_lo(listener):
    until(
        lambda: any("listening on lo" in text
                    for text in listener.err) or listener.process.poll() is not None, "listening")
    if any("CAP_NET_RAW" in text for text in listener.err):
        pytest.skip("needs CAP_NET_RAW")


def request_while_stopped(listener, port):
    """One request, and 40 while the program is stopped. Ctrl-C comes before it continues."""
    with socket.create_connection(("127.0.0.1", port)) as client:
        for number in range(41):
            client.sendall(adu(number, 1, "03 0000 0002"))
            assert len(client.recv(100)) == 13
            if number == 0:
                listener.process.send_signal(signal.SIGSTOP)
    listener.process.send_signal(signal.SIGINT)
    listener.process.send_signal(signal.SIGCONT)


def test_packets_that_wait_at_the_end_are_recorded(tmp_path, recording, blank_device):
    port = blank_device()
    request_while_stopped(recording, port)
    result = recording.finish()
    assert "dropped" not in result.err, result
    report = takt("latency", tmp_path / "lo.pcapng", "--port", port, "--json", code=None).json
    assert [s["answered"] for s in report["series"] if s["server"] == f"127.0.0.1:{port}"] == [41]


def test_packets_that_the_kernel_dropped_are_reported(tmp_path, recording):
    """More than the buffer of the kernel holds comes while the program is stopped."""
    recording.process.send_signal(signal.SIGSTOP)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for _ in range(2000):
            sender.sendto(b"\0" * 60_000, ("127.0.0.1", 9))
    recording.process.send_signal(signal.SIGINT)
    recording.process.send_signal(signal.SIGCONT)
    result = recording.finish()
    (statistics, ) = (body for kind, body in blocks(tmp_path / "lo.pcapng") if kind == 5)
    received, dropped = (struct.unpack_from("=Q", statistics, at)[0] for at in (16, 28))
    packets = sum(kind == 6 for kind, _ in blocks(tmp_path / "lo.pcapng"))
    assert dropped > 0 and received - dropped == packets
    assert f"lo: the kernel dropped {dropped:,} packets" in result.err and "lo.pcapng" in result.err, result


def test_a_busy_interface_does_not_prolong_the_end(tmp_path, recording):
    """Datagrams come faster than they are written, before and after Ctrl-C."""
    busy = [subprocess.Popen([sys.executable, "-c", FLOOD]) for _ in range(2)]
    try:
        until(lambda: (tmp_path / "lo.pcapng").stat().st_size > 1_000_000, "the datagrams in the file")
        recording.interrupt()
        assert all(flood.poll() is None for flood in busy)
    finally:
        for flood in busy:
            flood.kill()
            flood.wait()


FLOOD = """import socket
sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
while True:
    sender.sendto(bytes(1000), ("127.0.0.1", 9))
"""


def test_standard_output_is_a_capture(tmp_path):
    with Bus() as bus, subprocess.Popen([TAKT, "capture", f"rtu://{bus.port}?baud=115200", "-o", "-"],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        env=environment()) as listener:
        until(lambda: b"listening" in listener.stderr.read1(), "listening")
        bus.pass_on(frame(1, "03 00 00 00 01", "rtu"))
        data = b""
        while len(data) < 100:  # more than the header of the file
            piece = listener.stdout.read1(65536)
            assert piece, "it ended"
            data += piece
        listener.send_signal(signal.SIGINT)
        (tmp_path / "a.pcapng").write_bytes(data + listener.communicate(timeout=DEADLINE)[0])
    assert [r[0] for r in fields(tmp_path / "a.pcapng", "modbus.func_code")] == ["3"]


@pytest.fixture
def listening(tmp_path):
    """takt latency --interface lo, listening."""
    listener = start("latency", "--interface", "lo", "--json", "--port", "502", "--port", str(free_port()))
    with listener:
        wait_listening_on_lo(listener)
        yield listener


def test_packets_that_wait_at_the_end_are_measured(listening, blank_device):
    port = blank_device()
    request_while_stopped(listening, port)
    report = listening.finish(code=None).json
    mine = [s for s in report["series"] if s["server"] == f"127.0.0.1:{port}"]
    assert [(s["requests"], s["answered"]) for s in mine] == [(41, 41)], report["series"]
    assert report["capture"]["dropped_packets"] == 0


def test_an_interface_is_measured_until_ctrl_c(listening, blank_device):
    port = blank_device()
    with socket.create_connection(("127.0.0.1", port)) as client:
        for number in range(50):
            client.sendall(adu(number, 1, "03 0000 0002"))
            assert len(client.recv(100)) == 13
    result = listening.interrupt(code=None)
    report = result.json
    mine = [s for s in report["series"] if s["server"] == f"127.0.0.1:{port}"]
    assert len(mine) == 1 and (mine[0]["requests"], mine[0]["answered"]) == (50, 50), report["series"]
    assert 0 < mine[0]["min_ms"] <= mine[0]["max_ms"]
    assert report["file"] == "lo" and report["capture"]["dropped_packets"] == 0


def test_an_unknown_interface_is_an_error(tmp_path):
    for command in (["latency"], ["capture", "-o", tmp_path / "a.pcapng"]):
        result = takt(*command, "--interface", "takt-none", code=3)
        assert "takt-none" in result.err and "ip link" in result.err, result


def test_a_port_that_is_lost_is_reported(tmp_path):
    capture, bus = tmp_path / "line.pcapng", Bus()
    with bus:
        listener = start("capture", f"rtu://{bus.port}?baud=115200", "-o", capture)
        until(lambda: any("listening on" in text for text in listener.err), "listening")
        bus.pass_on(frame(1, "03 00 00 00 01", "rtu"))
        until(lambda: b"01 03 00 00" in capture.read_bytes(), "the frame in the file")
    with listener:
        until(lambda: any("the connection is lost" in text for text in listener.err), "the loss")
        result = listener.interrupt(code=3)
    assert f"{capture}: 1 packet" in result.err, result
    assert len(fields(capture, "frame.number")) == 1


def test_a_port_that_cannot_be_opened_leaves_the_file(tmp_path):
    (tmp_path / "line.pcapng").write_bytes(b"before")
    for source in (["rtu:///dev/takt-none"], ["--interface", "takt-none"]):
        takt("capture", *source, "-o", tmp_path / "line.pcapng", code=3)
        assert (tmp_path / "line.pcapng").read_bytes() == b"before"


def test_only_a_serial_line_is_overheard(tmp_path):
    result = takt("capture", "tcp://127.0.0.1", "-o", tmp_path / "a.pcapng", code=2)
    for part in ("tcp://127.0.0.1", "--interface", "rtu:///dev"):
        assert part in result.err, result


def test_without_the_right_it_says_so(open_folder):
    copy = open_folder / "takt"
    shutil.copy(TAKT, copy)
    copy.chmod(0o755)
    nobody = ["setpriv", "--reuid", "65534", "--clear-groups", "--inh-caps=-all"] if os.geteuid() == 0 else []
    done = subprocess.run([*nobody, str(copy), "latency", "--interface", "lo"], capture_output=True,
                          text=True, timeout=DEADLINE, check=False)
    assert done.returncode == 3 and "CAP_NET_RAW" in done.stderr and "1024" not in done.stderr, done
