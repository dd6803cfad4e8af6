"""Devices that count their own answers, on TCP and on a pseudo-terminal: the independent counters of a plant.

| holding registers | content |
| --- | --- |
| 0, 1 | a uint32 that each answer with both increments, high word first; a part of it is no sample |
| 2 | FIXED |
| 100 and above | `constant(unit, register)` |
"""
import os
import socket
import threading
import time
from dataclasses import dataclass

from frames import crc16
from peer_base import PtyPeer, TcpPeer

FIXED = 12345
CONSTANTS = range(100, 400)
LATE = 0.3  # a thread of the test that takes that long may answer after the time-out


def constant(unit, register):
    return (unit * 7919 + register * 31) & 0xFFFF


@dataclass(slots=True)
class Answer:
    """When the request was received and the answer sent, by time.monotonic()."""
    asked: float
    sent: float


class CountingDevice:
    """A unit. Its answers are numbered from 1 over all runs of the program. `chance` decides its faults: no
    answer, or a closed connection; neither counts."""

    def __init__(self, unit, chance):
        self.unit, self.chance = unit, chance
        self.answers = [Answer(0.0, 0.0)]  # by the number
        self._lock = threading.Lock()

    @property
    def count(self):
        return len(self.answers) - 1

    def answer(self, pdu):
        """The response PDU, b"" for silence, None to close the connection."""
        asked = time.monotonic()
        start, size = int.from_bytes(pdu[1:3], "big"), int.from_bytes(pdu[3:5], "big")
        wanted = range(start, start + size)
        if pdu[0] != 3 or not all(a < 3 or a in CONSTANTS for a in wanted):
            return bytes((pdu[0] | 0x80, 2))
        share = self.chance.random()
        if share < 0.006:
            return b"" if share < 0.003 else None
        with self._lock:
            if start == 0 and size >= 2:
                self.answers.append(Answer(asked, time.monotonic()))
            words = [self._word(a) for a in wanted]
        return bytes((3, 2 * size)) + b"".join(word.to_bytes(2, "big") for word in words)

    def _word(self, register):
        return (self.count >> 16, self.count & 0xFFFF, FIXED)[register] if register < 3 else constant(
            self.unit, register)

    def was_late(self, number):
        """The thread of the test was stopped within this answer."""
        answer = self.answers[number]
        return answer.sent - answer.asked > LATE


class TcpField(TcpPeer):
    """One device on Modbus TCP."""

    def __init__(self, device):
        self.device = device
        super().__init__()

    def _connected(self, peer):
        self._begin(self._serve, peer)

    def _serve(self, peer):
        peer.settimeout(0.05)
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        held = b""
        with peer:
            while not self._stop.is_set():
                try:
                    data = peer.recv(2048)
                    if not data:
                        return
                    held += data
                    while len(held) >= 12:
                        request, held = held[:12], held[12:]
                        answer = self.device.answer(request[7:])
                        if answer is None:
                            return
                        if answer:
                            head = request[:4] + (len(answer) + 1).to_bytes(2, "big") + request[6:7]
                            peer.sendall(head + answer)
                except TimeoutError:
                    continue
                except OSError:
                    return


class PtyField(PtyPeer):
    """One device on Modbus RTU. Requests have eight bytes; a pause ends one that is not whole."""

    def __init__(self, device):
        self.device = device

    def _run(self):
        held = b""
        while not self._stop.is_set():
            if not self._readable(0.02):
                held = b""
                continue
            held += os.read(self._master, 300)
            while len(held) >= 8:
                request, held = held[:8], held[8:]
                if request[0] != self.device.unit or crc16(request[:-2]) != request[-2:]:
                    held = b""
                    break
                answer = self.device.answer(request[1:-2])
                if answer:
                    frame = bytes((self.device.unit, )) + answer
                    os.write(self._master, frame + crc16(frame))
