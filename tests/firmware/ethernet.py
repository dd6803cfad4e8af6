"""A board whose Ethernet frames are UDP datagrams on loopback, and a TCP peer made by hand (RFC 9293)."""
import contextlib
import random
import socket
import struct
import subprocess
import time

from board import command
from program import DEADLINE, until

OURS, BOARD = bytes([10, 0, 2, 2]), bytes([10, 0, 2, 15])
OUR_MAC = bytes.fromhex("020000000001")
FIN, SYN, RST, PUSH, ACK = 1, 2, 4, 8, 16
MODULO = 1 << 32
RESEND = 0.25  # s
LATE = 0.02  # s
SEGMENT = 536
IP, ARP = b"\x08\x00", b"\x08\x06"


def free_port(kind=socket.SOCK_STREAM):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.contextmanager
def running(board, name, folder, *options):
    """@returns the file that has the output of the UART"""
    uart = folder / "uart"
    with subprocess.Popen(command(board, name, "-serial", f"file:{uart}", *options),
                          stdin=subprocess.DEVNULL) as process:
        try:
            until(lambda: uart.exists() and b"listening" in uart.read_bytes(), "the slave listens")
            yield uart
        finally:
            process.kill()


def checksum(data):
    data += bytes(len(data) % 2)
    total = sum(struct.unpack(f">{len(data) // 2}H", data))
    while total >> 16:
        total = (total >> 16) + (total & 0xFFFF)
    return ~total & 0xFFFF


def adu(pdu, transaction=1, unit=1):
    pdu = bytes.fromhex(pdu) if isinstance(pdu, str) else pdu
    return struct.pack(">HHHB", transaction, 0, 1 + len(pdu), unit) + pdu


class Wire:
    """The cable. `faults`: shares of frames that are lost, doubled or delayed, behind the next one or for
    LATE."""

    def __init__(self, seed=1):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.board = ("127.0.0.1", free_port(socket.SOCK_DGRAM))
        self.random = random.Random(seed)
        self.faults = (0, 0, 0)
        self.delayed = {}
        self.peers = {}
        self.mac = b"\xff" * 6
        self.raw = []  # frames from the board that no peer took

    def options(self):
        here, there = self.socket.getsockname()[1], self.board[1]
        return ["-netdev", f"dgram,id=n0,local.type=inet,local.host=127.0.0.1,local.port={there},"
                f"remote.type=inet,remote.host=127.0.0.1,remote.port={here}", "-net", "nic,netdev=n0"]

    def disturbed(self, frame, direction):
        """@returns the frames that arrive now"""
        lost, doubled, late = self.faults
        kind = self.random.random() if any(self.faults) else 1
        if kind < lost:
            return []
        waiting, _ = self.delayed.pop(direction, (None, 0))
        if kind < lost + doubled:
            now = [frame, frame]
        elif kind < lost + doubled + late and not waiting:
            self.delayed[direction] = frame, time.monotonic()
            now = []
        else:
            now = [frame]
        return now + ([waiting] if waiting else [])

    def send(self, kind, data):
        for frame in self.disturbed(self.mac + OUR_MAC + kind + data, "to"):
            self.socket.sendto(frame, self.board)

    def send_ip(self, protocol, data):
        head = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(data), 1, 0, 64, protocol, 0, OURS, BOARD)
        self.send(IP, head[:10] + struct.pack(">H", checksum(head)) + head[12:] + data)

    def ask_for_mac(self):
        def asked():
            self.send(ARP, struct.pack(">HHBBH6s4s6s4s", 1, 0x800, 6, 4, 1, OUR_MAC, OURS, bytes(6), BOARD))
            self.pump(0.05)
            return self.mac != b"\xff" * 6
        until(asked, "the board answers ARP")

    def pump(self, seconds=0.005):
        """Handles what the board sends, for that long."""
        end = time.monotonic() + seconds
        while True:
            self.socket.settimeout(max(end - time.monotonic(), 0.0001))
            try:
                frame = self.socket.recv(2000)
            except (TimeoutError, ConnectionRefusedError, BlockingIOError):
                frame = b""
            for each in self.disturbed(frame, "from") if frame else []:
                self.handle(each)
            self.deliver_late()
            for peer in list(self.peers.values()):
                peer.on_time()
            if time.monotonic() >= end:
                return

    def until(self, condition, what, deadline=DEADLINE):
        end = time.monotonic() + deadline
        while not (found := condition()):
            assert time.monotonic() < end, f"within {deadline:g} s not seen: {what}"
            self.pump(0.001)
        return found

    def deliver_late(self):
        for direction, (frame, since) in list(self.delayed.items()):
            if time.monotonic() < since + LATE:
                continue
            del self.delayed[direction]
            if direction == "to":
                self.socket.sendto(frame, self.board)
            else:
                self.handle(frame)

    def handle(self, frame):
        kind, data = frame[12:14], frame[14:]
        if kind == ARP and data[6:8] == b"\0\1":
            self.send(ARP, struct.pack(">HHBBH6s4s6s4s", 1, 0x800, 6, 4, 2, OUR_MAC, OURS, data[8:14], BOARD))
        elif kind == ARP:
            self.mac = data[8:14]
        elif kind == IP and data[9] == 6:
            assert checksum(data[:20]) == 0
            segment = data[20:struct.unpack(">H", data[2:4])[0]]
            assert checksum(BOARD + OURS + struct.pack(">BBH", 0, 6, len(segment)) + segment) == 0
            _, port, seq, ack, offset, flags, window = struct.unpack(">HHIIBBH", segment[:16])
            if port in self.peers:
                self.peers[port].on_segment(seq, ack, flags, window, segment[(offset >> 4) * 4:])
            else:
                self.raw.append(segment)
        else:
            self.raw.append(frame)

    def segment(self, port, seq, ack, flags, data=b"", window=8192):
        head = struct.pack(">HHIIBBHHH", port, 502, seq % MODULO, ack % MODULO, 0x50, flags, window, 0, 0)
        pseudo = OURS + BOARD + struct.pack(">BBH", 0, 6, len(head) + len(data))
        total = checksum(pseudo + head + data)
        self.send_ip(6, head[:16] + struct.pack(">H", total) + head[18:] + data)


def distance(a, b):
    """@returns a - b of sequence numbers"""
    return (a - b + MODULO // 2) % MODULO - MODULO // 2


class Peer:
    """A connection. Keeps the order of what it receives, and sends again what is not acknowledged."""
    ports = 20_000

    def __init__(self, wire, first=MODULO - 100):
        Peer.ports += 1
        self.wire, self.port = wire, Peer.ports
        self.unacknowledged, self.next = first, first + 1
        self.expected = None  # sequence number
        self.out = b""  # from `unacknowledged` on
        self.board_window, self.window = 0, 8192
        self.received = b""
        self.reset = self.ended = self.mute = False
        self.closing = False
        self.ignored = []  # flags of the segments while it is mute
        self.sent_at = time.monotonic()
        wire.peers[self.port] = self
        wire.segment(self.port, first, 0, SYN)

    def open(self):
        self.wire.until(lambda: self.expected is not None or self.reset, "the board accepts")
        return self

    def acknowledge(self):
        self.wire.segment(self.port, self.next, self.expected, ACK, window=self.window)

    def on_segment(self, seq, ack, flags, window, data):
        if self.mute:
            self.ignored.append(flags)
            return
        if flags & RST:
            self.reset = True
            return
        if flags & SYN:
            if self.expected is None:
                self.expected, self.unacknowledged = (seq + 1) % MODULO, (self.unacknowledged + 1) % MODULO
            self.board_window = window
            return self.acknowledge()
        taken = distance(ack, self.unacknowledged)
        if 0 <= taken <= len(self.out) + 1:
            self.out, self.unacknowledged = self.out[taken:], ack
            self.board_window = window
        if data or flags & FIN or distance(seq, self.expected) < 0:
            if seq == self.expected and len(data) <= self.window:
                self.received += data
                self.expected = (self.expected + len(data) + (flags & FIN)) % MODULO
                self.ended = self.ended or bool(flags & FIN)
            self.acknowledge()
        self.flush()

    def flush(self):
        while self.expected is not None:
            flying = distance(self.next, self.unacknowledged)
            part = self.out[flying:flying + min(SEGMENT, self.board_window - flying)]
            if self.board_window <= flying or not part:
                break
            self.wire.segment(self.port, self.next, self.expected, ACK | PUSH, part, self.window)
            self.next = (self.next + len(part)) % MODULO
            self.sent_at = time.monotonic()

    def on_time(self):
        if self.mute or self.reset or time.monotonic() < self.sent_at + RESEND:
            return
        self.sent_at = time.monotonic()
        if self.expected is None:
            self.wire.segment(self.port, self.unacknowledged, 0, SYN)
        elif self.out:
            self.next = self.unacknowledged
            self.flush()
        elif self.closing and not self.ended:
            self.wire.segment(self.port, self.next - 1, self.expected, FIN | ACK, window=self.window)

    def send(self, data):
        self.out += data
        self.flush()

    def take(self, size, what="response"):
        self.wire.until(lambda: len(self.received) >= size or self.reset or self.ended, what)
        taken, self.received = self.received[:size], self.received[size:]
        return taken

    def ask(self, pdu, transaction=1):
        """@returns the PDU of the response"""
        self.send(adu(pdu, transaction))
        head = self.take(7)
        assert len(head) == 7, f"the connection ended: {self.received!r}"
        answered, protocol, length, unit = struct.unpack(">HHHB", head)
        assert (answered, protocol, unit) == (transaction, 0, 1)
        return self.take(length - 1)

    def close(self):
        """Ends the connection in both directions."""
        if not self.closing:
            self.closing = True
            self.wire.segment(self.port, self.next, self.expected, FIN | ACK, window=self.window)
            self.next = (self.next + 1) % MODULO
        self.wire.until(lambda: self.ended or self.reset, "the board closes, too")
        self.forget()

    def abort(self):
        self.wire.segment(self.port, self.next, self.expected, RST | ACK)
        self.forget()

    def forget(self):
        self.wire.peers.pop(self.port, None)
