"""The TCP slave on emulated boards, with masters that are not ours and with takt, through QEMU's network."""
import json
import random
import re
import socket
import struct
import subprocess
import threading

import pytest

import endpoints
from ethernet import adu, free_port, running
from program import DEADLINE, start, takt, until
from projects import slave

CONNECTIONS = 4


@pytest.fixture(scope="module", name="port")
def port_of_a_board(tmp_path_factory):
    with on_network("an385", tmp_path_factory.mktemp("board")) as (port, _):
        yield port


class on_network:

    def __init__(self, board, folder):
        self.port = free_port()
        self.board = running(board, "tcp", folder, "-nic", f"user,hostfwd=tcp:127.0.0.1:{self.port}-:502")

    def __enter__(self):
        return self.port, self.board.__enter__()

    def __exit__(self, *error):
        return self.board.__exit__(*error)


@pytest.mark.parametrize("board", ["an385", "an386"])
def test_the_bench_of_the_source(board, tmp_path):
    """An HMI writes 444 to register 40108, the slave shows it and returns 01 BC."""
    with on_network(board, tmp_path) as (port, uart):
        endpoint = f"tcp://127.0.0.1:{port}"
        takt("write", endpoint, "holding", 107, 444)
        assert takt("read", endpoint, "holding", 107, "--json").json["values"] == [444]
        assert "01 BC" in takt("raw", endpoint, "03006b0001").out.upper()
        until(lambda: "40108 = 444\r\n" in uart.read_bytes().decode(), "the value on the UART")
        refused = takt("read", endpoint, "holding", 128, code=None)
        assert refused.code != 0 and "exception 2" in refused.out + refused.err


def connection(port):
    peer = socket.create_connection(("127.0.0.1", port), DEADLINE)
    peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return peer


def take(peer, size):
    taken = b""
    while len(taken) < size:
        part = peer.recv(size - len(taken))
        assert part, f"the connection ended after {taken!r}"
        taken += part
    return taken


def read(peer, register, transaction=1):
    """@returns the value of a holding register"""
    peer.sendall(adu(struct.pack(">BHH", 3, register, 1), transaction))
    response = take(peer, 11)
    assert response[:-2] == adu("03 02 0000", transaction)[:-2]
    return struct.unpack(">H", response[-2:])[0]


def counters(port):
    """@returns connections accepted, refused, closed; the one that asks included"""
    return takt("read", f"tcp://127.0.0.1:{port}", "input", 1, 3, "--json").json["values"]


def only_one_is_open(port):
    accepted, _, closed = counters(port)
    return accepted == closed + 1


def test_mbpoll(port):
    """mbpoll is a program of libmodbus."""

    def mbpoll(*arguments):
        command = ["mbpoll", "-m", "tcp", "-p", str(port), "-0", "-1", "-a", "1", "-o", "5", *arguments]
        done = subprocess.run(command, capture_output=True, timeout=DEADLINE, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return {int(r): v for r, v in re.findall(r"^\[(\d+)\]:\s+(\S+)", done.stdout, re.MULTILINE)}

    mbpoll("-t", "4", "-r", "10", "127.0.0.1", "1", "2", "3")
    read_back = mbpoll("-t", "4", "-r", "9", "-c", "5", "127.0.0.1")
    assert read_back == {9: "0", 10: "1", 11: "2", 12: "3", 13: "0"}
    mbpoll("-t", "0", "-r", "3", "127.0.0.1", "1")
    assert mbpoll("-t", "0", "-r", "2", "-c", "3", "127.0.0.1") == {2: "0", 3: "1", 4: "0"}


def test_pymodbus(port):
    from pymodbus.client import ModbusTcpClient
    client = ModbusTcpClient("127.0.0.1", port=port, timeout=DEADLINE)
    assert client.connect()
    for i in range(40):
        assert not client.write_registers(20, [i, i + 1, i + 2], slave=1).isError()
        assert client.read_holding_registers(20, 3, slave=1).registers == [i, i + 1, i + 2]
    client.close()


def test_takt_polls_it(port, tmp_path):
    (tmp_path / "plant.yaml").write_text(f"""takt: 1
lines:
  - name: net
    transport: tcp
    host: 127.0.0.1
    tcp_port: {port}
    devices:
      - name: Board
        address: 1
        poll_period: 100ms
        response_timeout: 5s
        variables:
          - {{name: A, type: uint16, register: 0, read: 0x03}}
          - {{name: B, type: float, register: 40, read: 0x03}}
""")
    lines = takt("run", tmp_path / "plant.yaml", "--for", "2s", "--json").lines
    device = json.loads(lines[-1])["lines"][0]["devices"][0]
    assert device["counters"]["sent"] == device["counters"]["answered"] > 5, device


def requests(seed, count):
    """PDUs of every function with banks, half of them at an edge or damaged."""
    chance = random.Random(seed)
    for _ in range(count):
        function = chance.choice([1, 2, 3, 5, 6, 15, 16, 22, 23, 0, 9, 99, 128, 255])
        start, count = chance.choice([0, 7, 20, 120, 127, 128, 65535]), chance.choice([0, 1, 2, 9, 125, 2001])
        data = bytes(chance.randrange(256) for _ in range(2 * min(count, 20)))
        head = struct.pack(">BHH", function, start, count)
        if function in (5, 22):
            head = struct.pack(">BHH", function, start, chance.choice([0, 0xFF00, 1]))
            head += data[:2] * (function == 22)
        elif function in (15, 16):
            head += bytes([len(data)]) + data
        elif function == 23:
            head += struct.pack(">HHB", start, len(data) // 2, len(data)) + data
        if chance.random() < 0.2:
            head = head[:chance.randrange(1, len(head) + 1)]
        yield head


def test_its_bytes_are_those_of_the_desktop(tmp_path):
    desktop = endpoints.free_port()
    path = tmp_path / "desktop.yaml"
    path.write_text(
        slave(["listen: 127.0.0.1", f"tcp_port: {desktop}"], [],
              "banks: [{area: coil, items: [0..63]}, {area: discrete_input, items: [0..63]}, "
              "{area: input_register, items: [0..65535]}, {area: holding_register, items: [0..127]}]"))
    with on_network("an386", tmp_path) as (port, _), \
         start("serve", path) as server:
        endpoints.wait_listening(desktop, server)
        with connection(port) as board, connection(desktop) as computer:
            for i, pdu in enumerate(requests(7, 400)):
                answers = []
                for peer in (board, computer):
                    peer.sendall(adu(pdu, i))
                    head = take(peer, 6)
                    answers.append(head + take(peer, head[5]))
                assert answers[0] == answers[1], pdu.hex()
        server.interrupt()


def test_four_connections_at_once_and_no_fifth(port):
    until(lambda: only_one_is_open(port), "the others are closed")
    peers = [connection(port) for _ in range(CONNECTIONS)]

    def ask(number, peer):
        for i in range(100):
            peer.sendall(adu(struct.pack(">BHH", 6, 80 + number, i), i))
            assert take(peer, 12) == adu(struct.pack(">BHH", 6, 80 + number, i), i)
            values.append(read(peer, 80 + number, i) == i)

    values = []
    askers = [threading.Thread(target=ask, args=each) for each in enumerate(peers)]
    for asker in askers:
        asker.start()
    for asker in askers:
        asker.join()
    assert len(values) == 400 and all(values)
    with connection(port) as fifth:  # QEMU accepts it, and learns then that the board does not
        with pytest.raises((OSError, AssertionError)):
            read(fifth, 1)
    for peer in peers:
        read(peer, 1)
        peer.close()
    until(lambda: only_one_is_open(port), "the others are closed")
    assert counters(port)[1] == 1


def test_pipelined_requests(port):
    with connection(port) as peer:
        peer.sendall(b"".join(adu("03 0000 007d", i) for i in range(200)))
        for i in range(200):
            response = take(peer, 259)
            assert response[:9] == adu("03" + "fa" + "00" * 250, i)[:9]


def test_a_peer_that_does_not_read(port):
    requests = 1500  # more than QEMU and the board store of them and of their responses
    with connection(port) as deaf, connection(port) as other:
        deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 32768)
        deaf.sendall(b"".join(adu("03 0000 007d", i) for i in range(requests)))
        for i in range(100):
            read(other, 1, i)
        for i in range(requests):
            assert take(deaf, 259)[:9] == adu("03 fa" + "00" * 250, i)[:9]


def test_connections_one_after_another(port):
    before = counters(port)[0]
    for i in range(50):
        with connection(port) as peer:
            read(peer, 1, i)
    assert counters(port)[0] == before + 51
