"""takt latency on captures made byte by byte: figures, forms of the output, errors and exit codes."""
import csv
import io
import os
import signal
import struct
import subprocess
import xml.etree.ElementTree as xml

import pytest

from captures import LINKS, Capture, Connection, adu
from frames import crc16
from frames import pcap as frames_pcap
from frames import request as frame
from program import TAKT, environment, start, takt, until

READ, ANSWER = "03 006B 0001", "03 02 0001"
SOURCE = [205, 146, 148, 152, 149]  # us: docs/specification.md, section 10


def source_capture(times=SOURCE):
    capture = Capture()
    connection = Connection(capture)
    for number, time in enumerate(times):
        at = 1000 + number * 1_000_000
        connection.request(at, adu(number, 1, READ))
        connection.respond(at + time, adu(number, 1, ANSWER))
    return capture


def measured(tmp_path, data, *options, code=0):
    path = tmp_path / "a.pcap"
    path.write_bytes(data)
    return takt("latency", path, "--json", *options, code=code).json


def test_the_figures_of_the_source(tmp_path):
    report = measured(tmp_path, source_capture().pcap(nanoseconds=False), "--limit", "1ms")
    total = report["total"]
    assert (total["answered"], total["min_ms"], total["max_ms"], total["mean_ms"],
            total["p50_ms"]) == (5, 0.146, 0.205, 0.16, 0.149)
    assert [s["time_ms"] for s in report["slowest"]] == [0.205, 0.152, 0.149, 0.148, 0.146]
    assert report["slowest"][0]["request_packet"] == 4
    assert report["verdict"]["kept"] and "fewer than 46 % exceed 1 ms" in report["verdict"]["words"]
    assert total["period_ms"] == 1000


@pytest.mark.parametrize("link", LINKS)
def test_every_link_layer_and_format_gives_the_same(tmp_path, link):
    capture = source_capture()
    wanted = measured(tmp_path, capture.pcap())["total"]
    for data in (capture.pcap(link), capture.pcap(link, order=">"), capture.pcap(link, nanoseconds=False),
                 capture.pcapng(link), capture.pcapng(link, 6, ">"), capture.pcapng(link, sections=3)):
        assert measured(tmp_path, data)["total"] == wanted


def test_standard_input_in_pieces(tmp_path):
    data = source_capture().pcapng()
    with subprocess.Popen([TAKT, "latency", "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                          env=environment()) as process:
        for at in range(0, len(data), 7):
            process.stdin.write(data[at:at + 7])
            process.stdin.flush()
        out = process.communicate(timeout=30)[0].decode()
    assert process.returncode == 0
    for figure in ("0.205", "0.146", "0.160", "0.149", "10.0.0.2:502"):
        assert figure in out, out


def test_a_fifo_is_read_to_its_end(tmp_path):
    os.mkfifo(tmp_path / "fifo")
    with start("latency", tmp_path / "fifo") as process:
        (tmp_path / "fifo").write_bytes(source_capture().pcap())
        assert "0.205" in process.finish().out
    assert "FIFO" in takt("latency", "/dev/null", code=2).err


def test_a_signal_ends_standard_input_with_the_report():
    with start("latency", "-") as process:
        data = source_capture().pcap()
        process.process.stdin.write(data)
        process.process.stdin.flush()
        until(lambda: process.catches(signal.SIGINT), "the handler")
        result = process.interrupt(code=7)
    assert "0.205" in result.out or "packets 0" in result.out  # the signal may come before the bytes


def test_a_signal_ends_a_large_file(tmp_path):
    """A file is always readable. This one is 400 GB of blocks that are skipped, nearly all of them a hole."""
    size = 0xFFFFFFFC
    with open(tmp_path / "large.pcapng", "wb") as file:
        file.write(source_capture().pcapng())
        begin = file.tell()
        for number in range(100):
            file.seek(begin + number * size)
            file.write(struct.pack("<II", 0x0BAD, size))
        file.truncate(begin + 100 * size)
    with start("latency", tmp_path / "large.pcapng", "--json") as process:
        until(lambda: process.catches(signal.SIGINT), "the handler")
        assert process.interrupt(code=7).json["total"]


def test_segments_cut_repeated_swapped_and_missing(tmp_path):
    capture = Capture()
    c = Connection(capture)
    whole = adu(1, 1, READ)
    c.request(100, whole[:3])
    c.request(110, whole[3:])  # the request counts from here
    answer = adu(1, 1, ANSWER)
    c.respond(200, answer[:1])
    c.respond(310, answer[1:])  # 200 us
    two = adu(2, 1, READ)
    c.request(1000, two)
    c.again(1200, False, two)  # sent again within the exchange
    c.respond(1400, adu(2, 1, ANSWER))  # 400 us
    c.again(1500, True, adu(2, 1, ANSWER))
    c.request(2000, adu(3, 1, READ) + adu(4, 2, READ) + adu(5, 1, "06 0001 0002"))
    c.respond(2050, adu(5, 1, "06 0001 0002"))  # 50 us
    c.respond(2100, adu(4, 2, "83 02") + adu(3, 1, ANSWER))  # twice 100 us
    c.request(3000, adu(6, 1, READ))
    c.respond(3100, adu(6, 1, ANSWER), captured=False)
    c.request(4000, adu(7, 1, READ))  # acknowledges what is missing
    c.respond(4300, adu(7, 1, ANSWER))  # 300 us
    c.request(5000, adu(8, 1, READ), captured=False)
    c.respond(5100, adu(8, 1, ANSWER))  # without its request
    c.close(2_000_000)
    report = measured(tmp_path, capture.pcap())
    total = report["total"]
    assert sorted(s["time_ms"] for s in report["slowest"]) == [0.05, 0.1, 0.1, 0.2, 0.3, 0.4]
    assert (total["requests"], total["answered"], total["unanswered"], total["retransmissions"]) == (7, 6, 1,
                                                                                                     1)
    assert total["exceptions"] == {"2": 1}
    assert report["capture"]["unmatched_responses"] == 1
    assert report["capture"]["gaps"] == 2 and report["capture"]["missing_bytes"] == 11 + 12


def test_segments_out_of_order(tmp_path):
    capture = Capture()
    c = Connection(capture)
    first, second = adu(1, 1, READ), adu(2, 1, READ)
    c.next[0] += len(first)
    c.request(100, second)
    c.again(150, False, first, before=len(second))
    c.respond(250, adu(1, 1, ANSWER))
    c.respond(350, adu(2, 1, ANSWER))
    report = measured(tmp_path, capture.pcap())
    assert sorted(s["time_ms"] for s in report["slowest"]) == [0.1, 0.2]
    assert report["capture"]["out_of_order"] == 1 and report["capture"]["retransmissions"] == 0


def test_late_open_and_unanswered(tmp_path):
    capture = Capture()
    a, b = Connection(capture), Connection(capture, client=("10.0.0.9", 40000))
    a.request(0, adu(1, 1, READ))
    a.respond(1_500_000, adu(1, 1, ANSWER))
    a.request(2_000_000, adu(2, 1, READ))
    b.request(4_999_000, adu(1, 1, READ))
    b.request(5_000_000, adu(2, 1, READ))
    total = measured(tmp_path, capture.pcap(), "--limit", "2s", code=1)["total"]
    assert (total["late"], total["unanswered"], total["open"], total["exceeded"]) == (1, 1, 2, 1)
    assert measured(tmp_path, capture.pcap(), "--timeout", "2s")["total"]["late"] == 0


def test_series_and_their_grouping(tmp_path):
    capture = Capture()
    a, b = Connection(capture), Connection(capture, client=("10.0.0.9", 40000))
    for number, connection in enumerate((a, b, a, b)):
        connection.request(number * 1000, adu(9, 1 + number // 2, READ))
        connection.respond(number * 1000 + 100, adu(9, 1 + number // 2, ANSWER))
    data = capture.pcap()
    series = measured(tmp_path, data)["series"]
    assert [(s["client"], s["unit"]) for s in series] == [("10.0.0.1", 1), ("10.0.0.9", 1), ("10.0.0.1", 2),
                                                          ("10.0.0.9", 2)]
    assert [s["answered"] for s in measured(tmp_path, data, "--by", "client")["series"]] == [2, 2]
    assert [s["answered"] for s in measured(tmp_path, data, "--by", "none")["series"]] == [4]


def test_serial_frames(tmp_path):
    frames = [
        frame("rtu", 1, "03 0000 0001"),
        frame("rtu", 1, "03 02 1234"),
        frame("ascii", 2, "03 0000 0001"),
        frame("ascii", 2, "83 02")
    ]
    report = measured(tmp_path, frames_pcap(147, frames))
    assert [s["time_ms"] for s in report["slowest"]] == [1.0, 1.0]
    assert report["total"]["exceptions"] == {"2": 1}
    assert report["series"][0]["server"] == "serial 0"
    rtac = [struct.pack(">IIBBH", 0, 0, 1 + n % 2, 0, 0) + f for n, f in enumerate(frames[:2])]
    assert measured(tmp_path, frames_pcap(250, rtac))["total"]["answered"] == 1


def test_forms_of_the_output(tmp_path):
    path, svg = tmp_path / "a.pcap", tmp_path / "a.svg"
    path.write_bytes(source_capture().pcap())
    rows = list(csv.DictReader(io.StringIO(takt("latency", path, "--csv", "--svg", svg).out)))
    assert [row["client"] for row in rows] == ["10.0.0.1", "total"]
    assert rows[1]["mean_ms"] == "0.16" and rows[1]["answered"] == "5" and rows[1]["exceeded"] == ""
    picture = xml.parse(svg).getroot()
    bars = [
        int(r.get("data-count")) for r in picture.iter("{http://www.w3.org/2000/svg}rect")
        if r.get("data-count")
    ]
    assert sum(bars) == 5
    assert xml.fromstring(takt("latency", path, "--svg", "-").out.encode()).tag.endswith("svg")
    assert "--svg -" in takt("latency", path, "--json", "--svg", "-", code=2).err
    lines = takt("latency", path, "--histogram", 200).out.splitlines()
    assert lines[0] == "# Histogram" and lines[1 + 146] == "000146 000001" and lines[1 +
                                                                                     147] == "000147 000000"
    assert lines[201:] == [
        "# Total: 000000004", "# Min Latencies: 00146", "# Avg Latencies: 00160", "# Max Latencies: 00205",
        "# Histogram Overflows: 00001"
    ]


@pytest.mark.parametrize("language, word", [("en", "kept"), ("ru", "выдержан"), ("uk", "витримано")])
def test_languages(tmp_path, language, word):
    path = tmp_path / "a.pcap"
    path.write_bytes(source_capture().pcap())
    out = takt("latency", path, "--limit", "1ms", "--lang", language).out
    assert word in out and "app." not in out


def test_the_limit_decides_the_exit_code(tmp_path):
    data = source_capture().pcap()
    assert measured(tmp_path, data, "--limit", "0.205ms")["verdict"]["kept"]
    verdict = measured(tmp_path, data, "--limit", "0.2ms", code=1)["verdict"]
    assert not verdict["kept"] and verdict["exceeded"] == 1


def test_a_damaged_capture_is_reported_up_to_its_fault(tmp_path):
    path = tmp_path / "a.pcap"
    path.write_bytes(source_capture().pcap()[:-1])
    result = takt("latency", path, "--json", code=7)
    assert result.json["total"]["answered"] == 4
    assert "after packet 12" in result.err and "byte " in result.err


# hostile-inputs 60
@pytest.mark.parametrize("form", ["pcap", "pcapng"])
@pytest.mark.parametrize("length", [0xFFFFFFFF, 0xFFFFFFFC, 0x80000000, 0])
def test_a_record_length_that_cannot_be(tmp_path, form, length):
    data = bytearray(getattr(source_capture(), form)())
    last = len(data) - len(getattr(source_capture(SOURCE[:4]), form)())
    struct.pack_into("<I", data, len(data) - last + (8 if form == "pcap" else 4), length)
    path = tmp_path / "a.cap"
    path.write_bytes(data)
    result = takt("latency", path, "--json", code=None)
    assert result.json["total"]["answered"] >= 4
    if length > 0:
        assert result.code == 7 and "after packet 11" in result.err


@pytest.mark.parametrize("data, words", [(b"hello world", ("68656C6C", "pcapng")), (b"", ("empty", "pcapng")),
                                         (b"\x1f\x8b\x08\0", ("gunzip", )),
                                         (Capture().pcap()[:4] + b"\x09\0" + Capture().pcap()[6:],
                                          ("version 9", "allowed: 2"))])
def test_what_is_no_capture(tmp_path, data, words):
    path = tmp_path / "a.pcap"
    path.write_bytes(data)
    result = takt("latency", path, code=2)
    assert all(word in result.err for word in (*words, "a.pcap")), result.err
    assert not result.out


def test_files_that_cannot_be_read(tmp_path):
    assert "none.pcap" in takt("latency", tmp_path / "none.pcap", code=3).err
    takt("latency", tmp_path, code=3)
    path = tmp_path / "a.pcap"
    path.write_bytes(source_capture().pcap())
    assert "none" in takt("latency", path, "--svg", tmp_path / "none" / "a.svg", code=3).err


def test_a_capture_without_modbus(tmp_path):
    path = tmp_path / "a.pcap"
    path.write_bytes(Capture().pcap())
    result = takt("latency", path, code=1)
    assert "--port" in result.err and "1970" not in result.out


def test_a_server_on_another_port(tmp_path):
    capture = Capture()
    c = Connection(capture, server=("10.0.0.2", 15020))
    c.request(0, adu(1, 1, READ))
    c.respond(70, adu(1, 1, ANSWER))
    for options in ((), ("--port", 15020), ("--port", 502, "--port", 15020)):
        assert measured(tmp_path, capture.pcap(), *options)["slowest"][0]["time_ms"] == 0.07


def rtu(pdu, unit=1):
    body = bytes([unit]) + bytes.fromhex(pdu)
    return body + crc16(body)


def ascii_frame(pdu, unit=1):
    body = bytes([unit]) + bytes.fromhex(pdu)
    return b":" + (body + bytes([-sum(body) & 0xFF])).hex().upper().encode() + b"\r\n"


@pytest.mark.parametrize("framing, frame_of", [("rtu", rtu), ("ascii", ascii_frame)])
def test_serial_frames_in_tcp(tmp_path, framing, frame_of):
    capture = Capture()
    connection = Connection(capture, server=("10.0.0.2", 4001))
    for number in range(10):
        at = 1000 + number * 100_000
        request, answer = frame_of("03 0000 0002"), frame_of("03 04 0001 0002")
        connection.request(at, request[:5])
        connection.request(at + 10, request[5:])
        connection.respond(at + 1010 + number, answer)
    connection.request(2_000_000, frame_of("03 0000 0002"))  # without a response
    connection.request(2_500_000, frame_of("83 02")[:3])  # no whole frame
    report = measured(tmp_path, capture.pcap(), "--framing", framing, "--port", 4001, "--timeout", "100ms")
    total = report["total"]
    assert (total["requests"], total["answered"], total["unanswered"]) == (11, 10, 1)
    assert (total["min_ms"], total["max_ms"]) == (1.0, 1.009)
    assert report["series"][0]["server"] == "10.0.0.2:4001"
    assert report["capture"]["skipped_bytes"] == 3


@pytest.mark.parametrize("frame_of", [rtu, ascii_frame])
@pytest.mark.parametrize("port", [502, 4001])
def test_the_framing_of_a_connection_is_found(tmp_path, frame_of, port):
    capture = Capture()
    connection = Connection(capture, server=("10.0.0.2", port))
    for number in range(10):
        request = frame_of("03 0000 0002")
        connection.request(number * 1000 - 10, request[:5])
        connection.request(number * 1000, request[5:])
        connection.respond(number * 1000 + 70, frame_of("03 04 0001 0002"))
    report = measured(tmp_path, capture.pcap())
    assert (report["total"]["answered"], report["total"]["max_ms"]) == (10, 0.07)
    assert report["capture"]["serial_framing_connections"] == 1


def test_fragments_are_put_together(tmp_path):
    wanted = measured(tmp_path, source_capture().pcap())["total"]
    capture = source_capture()
    capture.packets = [part for packet in capture.packets for part in fragments_of(*packet)]
    report = measured(tmp_path, capture.pcap())
    assert (report["total"], report["capture"]["lost_fragments"]) == (wanted, 0)
    assert report["capture"]["fragments"] == len(capture.packets)
    del capture.packets[-1]
    report = measured(tmp_path, capture.pcap())
    assert report["total"]["answered"] == 4 and report["capture"]["lost_fragments"] > 0


def fragments_of(time_ns, packet):
    """An IPv4 packet as fragments of 16 bytes, the last one first."""
    payload = packet[20:]
    parts = []
    for at in range(0, len(payload), 16):
        piece = payload[at:at + 16]
        place = (0x2000 if at + 16 < len(payload) else 0) | at // 8
        parts.append((time_ns, packet[:2] + struct.pack(">H", 20 + len(piece)) + packet[4:6] +
                      struct.pack(">H", place) + packet[8:20] + piece))
    return parts[::-1]


def test_a_time_of_exactly_zero_is_a_number(tmp_path):
    total = measured(tmp_path, source_capture([0, 0, 0]).pcap())["total"]
    assert [total[key] for key in ("min_ms", "mean_ms", "p50_ms", "p99.99_ms", "max_ms")] == [0, 0, 0, 0, 0]
