"""A serial bus of pseudo-terminals with devices. The record of the bus has each frame. A master receives the
answers to its own requests only, because neither library copes with frames of others; the port "listener"
receives all."""
import collections
import ctypes
import os
import select
import struct
import threading
import time
import tty

from frames import crc16, lrc, split_rtu
from peer_base import ThreadedPeer


def frame(framing, unit, pdu):
    body = bytes([unit]) + pdu
    return body + crc16(body) if framing == "rtu" else b":" + (
        body + bytes([lrc(body)])).hex().upper().encode() + b"\r\n"


def unframed(framing, data):
    """(unit, PDU) of one whole frame; None of anything else."""
    if framing == "ascii":
        if not (data.startswith(b":") and data.endswith(b"\r\n")):
            return None
        body = bytes.fromhex(data[1:-2].decode())
        return (body[0], body[1:-1]) if sum(body) & 0xFF == 0 else None
    return (data[0], data[1:-2]) if len(data) >= 4 and crc16(data[:-2]) == data[-2:] else None


def split(framing, data):
    """The frames of a master that asked again before its last request was read; requests of RTU have eight
    bytes."""
    return data.splitlines(keepends=True) if framing == "ascii" else split_rtu(data, [8])


def answer(pdu):
    """What a device with 100 holding registers answers; register a holds a."""
    function, start = pdu[0], struct.unpack(">H", pdu[1:3])[0]
    if function == 3:
        count = struct.unpack(">H", pdu[3:5])[0]
        if start + count > 100:
            return bytes([0x83, 2])
        return bytes([3, 2 * count]) + b"".join(struct.pack(">H", start + i) for i in range(count))
    return {6: pdu, 16: pdu[:5]}.get(function, bytes([function | 0x80, 1]))


class Bus(ThreadedPeer):
    """`ports`: names to the paths of its ports. `frames`: (sender, unit, PDU), senders are the ports and
    "device"; `answers`: (unit, request PDU, answer PDU or None) for each request. `asked_at`: (time, unit,
    request PDU) and `response_times`, both in seconds."""

    def __init__(self, names, units=(1, 2, 3), framing="rtu", delay=0.004):
        self.names, self.units, self.framing, self.delay = names, units, framing, delay
        self.frames, self.answers, self.sent_by = [], [], {name: b"" for name in names}
        self.asked_at, self.response_times = [], []
        self._due = collections.deque()  # (time, requester, unit, answer)

    def _open(self):
        self._ends = {name: os.openpty() for name in self.names}
        for master, slave in self._ends.values():
            tty.setraw(slave)
            os.set_blocking(master, False)
        self.ports = {name: os.ttyname(slave) for name, (_, slave) in self._ends.items()}

    def _close(self):
        for ends in self._ends.values():
            for end in ends:
                os.close(end)

    def send(self, data, requester=None):
        """Puts bytes on the bus, for the listener and the master that asked."""
        for name in {"listener", requester} & set(self._ends):
            os.write(self._ends[name][0], data)

    def _run(self):
        of_descriptor = {master: name for name, (master, _) in self._ends.items()}
        while not self._stop.is_set():
            wait = max(0, min(0.02, self._due[0][0] - time.monotonic())) if self._due else 0.02
            for master in select.select(list(of_descriptor), [], [], wait)[0]:
                data = os.read(master, 4096)
                self.sent_by[of_descriptor[master]] += data
                for sent in split(self.framing, data):
                    self._pass_on(of_descriptor[master], sent)
            while self._due and self._due[0][0] <= time.monotonic():
                due, requester, unit, reply = self._due.popleft()
                self.response_times.append(time.monotonic() - due + self.delay)
                self.send(frame(self.framing, unit, reply), requester)
                self.frames.append(("device", unit, reply))

    def _pass_on(self, name, sent):
        self.send(sent)
        received = unframed(self.framing, sent)
        assert received, f"no whole frame was written at once: {sent.hex(' ')}"
        unit, pdu = received
        self.frames.append((name, unit, pdu))
        self.asked_at.append((time.monotonic(), unit, pdu))
        reply = answer(pdu) if unit in self.units else None
        self.answers.append((unit, pdu, reply))
        if reply is not None:
            self._due.append((time.monotonic() + self.delay, name, unit, reply))


class Master(threading.Thread):
    """Polls in a thread of its own: one cycle after the other, each `period` seconds after the one before. A
    failed request is the bus's business: with two masters some fail."""

    def __init__(self, period):
        super().__init__(daemon=True)
        self.period, self.cycles, self._stop_polling = period, 0, threading.Event()

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *_):
        self._stop_polling.set()
        self.join()
        self.close()

    def run(self):
        due = time.monotonic()
        while not self._stop_polling.wait(max(0, due - time.monotonic())):
            self.cycle()
            self.cycles += 1
            due += self.period

    def close(self):
        pass


class PymodbusMaster(Master):

    def __init__(self, port, period, reads, framing="rtu"):
        super().__init__(period)
        from pymodbus.client import ModbusSerialClient
        from pymodbus.transaction import ModbusAsciiFramer, ModbusRtuFramer
        framer = ModbusRtuFramer if framing == "rtu" else ModbusAsciiFramer
        self._client = ModbusSerialClient(port, framer=framer, baudrate=115200, parity="N", timeout=1.0,
                                          retries=0)
        assert self._client.connect()
        self._reads = reads

    def cycle(self):
        for unit, start, count in self._reads:
            self._client.read_holding_registers(start, count, slave=unit)

    def close(self):
        self._client.close()


class LibmodbusMaster(Master):
    """Writes register `start` of each of `writes` and reads each of `reads`."""

    def __init__(self, port, period, reads, writes=()):
        super().__init__(period)
        self._lib = ctypes.CDLL("libmodbus.so.5")
        self._lib.modbus_new_rtu.restype = ctypes.c_void_p
        self._lib.modbus_new_rtu.argtypes = [
            ctypes.c_char_p, ctypes.c_int, ctypes.c_char, ctypes.c_int, ctypes.c_int
        ]
        for name, arguments in {
                "connect": [],
                "close": [],
                "free": [],
                "flush": [],
                "set_slave": [ctypes.c_int],
                "set_response_timeout": [ctypes.c_uint32, ctypes.c_uint32],
                "read_registers": [ctypes.c_int, ctypes.c_int, ctypes.c_void_p],
                "write_register": [ctypes.c_int, ctypes.c_uint16]
        }.items():
            getattr(self._lib, f"modbus_{name}").argtypes = [ctypes.c_void_p, *arguments]
        self._bus = self._lib.modbus_new_rtu(port.encode(), 115200, b"N", 8, 1)
        assert self._lib.modbus_connect(self._bus) == 0
        self._lib.modbus_set_response_timeout(self._bus, 5, 0)  # a busy machine must cause no repetition
        self._reads, self._writes = reads, writes

    def _address(self, unit):
        self._lib.modbus_set_slave(self._bus, unit)

    def cycle(self):
        values = (ctypes.c_uint16 * 125)()
        for unit, start, count in self._reads:
            self._address(unit)
            self._lib.modbus_read_registers(self._bus, start, count, values)
        for unit, start in self._writes:
            self._address(unit)
            self._lib.modbus_write_register(self._bus, start, self.cycles & 0xFFFF)

    def close(self):
        self._lib.modbus_close(self._bus)
        self._lib.modbus_free(self._bus)
