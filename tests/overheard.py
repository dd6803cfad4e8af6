"""Records the traffic between Takt and its peers, which Wireshark's dissectors check: nothing malformed, no
warning, valid CRCs.

`overheard()` records one endpoint. conftest.py checks all records once, after the tests of a file."""
import contextlib
import itertools
import socket
import subprocess
import threading

from frames import TcpCapture, crc16, pcap
from peer_base import TcpPeer
from program import DEADLINE

# The servers' ports in captures. Frames of serial lines are written as RTU over TCP, to have a direction.
MBAP, RTU = 502, 5020
OPTIONS = ["-o", f"mbtcp.tcp.port:{MBAP}", "-o", f"mbrtu.tcp.port:{RTU}", "-o", "mbrtu.crc_verification:TRUE"]

_clients = itertools.count(10000)
_kept = []

FIELDS = ("tcp.len", "frame.protocols", "mbtcp.unit_id", "mbrtu.unit_id", "modbus.func_code", "modbus.data",
          "_ws.malformed", "_ws.expert")


def packets(capture, *options):
    """The FIELDS of each packet: a list for each field, as a packet may hold several frames, each with a PDU.
    One run of tshark, which takes a second to start."""
    wanted = (part for field in FIELDS for part in ("-e", field))
    command = ["tshark", "-n", "-r", str(capture), *OPTIONS, *options, "-T", "fields"]
    done = subprocess.run([*command, "-E", "aggregator=\x1f", *wanted], capture_output=True, timeout=DEADLINE,
                          text=True, check=False)
    assert done.returncode == 0, done.stderr
    for line in done.stdout.splitlines():
        values = line.split("\t")
        yield dict(zip(FIELDS, ([v for v in value.split("\x1f") if v] for value in values), strict=True))


def judge(capture, units, *options):
    """Fails unless tshark finds exactly `units` frames and complains of none."""
    frames = pdus = 0
    for number, packet in enumerate(packets(capture, *options), 1):
        known = {"modbus", "mbtcp", "mbrtu"} & set(packet["frame.protocols"][0].split(":"))
        assert "modbus" in known or packet["tcp.len"] in ([], ["0"]), f"not Modbus: {number}, {packet}"
        frames += len(packet["mbtcp.unit_id"]) + len(packet["mbrtu.unit_id"])
        pdus += len(packet["modbus.func_code"])
        assert not (known and (packet["_ws.malformed"] or packet["_ws.expert"])), f"packet {number}: {packet}"
        # A byte count that does not fit is no warning to it: it then shows the registers as undivided data.
        reads = {int(code) & 0x7F for code in packet["modbus.func_code"]} & {3, 4}
        assert not (reads and packet["modbus.data"]), f"packet {number}: {packet}"
    assert frames == units, "each frame is one to tshark"
    assert pdus == units, "each has a PDU it understands"


def adus(data):
    """How many frames of Modbus TCP a stream holds; fails when it ends within one."""
    count = 0
    while data:
        size = 6 + int.from_bytes(data[4:6], "big")
        assert len(data) >= size, f"a frame of Modbus TCP is cut: {data.hex(' ')}"
        data, count = data[size:], count + 1
    return count


class Connection:
    """The capture of one connection, and the bytes in each direction."""

    def __init__(self, server_port):
        self.capture, self.streams, self.chunks = TcpCapture(next(_clients), server_port), {
            False: b"",
            True: b""
        }, 0

    def chunk(self, from_server, data):
        self.capture.chunk(from_server, data)
        self.streams[from_server] += data
        self.chunks += 1


class Tap(TcpPeer):
    """A TCP relay that keeps every chunk that passes."""

    def __init__(self, server_port):
        self._server_port = server_port
        self._lock = threading.Lock()
        self.connections = []
        super().__init__()

    def _connected(self, client):
        server = socket.create_connection(("127.0.0.1", self._server_port))
        for end in (client, server):
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.connections.append(Connection(MBAP))
        for ends in ((client, server, False), (server, client, True)):
            self._begin(self._pump, self.connections[-1], *ends)

    def _pump(self, connection, source, target, from_server):
        source.settimeout(0.05)
        while not self._stop.is_set():
            try:
                data = source.recv(4096)
            except TimeoutError:
                continue
            except OSError:
                break
            if not data:
                break
            with self._lock:
                connection.chunk(from_server, data)
            try:
                target.sendall(data)
            except OSError:
                break
        try:
            target.shutdown(socket.SHUT_WR)
        except OSError:
            pass

    def chunks(self):
        return sum(c.chunks for c in self.connections)

    def frames(self):
        return sum(adus(stream) for c in self.connections for stream in c.streams.values())

    def write(self, path):
        path.write_bytes(pcap(TcpCapture.LINK_TYPE, [p for c in self.connections for p in c.capture.packets]))
        return path


def rtu_frames(data):
    """Cuts what passed in one direction where the CRCs fit, the longest frames first (before a last byte of
    zero they fit too)."""
    if not data:
        return []
    for size in range(min(len(data), 256), 3, -1):
        if crc16(data[:size - 2]) == data[size - 2:size] and (rest := rtu_frames(data[size:])) is not None:
            return [data[:size], *rest]
    return None


def rtu_connection(passed):
    """The traffic of a serial line, as (from the slave, bytes) in turn: a capture, and its number of
    frames."""
    connection, count = Connection(RTU), 0
    for from_slave, chunks in itertools.groupby(passed, key=lambda chunk: chunk[0]):
        data = b"".join(chunk for _, chunk in chunks)
        frames = rtu_frames(data)
        assert frames is not None, f"these are no frames: {data.hex(' ')}"
        for frame in frames:
            # As RTU over TCP it takes neither shorter ones (requests of 7, 11, 12 and 17) nor broadcasts.
            if len(frame) > 4 and frame[0] != 0:
                connection.chunk(from_slave, frame)
                count += 1
    return connection, count


@contextlib.contextmanager
def overheard(framing, endpoint, pair=None):
    """Records the requests to the slave at `endpoint` and its answers. Yields the endpoint for masters. The
    record is kept for tshark unless the test fails. It has no dissector for ASCII."""
    if framing == "tcp":
        with Tap(endpoint) as tap:
            yield tap.port
        _kept.extend((c, adus(c.streams[False]) + adus(c.streams[True])) for c in tap.connections)
    else:
        before = len(pair.passed())
        yield endpoint
        if framing == "rtu":
            _kept.append(rtu_connection(pair.passed()[before:]))


def judge_what_was_kept(folder):
    """Writes what was kept to a capture in `folder` and judges it; true when there was anything."""
    if not _kept:
        return False
    capture = folder / "overheard.pcap"
    capture.write_bytes(
        pcap(TcpCapture.LINK_TYPE, [p for connection, _ in _kept for p in connection.capture.packets]))
    judge(capture, sum(count for _, count in _kept))
    return True
