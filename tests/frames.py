"""Frames as the tests know them, by their own arithmetic: check sums, the traffic log, and captures for
tshark."""
import re
import struct


def crc16(data):
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ 0xA001 if crc & 1 else crc >> 1
    return struct.pack("<H", crc)


def lrc(data):
    return -sum(data) & 0xFF


def request(framing, unit, pdu):
    """The frame of a PDU (hex text or bytes) in `rtu` or `ascii`; responses have the same shape."""
    body = bytes([unit]) + (bytes.fromhex(pdu) if isinstance(pdu, str) else pdu)
    if framing == "rtu":
        return body + crc16(body)
    return b":" + (body + bytes([lrc(body)])).hex().upper().encode() + b"\r\n"


TRAFFIC = re.compile(
    r"^\[\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}[+-]\d\d:\d\d\] TRA : "
    r"(?P<line>.*?)::(?P<device>.*?):\((?P<port>.*?)\) (?P<way>Tx|Rx): \[(?P<length>\d{4})\] "
    r"(?P<bytes>[0-9A-F]{2}(?: [0-9A-F]{2})*|:[0-9A-F]+)(?: \| (?P<words>.+))?$")


class Frame:
    """One line of a traffic log: bytes in hexadecimal, or a frame of ASCII as it reads, without its CR LF."""

    def __init__(self, text):
        match = TRAFFIC.match(text)
        assert match, f"not a traffic line: {text!r}"
        self.line, self.device, self.port, self.way = match["line"], match["device"], match["port"], match[
            "way"]
        self.hex, self.words = match["bytes"], match["words"]
        self.bytes = self.hex.encode() + b"\r\n" if self.hex.startswith(":") else bytes.fromhex(self.hex)
        assert len(self.bytes) == int(match["length"]), f"the length does not fit: {text!r}"


INCIDENT = re.compile(r"^\[[^]]+\] TRA : .*?::(?:.*?:)?\(.*?\) (?:connected|disconnected"
                      r"|no response within [\d.]+ m?s|late response: late by [\d.]+ m?s"
                      r"|surplus response(?:: .+ was asked)?)$")


def traffic(text):
    """The frames of a traffic log, without the lines about what happens besides frames."""
    return [Frame(line) for line in text.splitlines() if not INCIDENT.match(line)]


def without_checks(requests):
    """Requests of two registers as text, without the longer ones by which a device whose requests look alike
    is checked once a second."""
    return [r for r in requests if r.split()[5] != "03"]


def split_rtu(data, lengths):
    """Cuts a stream of frames, each of one of `lengths`, where their CRCs fit; fails on anything left
    over."""
    frames = []
    while data:
        size = next((n for n in lengths if len(data) >= n and crc16(data[:n - 2]) == data[n - 2:n]), None)
        assert size, f"no frame of {lengths} bytes begins at {data[:16].hex(' ')}"
        frames.append(data[:size])
        data = data[size:]
    return frames


def pcap(link_type, packets):
    """A capture file (classic format) of `packets`, 1 ms apart."""
    parts = [struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, link_type)]
    for number, packet in enumerate(packets):
        parts.append(
            struct.pack("<IIII", number // 1000, number % 1000 * 1000, len(packet), len(packet)) + packet)
    return b"".join(parts)


class TcpCapture:
    """Builds raw IPv4 packets (link type 101) of one TCP connection from the chunks that passed."""

    LINK_TYPE = 101

    def __init__(self, client_port, server_port):
        self._ports, self._next = (client_port, server_port), [1000, 5000]
        self.server_port = server_port
        self.packets = []
        self._add(0, 0x02)
        self._add(1, 0x12)
        self._add(0, 0x10)

    def chunk(self, from_server, data):
        self._add(int(from_server), 0x18, data)
        self._add(1 - int(from_server), 0x10)

    def _add(self, side, flags, data=b""):
        acknowledged = self._next[1 - side] if flags & 0x10 else 0
        tcp = struct.pack(">HHIIBBHHH", self._ports[side], self._ports[1 - side], self._next[side],
                          acknowledged, 5 << 4, flags, 65535, 0, 0)
        ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(tcp) + len(data), len(self.packets), 0x4000, 64,
                         6, 0,
                         *((b"\x7f\0\0\1", b"\x7f\0\0\2") if side == 0 else (b"\x7f\0\0\2", b"\x7f\0\0\1")))
        self.packets.append(ip + tcp + data)
        self._next[side] += len(data) + (1 if flags & 0x02 else 0)
