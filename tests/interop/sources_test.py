"""Servers bound to instruments, files, commands and generators, by `takt serve`."""
import os
import socket
import struct

import pytest

import endpoints
from converter_test import Client
from fake_slave import SerialPeer
from program import DEADLINE, start, takt, until
from projects import TEN_REGISTERS

HEAD = """
takt: 1
{instruments}
""" + TEN_REGISTERS


def served(project, variables, instruments=""):
    """The project's path and its port; `variables`: (register, type, keys)."""
    port = endpoints.free_port()
    text = HEAD.format(port=port, instruments=instruments)
    for register, kind, keys in variables:
        text += f"          - {{name: V{register}, area: holding_register, register: {register}, " \
            f"type: {kind}, {keys}}}\n"
    return project(text), port


def reading(client, register, count=1):
    """The registers, or the exception's number."""
    answer = client.ask(f"03 {register:04X} {count:04X}")
    return answer[1] if answer[0] & 0x80 else list(struct.unpack(f">{count}H", answer[2:]))


class Instrument(SerialPeer):
    """Answers on a serial port: `answers` is {question: answer}; silent for what is not there."""

    def __init__(self, port, answers):
        self.answers = answers
        self._heard = b""
        super().__init__(port)

    def _serve_once(self):
        self._heard += self._line.read(1)
        for question in list(self.answers):
            if self._heard.endswith(question):
                self._heard = b""
                self._line.write(self.answers[question])


INSTRUMENTS = """
instruments:
  - name: scale
    port: {port}
    baud: 9600
    every: 50ms
    timeout: 1s
    exchanges:
      - {{request: '?W\\r', answer: {{until: '\\r', pattern: '{{weight}} kg'}}}}
      - {{request: '\\x05', answer: {{length: 4, begins: '\\x02', checksum: xor, fields: [
           {{name: flow, offset: 1, type: int16}}]}}}}
"""


def binary(value):
    body = struct.pack(">Bh", 2, value)
    return body + bytes([body[0] ^ body[1] ^ body[2]])


def test_an_instrument_with_text_and_binary_answers(project, pair):
    path, port = served(project,
                        [(0, "float", "source: {instrument: scale.weight}, max_age: 2s"),
                         (2, "int16", "source: {instrument: scale.flow}, max_age: 2s"),
                         (3, "int16", "source: {instrument: scale.weight}, scale: 0.01, max_age: 1h")],
                        INSTRUMENTS.format(port=pair.b))
    with Instrument(pair.a, {b"?W\r": b"+  12.50 kg\r", b"\x05": binary(-300)}) as instrument, \
            start("serve", path) as running:
        endpoints.wait_listening(port, running)
        client = Client(port)
        until(lambda: reading(client, 0, 3) == [0x4148, 0, 0xFED4], "12.5 and -300")
        assert reading(client, 3) == [1250], "scaled to whole hundredths"

        instrument.answers[b"?W\r"] = b"+  13.50 lb\r"  # not in its form
        instrument.answers[b"\x05"] = binary(7)[:3] + b"\x00"  # wrong checksum
        until(lambda: reading(client, 0, 2) == 0x0B and reading(client, 2) == 0x0B,
              "nothing wrong becomes a value")
        assert reading(client, 3) == [1250], "it may be an hour old"

        instrument.answers[b"?W\r"] = os.urandom(3000) + b"\r\r14.00 kg\r"
        until(lambda: reading(client, 0, 2) == [0x4160, 0], "the answer behind garbage")
        instrument.answers.clear()
        until(lambda: reading(client, 0, 2) == 0x0B, "a silent instrument")
        instrument.answers[b"?W\r"] = b"1 kg\r"
        until(lambda: reading(client, 0, 2) == [0x3F80, 0], "it is back")
        running.interrupt()


def test_an_instrument_that_talks_by_itself_over_tcp(project):
    listener = socket.create_server(("127.0.0.1", 0))
    listener.settimeout(DEADLINE)
    path, port = served(
        project, [(0, "int16", "source: {instrument: meter.v}, max_age: 2s")], f"""
instruments:
  - {{name: meter, transport: tcp, host: 127.0.0.1, tcp_port: {listener.getsockname()[1]}, timeout: 50ms,
     exchanges: [
      {{answer: {{until: '\\n', pattern: 'V={{v}}'}}}}]}}
""")
    with start("serve", path) as running:
        connection, _ = listener.accept()
        endpoints.wait_listening(port, running)
        client = Client(port)
        assert reading(client, 0) == 0x0B
        connection.sendall(b"5\nV=17\nV=1")
        until(lambda: reading(client, 0) == [17], "the first whole line")
        connection.close()
        until(lambda: reading(client, 0) == 0x0B, "it hung up")
        listener.accept()[0].sendall(b"\nV=18\n")
        until(lambda: reading(client, 0) == [18], "after it was connected again")
        running.interrupt()
    listener.close()


def test_files_and_commands(project, tmp_path):
    file, written = tmp_path / "temperature", tmp_path / "written"
    file.write_text("temp=21\n")
    count = tmp_path / "count"
    count.write_text(" \t3 \n")
    script = tmp_path / "write"
    script.write_text(f'#!/bin/sh\n[ "$1" = 9 ] && exit 1\necho "$1" > {written}\n')
    script.chmod(0o755)
    path, port = served(project, [
        (0, "int16",
         f"source: {{file: {{path: {file}, every: 20ms, pattern: 'temp={{value}}'}}}}, max_age: 1s"),
        (1, "int16", "source: {command: {run: [echo, '42'], every: 20ms}}, max_age: 5s"),
        (2, "int16", "source: {command: {run: [sleep, '60'], every: 20ms, timeout: 50ms}}"),
        (3, "int16", f"writes_to: {{command: {{run: [{script}, '{{value}}'], timeout: 10s}}}}"),
        (4, "int16", "source: {constant: -5}"),
        (5, "int16", f"source: {{file: {{path: {count}, every: 20ms}}}}, max_age: 1h"),
        (6, "int16", "source: {command: {run: [printf, ' 17 \\n\\n'], every: 20ms}}, max_age: 1h"),
    ])
    with start("serve", path) as running:
        endpoints.wait_listening(port, running)
        client = Client(port)
        until(lambda: reading(client, 0, 2) == [21, 42], "file and command")
        until(lambda: reading(client, 5, 2) == [3, 17], "with spaces around it, as wc and ps write it")
        assert reading(client, 2) == 0x0B, "it never ends"
        assert reading(client, 4) == [0xFFFB]
        file.write_text("temp=-3\n")
        until(lambda: reading(client, 0) == [0xFFFD], "the new content")
        file.write_text("temp=?\n")
        until(lambda: reading(client, 0) == 0x0B, "no number")
        assert client.ask("06 0003 0007") == bytes.fromhex("0600030007")
        assert written.read_text() == "7\n", "done before it is answered"
        assert client.ask("06 0003 0009") == bytes.fromhex("8604"), "the command failed"
        assert reading(client, 3) == [7]
        assert client.ask("06 0004 0001") == bytes.fromhex("8602")
        running.interrupt()


def test_generators_and_a_replay(project, tmp_path):
    (tmp_path / "day.csv").write_text("time;level\n0;10\n1;20\n2;30\n")
    path, port = served(project, [
        (0, "int16", f"source: {{replay: {{file: {tmp_path}/day.csv, column: level, every: 30ms}}}}"),
        (1, "int16", "source: {counter: {from: 1, to: 3, every: 20ms}}"),
        (2, "float", "source: {sine: {amplitude: 2, offset: 5, period: 100ms}}"),
    ])
    with start("serve", path) as running:
        endpoints.wait_listening(port, running)
        client = Client(port)
        seen = [set(), set(), set()]

        def all_seen():
            a, b, c, d = reading(client, 0, 4)
            for values, value in zip(seen, (a, b, struct.unpack(">f", struct.pack(">HH", c, d))[0])):
                values.add(value)
            return seen[0] == {10, 20, 30} and seen[1] == {1, 2, 3} and len(seen[2]) > 10

        until(all_seen, "every row and number")
        assert min(seen[2]) >= 3 and max(seen[2]) <= 7
        running.interrupt()


def test_sources_that_takt_serve_lacks_are_reported(project, pair):
    port = endpoints.free_port()
    path = project(f"""
takt: 1
lines:
  - {{name: l, port: {pair.a}, devices: [{{name: D, address: 1, variables: [
      {{name: P, type: int, register: 0, read: 3, write: 6}}]}}]}}
servers:
  - {{name: s, listen: 127.0.0.1, tcp_port: {port}, units: [
      {{address: 1, banks: [{{area: holding_register, items: [0]}}], variables: [
          {{name: V, type: int, area: holding_register, register: 0, source: {{variable: P}},
           writes_to: {{variable: P}}}}]}}]}}
""")
    with start("serve", path) as running:
        endpoints.wait_listening(port, running)
        client = Client(port)
        assert reading(client, 0) == 0x0B
        assert client.ask("06 0000 0001") == bytes.fromhex("860B")
        assert "takt run" in running.interrupt().err


@pytest.mark.parametrize("file", ["none.csv", "bad.csv"])
def test_an_unreadable_replay_is_reported(project, tmp_path, file):
    (tmp_path / "bad.csv").write_text("a\n1\nx\n")
    path, _ = served(project, [(0, "int16", f"source: {{replay: {{file: {tmp_path}/{file}, column: a}}}}")])
    result = takt("serve", path, code=None)
    assert result.code != 0 and file in result.err
