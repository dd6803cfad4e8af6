"""Captures with times, made byte by byte: connections of Modbus TCP, link layers, pcap and pcapng."""
import struct

SYN, ACK, PSH, FIN, RST = 2, 16, 8, 1, 4
MACS = bytes.fromhex("0200000000010200000000 02".replace(" ", ""))
# The link layer before an IPv4 packet, and its type.
LINKS = {
    "raw": (101, b""),
    "ethernet": (1, MACS + b"\x08\0"),
    "vlan": (1, MACS + b"\x81\0\0\x07\x08\0"),
    "qinq": (1, MACS + b"\x88\xa8\0\x07\x81\0\0\x08\x08\0"),
    "cooked": (113, bytes.fromhex("0000 0001 0006 020000000001 0000 0800")),
    "cooked2": (276, bytes.fromhex("0800 0000 00000001 0001 00 06 0200000000010000")),
    "null": (0, b"\2\0\0\0"),
}
START = 1_700_000_000_000_000_000  # ns


def adu(transaction, unit, pdu):
    pdu = bytes.fromhex(pdu) if isinstance(pdu, str) else pdu
    return struct.pack(">HHHB", transaction, 0, len(pdu) + 1, unit) + pdu


def blocks(path):
    """Type and body of each whole block of a pcapng file in the order of this machine, which may still be
    written."""
    data, at = path.read_bytes(), 0
    while at + 8 <= len(data):
        kind, size = struct.unpack_from("=II", data, at)
        if at + size <= len(data):
            yield kind, data[at + 8:at + size - 4]
        at += size


def packets_in(path):
    return sum(kind == 6 for kind, _ in blocks(path))


def sum16(data):
    total = sum(struct.unpack(f">{(len(data) + 1) // 2}H", data + b"\0" * (len(data) % 2)))
    while total > 0xFFFF:
        total = (total & 0xFFFF) + (total >> 16)
    return ~total & 0xFFFF


class Capture:
    """Packets (time in ns, bytes of an IPv4 packet), in the order of the capture."""

    def __init__(self):
        self.packets = []
        self._identification = 0

    def add(self, time_ns, source, target, sequence, acknowledged, flags, data=b""):
        addresses = b"".join(bytes(map(int, end[0].split("."))) for end in (source, target))
        tcp = struct.pack(">HHIIBBHHH", source[1], target[1], sequence & 0xFFFFFFFF,
                          acknowledged & 0xFFFFFFFF, 5 << 4, flags, 65535, 0, 0) + data
        check = sum16(addresses + struct.pack(">HH", 6, len(tcp)) + tcp)
        tcp = tcp[:16] + struct.pack(">H", check) + tcp[18:]
        self._identification = self._identification % 65535 + 1
        head = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(tcp), self._identification, 0x4000, 64, 6,
                           0) + addresses
        head = head[:10] + struct.pack(">H", sum16(head)) + head[12:]
        self.packets.append((START + time_ns, head + tcp))

    def pcap(self, link="raw", nanoseconds=True, order="<", packets=None):
        kind, header = LINKS[link]
        parts = [
            struct.pack(order + "IHHiIII", 0xA1B23C4D if nanoseconds else 0xA1B2C3D4, 2, 4, 0, 0, 65535, kind)
        ]
        for time_ns, packet in packets or self.packets:
            seconds, rest = divmod(time_ns, 1_000_000_000)
            size = len(header) + len(packet)
            parts.append(
                struct.pack(order + "IIII", seconds, rest if nanoseconds else rest // 1000, size, size) +
                header + packet)
        return b"".join(parts)

    def pcapng(self, link="raw", resolution=9, order="<", sections=1):

        def block(kind, body):
            body += b"\0" * (-len(body) % 4)
            size = struct.pack(order + "I", len(body) + 12)
            return struct.pack(order + "I", kind) + size + body + size

        kind, header = LINKS[link]
        parts, each = [], -(-len(self.packets) // sections)
        for number, (time_ns, packet) in enumerate(self.packets):
            if number % each == 0:
                parts.append(block(0x0A0D0D0A, struct.pack(order + "IHHq", 0x1A2B3C4D, 1, 0, -1)))
                option = struct.pack(order + "HHB3xHH", 9, 1, resolution, 0, 0)
                parts.append(block(1, struct.pack(order + "HHI", kind, 0, 0) + option))
            ticks = time_ns // 10**(9 - resolution)
            size = len(header) + len(packet)
            head = struct.pack(order + "IIIII", 0, ticks >> 32, ticks & 0xFFFFFFFF, size, size)
            parts.append(block(6, head + header + packet))
        return b"".join(parts)


class Connection:
    """A TCP connection in a capture. Each call adds one packet at a time in us; `captured=False` adds
    none."""

    def __init__(self, capture, client=("10.0.0.1", 40000), server=("10.0.0.2", 502), at=0):
        self._capture, self._ends, self.next = capture, (client, server), [1000, 0xFFFFFF00]
        for side, flags in ((0, SYN), (1, SYN | ACK), (0, ACK)):
            self._send(at, side, flags)

    def request(self, at, data, **how):
        self._send(at, 0, PSH | ACK, data, **how)

    def respond(self, at, data, **how):
        self._send(at, 1, PSH | ACK, data, **how)

    def close(self, at):
        for side in (0, 1):
            self._send(at, side, FIN | ACK)
        self._send(at, 0, ACK)

    def again(self, at, from_server, data, before=0):
        """Sends again `data`, which ended `before` bytes ahead of what was sent last."""
        side = int(from_server)
        self._packet(at, side, self.next[side] - before - len(data), PSH | ACK, data)

    def _packet(self, at, side, sequence, flags, data):
        self._capture.add(round(at * 1000), self._ends[side], self._ends[1 - side], sequence,
                          self.next[1 - side] if flags & ACK else 0, flags, data)

    def _send(self, at, side, flags, data=b"", captured=True):
        if captured:
            self._packet(at, side, self.next[side], flags, data)
        self.next[side] += len(data) + (1 if flags & (SYN | FIN) else 0)
