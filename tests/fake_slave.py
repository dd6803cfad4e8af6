"""Slaves that answer exactly what a test tells them, on a serial port or as a TCP server."""
import socket
import threading

import serial as pyserial

from frames import request


class SerialSlave:
    """Answers frames on a serial port: `answers(frame)` gives the bytes to send, or None for silence.

    A frame ends when `framing` says so: RTU, as every request the tests send has 8 bytes; ASCII, at LF."""

    def __init__(self, port, answers, framing="rtu"):
        self._line = pyserial.Serial(port, timeout=0.02)
        self._answers, self._framing = answers, framing
        self.seen = []
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join()
        self._line.close()

    def _run(self):
        while not self._stop.is_set():
            frame = self._line.read_until(b"\n") if self._framing == "ascii" else self._line.read(8)
            if not frame:
                continue
            self.seen.append(frame)
            answer = self._answers(frame)
            if answer:
                self._line.write(answer)

    def send(self, data):
        """Sends what nobody asked for at this moment."""
        self._line.write(data)


def rtu_answers(table):
    """Answers by a table {request PDU as hex: response PDU as hex}; the unit is whatever was asked."""
    known = {bytes.fromhex(k): bytes.fromhex(v) for k, v in table.items()}
    return lambda frame: request("rtu", frame[0], known[frame[1:-2]]) if frame[1:-2] in known else None


class TcpSlave:
    """Listens on a port of its own; `answers(adu)` gives the bytes to send, None for silence."""

    def __init__(self, answers=lambda adu: None):
        self._answers = answers
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._listener.settimeout(0.02)
        self.port = self._listener.getsockname()[1]
        self._stop = threading.Event()
        self._threads = [threading.Thread(target=self._accept, daemon=True)]
        self._threads[0].start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stop.set()
        for thread in self._threads:
            thread.join()
        self._listener.close()

    def _accept(self):
        while not self._stop.is_set():
            try:
                peer, _ = self._listener.accept()
            except TimeoutError:
                continue
            self._threads.append(threading.Thread(target=self._serve, args=(peer,), daemon=True))
            self._threads[-1].start()

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
                if answer:
                    peer.sendall(answer)


def tcp_answer(adu, pdu, *, protocol=0, transaction=None):
    """The MBAP frame that answers `adu` with the PDU (hex text)."""
    body = bytes([adu[6]]) + bytes.fromhex(pdu)
    head = adu[:2] if transaction is None else transaction.to_bytes(2, "big")
    return head + protocol.to_bytes(2, "big") + len(body).to_bytes(2, "big") + body
