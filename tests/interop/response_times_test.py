"""takt latency against Wireshark: on clean captures the same response times, to the microsecond and
beyond."""
import random
import statistics
import subprocess

import pytest

from captures import LINKS, Capture, Connection, adu
from program import DEADLINE, takt

# Wireshark gives exceptions no response time.
EXCHANGES = [("03 0000 000A", "03 14" + " 00" * 20), ("04 0010 0001", "04 02 0007"),
             ("01 0000 0008", "01 01 55"), ("06 0005 1234", "06 0005 1234"),
             ("10 0000 0001 02 0001", "10 0000 0001")]


def tshark_times(path):
    """(packet of the request, packet of the response, time in ns) of each exchange."""
    done = subprocess.run([
        "tshark", "-n", "-r",
        str(path), "-o", "tcp.reassemble_out_of_order:TRUE", "-Y", "modbus.response_time", "-T", "fields",
        "-e", "frame.number", "-e", "modbus.request_frame", "-e", "modbus.response_time"
    ], capture_output=True, text=True, timeout=DEADLINE, check=True)
    found = []
    for line in done.stdout.splitlines():
        number, requests, times = line.split("\t")
        for request, time in zip(requests.split(","), times.split(",")):
            found.append((int(request), int(number), round(float(time) * 1e9)))
    return found


def clean_capture(seed, exchanges, connections, in_flight=1, cuts=False):
    """Requests of several clients; the responses come in any order."""
    rng = random.Random(seed)
    capture = Capture()
    ends = [
        Connection(capture, client=(f"10.0.{1 + n // 200}.{1 + n % 200}", 40000 + n), at=n)
        for n in range(connections)
    ]
    at = 1000.0
    for number in range(0, exchanges, in_flight):
        connection = ends[rng.randrange(connections)]
        flight = [(number + i, rng.randrange(1, 4), *rng.choice(EXCHANGES))
                  for i in range(min(in_flight, exchanges - number))]
        for transaction, unit, request, _ in flight:
            at += rng.uniform(1, 50)
            send(connection.request, rng, at, adu(transaction, unit, request), cuts)
        rng.shuffle(flight)
        for transaction, unit, _, response in flight:
            at += rng.choice([rng.uniform(30, 300), rng.uniform(300, 20000)])
            send(connection.respond, rng, at, adu(transaction, unit, response), cuts)
        at += rng.uniform(500, 5000)
    return capture


def send(by, rng, at, data, cuts):
    """In one segment, or in two that are 0.5 us apart; Wireshark needs eight bytes to recognise a message."""
    cut = rng.randrange(8, len(data)) if cuts else 0
    if cut:
        by(at - 0.5, data[:cut])
    by(at, data[cut:])


CASES = {
    "one connection": (1, 9, 1),
    "several connections": (2, 10, 4),
    "in flight": (3, 8, 1, 8),
    "in flight on several": (4, 10, 3, 5),
    "cut segments": (5, 10, 2, 2, True)
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("form", ["pcap", "microseconds", "pcapng"])
def test_every_exchange_agrees(tmp_path, case, form):
    capture, path = clean_capture(*CASES[case]), tmp_path / "a.pcap"
    path.write_bytes(capture.pcapng() if form == "pcapng" else capture.pcap(nanoseconds=form == "pcap"))
    theirs = tshark_times(path)
    assert len(theirs) == CASES[case][1]
    ours = [(s["request_packet"], s["response_packet"], round(s["time_ms"] * 1e6))
            for s in takt("latency", path, "--json").json["slowest"]]
    assert sorted(ours) == sorted(theirs)


@pytest.mark.parametrize("link", LINKS)
def test_statistics_of_many_agree(tmp_path, link):
    path = tmp_path / "a.pcap"
    path.write_bytes(clean_capture(6, 900, 20, 3).pcap(link))
    theirs = sorted(time for _, _, time in tshark_times(path))
    total = takt("latency", path, "--json").json["total"]
    assert total["answered"] == len(theirs) == 900
    assert round(total["min_ms"] * 1e6) == theirs[0] and round(total["max_ms"] * 1e6) == theirs[-1]
    assert abs(total["mean_ms"] * 1e6 - statistics.fmean(theirs)) <= 1
    for name, percent in (("p50", 50), ("p90", 90), ("p99", 99), ("p99.9", 99.9)):
        rank = -(-percent * len(theirs) // 100)
        assert round(total[name + "_ms"] * 1e6) == theirs[int(rank) - 1], name


def test_where_wireshark_pairs_wrongly(tmp_path):
    """Equal transaction ids in flight: Wireshark pairs both responses with the newest request."""
    capture, path = Capture(), tmp_path / "a.pcap"
    connection = Connection(capture)
    connection.request(0, adu(0, 1, "03 0000 0001"))
    connection.request(100, adu(0, 1, "03 0000 0001"))
    connection.respond(250, adu(0, 1, "03 02 0001"))
    connection.respond(400, adu(0, 1, "03 02 0001"))
    path.write_bytes(capture.pcap())
    slowest = takt("latency", path, "--json").json["slowest"]
    assert sorted((s["request_packet"], s["time_ms"]) for s in slowest) == [(4, 0.25), (5, 0.3)]
    assert sorted(time for _, _, time in tshark_times(path)) == [150_000, 300_000]


def test_cuts_that_wireshark_does_not_recognise(tmp_path):
    """A message whose first segment has less than eight bytes."""
    capture, path = Capture(), tmp_path / "a.pcap"
    connection = Connection(capture)
    for cut in range(1, 8):
        request, response = adu(cut, 1, "03 0000 0001"), adu(cut, 1, "03 02 0001")
        at = cut * 1000
        connection.request(at, request[:cut])
        connection.request(at + 10, request[cut:])
        connection.respond(at + 100, response[:cut])
        connection.respond(at + 10 + 100 + cut, response[cut:])
    path.write_bytes(capture.pcap())
    assert len(tshark_times(path)) < 7
    times = [s["time_ms"] for s in takt("latency", path, "--json").json["slowest"]]
    assert sorted(times) == [0.101, 0.102, 0.103, 0.104, 0.105, 0.106, 0.107]
