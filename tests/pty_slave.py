"""Slaves behind a pseudo-terminal that answer only at their bit rate: a pty keeps the settings of the program
that opened it."""
import os
import struct
import termios
import time

from frames import crc16
from peer_base import PtyPeer

BAUDS = {
    9600: termios.B9600,
    19200: termios.B19200,
    38400: termios.B38400,
    57600: termios.B57600,
    115200: termios.B115200
}


class Device:
    """The answers of a unit. `registers`: {address: value} for 0x03; `objects`: those of 43/14; `limit`: the
    longest read; `refused`: {address: exception} of registers that exist and cannot be read."""

    def __init__(self, unit, baud=19200, registers=None, objects=None, server_id=None, limit=125, exception=2,
                 delay=0.0, garble=False, refused=()):
        self.refused = dict(refused)
        self.unit, self.baud, self.limit, self.exception, self.delay = unit, baud, limit, exception, delay
        self.registers = {0: unit} if registers is None else registers
        self.objects, self.server_id, self.garble = objects, server_id, garble

    def answer(self, pdu):
        function = pdu[0]
        refuse = lambda code: bytes([function | 0x80, code])
        if function == 0x03 and len(pdu) == 5:
            start, count = struct.unpack(">HH", pdu[1:])
            wanted = range(start, start + count)
            if all(a in self.refused for a in wanted):
                return refuse(self.refused[start])
            if count > self.limit or any(a not in self.registers for a in wanted):
                return refuse(self.exception) if self.exception else None
            return bytes([3, 2 * count]) + b"".join(struct.pack(">H", self.registers[a]) for a in wanted)
        if function == 0x2B and self.objects:
            body = b"".join(bytes([i, len(t)]) + t.encode() for i, t in self.objects.items())
            return bytes([0x2B, 0x0E, pdu[2], 0x81, 0, 0, len(self.objects)]) + body
        if function == 0x11 and self.server_id:
            return bytes([0x11, len(self.server_id)]) + self.server_id
        return refuse(1)


class PtyLine(PtyPeer):
    """Devices on a serial line. `asked` counts the received requests."""

    def __init__(self, *devices):
        self.devices = devices
        self.asked = 0

    def _run(self):
        received = b""
        while not self._stop.is_set():
            if not self._readable(0.02):
                received = b""
                continue
            received += os.read(self._master, 300)
            if len(received) > 3 and crc16(received[:-2]) == received[-2:]:
                self.asked += 1
                self._answer(received[0], received[1:-2])
                received = b""

    def _answer(self, unit, pdu):
        speed = termios.tcgetattr(self._master)[5]
        for device in self.devices:
            if device.unit != unit or BAUDS[device.baud] != speed:
                continue
            answer = device.answer(pdu)
            if answer is None:
                continue
            frame = bytes([unit]) + answer
            frame += crc16(frame)
            if device.garble:
                frame = bytes(b ^ 0x55 for b in frame)
            time.sleep(device.delay)
            os.write(self._master, frame)
