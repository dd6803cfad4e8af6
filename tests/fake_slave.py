"""Slaves with scripted answers, on a serial port or as a TCP server."""
import time

import serial as pyserial

from frames import request
from peer_base import TcpPeer, ThreadedPeer


class SerialPeer(ThreadedPeer):
    """Works on a serial port: `_serve_once()` again and again, each time for a moment."""

    def __init__(self, port):
        self._port = port

    def _open(self):
        self._line = pyserial.Serial(self._port, timeout=0.02)

    def _close(self):
        self._line.close()

    def _run(self):
        while not self._stop.is_set():
            self._serve_once()

    def send(self, data):
        """Sends bytes that no request asked for."""
        self._line.write(data)


class SerialSlave(SerialPeer):
    """Answers frames on a serial port: `answers(frame)` gives the bytes to send, or None for silence.

    The end of a frame depends on `framing`: RTU, as every request the tests send has 8 bytes; ASCII, at
    LF."""

    def __init__(self, port, answers, framing="rtu"):
        self._answers, self._framing, self._held = answers, framing, b""
        self.seen = []
        super().__init__(port)

    def _frame(self):
        """The next frame, or None: the port may hand it over in pieces."""
        ascii_ = self._framing == "ascii"
        self._held += self._line.read_until(b"\n") if ascii_ else self._line.read(8 - len(self._held))
        if not self._held.endswith(b"\n") if ascii_ else len(self._held) < 8:
            return None
        frame, self._held = self._held, b""
        self.seen.append(frame)
        return frame

    def _serve_once(self):
        frame = self._frame()
        if not frame:
            return
        answer = self._answers(frame)
        if answer:
            self._line.write(answer)


def rtu_answers(table):
    """Answers by a table {request PDU as hex: response PDU as hex}, for any unit."""
    known = {bytes.fromhex(k): bytes.fromhex(v) for k, v in table.items()}
    return lambda frame: request("rtu", frame[0], known[frame[1:-2]]) if frame[1:-2] in known else None


class TcpSlave(TcpPeer):
    """`answers(adu)` gives the bytes to send, None for silence, "close" to close the connection; bytes and
    "close" as a pair for both. `accepted`: when each connection was made."""

    def __init__(self, answers=lambda adu: None, port=0):
        self._answers, self.accepted = answers, []
        super().__init__(port)

    def _connected(self, peer):
        self.accepted.append(time.monotonic())
        self._begin(self._serve, peer)

    def _serve(self, peer):
        peer.settimeout(0.02)
        with peer:
            while not self._stop.is_set():
                try:
                    adu = peer.recv(300)
                except TimeoutError:
                    continue
                except ConnectionError:
                    return
                if not adu:
                    return
                answer = self._answers(adu)
                if answer == "close":
                    return
                data, closes = answer if isinstance(answer, tuple) else (answer, None)
                if data:
                    peer.sendall(data)
                if closes:
                    return


class Device:
    """A device with holding registers and coils that answers PDUs; `meddle(pdu)` may answer first (bytes), or
    give "silence" for nothing at all, or None to let the device answer. `done` lists its actions."""

    def __init__(self, registers=None, meddle=lambda pdu: None):
        self.registers, self.coils, self.meddle = dict(registers or {}), {}, meddle
        self.done = []

    def __call__(self, pdu):
        answer = self.meddle(pdu)
        if answer == "silence":
            return None
        return answer if answer is not None else self.obey(pdu)

    def obey(self, pdu):
        """The answer of an honest device."""
        self.done.append(pdu.hex(" ").upper())
        function, start, number = pdu[0], int.from_bytes(pdu[1:3], "big"), int.from_bytes(pdu[3:5], "big")
        if function in (3, 4):
            words = [self.registers.get(start + i, 0) & 0xFFFF for i in range(number)]
            return bytes([function, 2 * number]) + b"".join(w.to_bytes(2, "big") for w in words)
        if function == 1:
            bits = sum(1 << i for i in range(number) if self.coils.get(start + i))
            return bytes([function, (number + 7) // 8]) + bits.to_bytes((number + 7) // 8, "little")
        if function == 5:
            self.coils[start] = number == 0xFF00
        elif function == 6:
            self.registers[start] = number
        elif function == 16:
            for i in range(number):
                self.registers[start + i] = int.from_bytes(pdu[6 + 2 * i:8 + 2 * i], "big")
        else:
            return bytes([function | 0x80, 1])
        return pdu[:5]

    def writes(self):
        return [pdu for pdu in self.done if int(pdu[:2], 16) in (5, 6, 15, 16)]

    def over_tcp(self, adu):
        """For TcpSlave."""
        pdu = self(adu[7:])
        return tcp_answer(adu, pdu.hex()) if pdu else None


class RtuDevices(SerialPeer):
    """Devices by unit address on one serial port: every unit has its Device, all others are silent. `delay`:
    seconds before each answer. A broadcast reaches all and is not answered."""

    def __init__(self, port, devices, delay=0.0):
        self.devices, self.delay, self.seen, self._held = devices, delay, [], b""
        super().__init__(port)

    def _serve_once(self):
        self._held += self._line.read(1) + self._line.read(self._line.in_waiting)
        while len(self._held) >= 8:
            length = 9 + self._held[6] if self._held[1] in (15, 16) else 8
            if len(self._held) < length:
                break
            frame, self._held = self._held[:length], self._held[length:]
            self._take(frame)

    def _take(self, frame):
        self.seen.append(frame)
        if frame[0] == 0:
            for device in self.devices.values():
                device(frame[1:-2])
            return
        if frame[0] not in self.devices:
            return
        pdu = self.devices[frame[0]](frame[1:-2])
        if pdu is None:
            return
        if self.delay:
            self._stop.wait(self.delay)
        self._line.write(request("rtu", frame[0], pdu))


def tcp_answer(adu, pdu, *, protocol=0, transaction=None):
    """The MBAP frame that answers `adu` with the PDU (hex text)."""
    body = bytes([adu[6]]) + bytes.fromhex(pdu)
    head = adu[:2] if transaction is None else transaction.to_bytes(2, "big")
    return head + protocol.to_bytes(2, "big") + len(body).to_bytes(2, "big") + body
