"""A broker of MQTT 3.1.1 and 5 that accepts what it gets, and sends what a test wants."""
import socket
import threading


def varint(value):
    out = bytearray()
    while True:
        out.append((value & 0x7F) | (0x80 if value > 0x7F else 0))
        value >>= 7
        if not value:
            return bytes(out)


def publish_header(topic, payload_bytes, qos=1, identifier=7, version=4):
    """A PUBLISH without its payload."""
    body = len(topic).to_bytes(2) + topic.encode() + (identifier.to_bytes(2) if qos else b"")
    body += b"\0" if version == 5 else b""
    return bytes([0x30 | qos << 1]) + varint(len(body) + payload_bytes) + body


class HostileBroker:
    """Answers CONNECT, SUBSCRIBE, PUBLISH with QoS 1, PINGREQ. send() goes to the newest connection."""

    def __init__(self, only_version=None):
        self._only = only_version
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self.version = None
        self.connections, self.connects = 0, []
        self.published = 0         # messages of the client
        self.acknowledged = set()  # its answers: type and identifier
        self._socket, self._lock = None, threading.Lock()
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(connection, ), daemon=True).start()

    def close(self):
        self._listener.close()
        if self._socket:
            self._socket.close()

    def send(self, *parts):
        with self._lock:
            for part in parts:
                self._socket.sendall(part)

    def _serve(self, connection):
        stream = connection.makefile("rb")
        try:
            while (packet := self._read(stream)) is not None:
                if self._answer(connection, *packet):
                    return connection.close()
        except OSError:
            pass

    @staticmethod
    def _read(stream):
        first = stream.read(1)
        if not first:
            return None
        length, shift = 0, 0
        while True:
            byte = stream.read(1)[0]
            length |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return first[0], stream.read(length)

    def _answer(self, connection, first, body):
        kind = first >> 4
        if kind == 1:
            version = body[6]
            self.connects.append(body)
            if self._only not in (None, version):
                connection.sendall(b"\x20\x02\x00\x01")
                return True
            self.version, self._socket = version, connection
            self.connections += 1
            self.send(b"\x20\x03\0\0\0" if version == 5 else b"\x20\x02\0\0")
        elif kind == 3 and first & 6:
            self.published += 1
            at = 2 + int.from_bytes(body[:2])
            self.send(b"\x40\x02" + body[at:at + 2])
        elif kind in (4, 5):
            self.acknowledged.add((kind, int.from_bytes(body[:2])))
        elif kind == 7:
            self.acknowledged.add((kind, int.from_bytes(body[:2])))
        elif kind == 8:
            self.send(bytes([0x90, 4 if self.version == 5 else 3]) + body[:2] +
                      (b"\0\1" if self.version == 5 else b"\1"))
        elif kind == 12:
            self.send(b"\xD0\0")
        return False
