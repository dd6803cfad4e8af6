"""Peers that mean no good, or know no better: what `takt serve` does with bytes that are no proper request."""
import contextlib
import socket
import struct

import pytest
import serial as pyserial

import places
from frames import request
from program import start, until

GOOD = "03 0007 0001"
ANSWER = "03 02 0007"


def adu(pdu, transaction=1, unit=1, protocol=0, length=None):
    body = bytes([unit]) + bytes.fromhex(pdu)
    return struct.pack(">HHH", transaction, protocol, len(body) if length is None else length) + body


@pytest.fixture
def port(blank_device):
    return blank_device("ramp")


@contextlib.contextmanager
def client(port):
    with socket.create_connection(("127.0.0.1", port), timeout=30) as s:
        yield s


def receive(s, size):
    data = b""
    while len(data) < size:
        more = s.recv(size - len(data))
        assert more, f"closed after {data.hex(' ')}"
        data += more
    return data


def ask(s, pdu, transaction=1):
    """The response PDU as hex text, after a look at its header."""
    s.sendall(adu(pdu, transaction))
    head = receive(s, 7)
    got, protocol, length, unit = struct.unpack(">HHHB", head)
    assert (got, protocol, unit) == (transaction, 0, 1)
    return receive(s, length - 1).hex(" ").upper()


def hexed(text):
    return bytes.fromhex(text).hex(" ").upper()


def closes(s):
    """Whether the peer closes without having said anything."""
    try:
        return s.recv(1) == b""
    except ConnectionError:
        return True


@pytest.mark.parametrize("data", [
    adu(GOOD, protocol=1), adu(GOOD, length=0), adu(GOOD, length=1), adu(GOOD, length=255)[:7], adu(GOOD, length=65535)[:7],
    b"GET / HTTP/1.1\r\nHost: x\r\n\r\n", bytes.fromhex("16 03 01 02 00 01 00 01 FC 03 03") + bytes(100), b"\xff" * 1000,
], ids=["protocol-1", "length-0", "length-1", "length-255", "length-65535", "http", "tls-hello", "flood"])
def test_what_is_no_modbus_is_closed_without_an_answer(port, data):
    with client(port) as other, client(port) as s:
        s.sendall(data)
        assert closes(s)
        assert ask(other, GOOD) == hexed(ANSWER), "others are served"


# (request PDU, response PDU): requirements, sections 8 and 9.
REFUSED = [
    ("03 0007 0001 0102", "83 03"), ("03 00", "83 03"), ("03", "83 03"), ("10 0000 0001 02 00", "90 03"),
    ("00", "80 01"), ("63", "E3 01"), ("83 0000 0001", "83 01"), ("FF", "FF 01"),
    ("01 0000 0000", "81 03"), ("01 0000 07D1", "81 03"), ("02 0000 07D1", "82 03"), ("03 0000 0000", "83 03"),
    ("03 0000 007E", "83 03"), ("04 0000 007E", "84 03"), ("0F 0000 0000 00", "8F 03"), ("10 0000 0000 00", "90 03"),
    ("10 0000 0002 02 0001", "90 03"), ("0F 0000 0009 01 FF", "8F 03"),
    ("17 0000 007E 0000 0001 02 0001", "97 03"), ("17 0000 0000 0000 0001 02 0001", "97 03"),
    ("17 0000 0001 0000 0002 02 0001", "97 03"),
    ("05 0000 0001", "85 03"), ("05 0000 FFFF", "85 03"),
    ("03 FFFF 0002", "83 02"), ("01 FFFF 0002", "81 02"), ("10 FFFF 0002 04 0001 0002", "90 02"),
    ("17 FFFF 0002 0000 0001 02 0001", "97 02"), ("17 0000 0001 FFFF 0002 04 0001 0002", "97 02"),
]


@pytest.mark.parametrize("asked, answer", REFUSED, ids=[a.replace(" ", "-") for a, _ in REFUSED])
def test_what_is_refused(port, asked, answer):
    with client(port) as s:
        assert ask(s, asked) == answer
        assert ask(s, GOOD) == hexed(ANSWER)


def test_a_refused_exchange_writes_nothing(port):
    with client(port) as s:
        assert ask(s, "17 FFFF 0002 0010 0001 02 BEEF") == "97 02"
        assert ask(s, "03 0010 0001") == "03 02 00 10"


def test_fifty_requests_in_one_segment_are_answered_in_order(port):
    with client(port) as s:
        s.sendall(b"".join(adu(f"03 {n:04X} 0001", transaction=n) for n in range(50)))
        for n in range(50):
            assert receive(s, 11) == adu(f"03 02 {n:04X}", transaction=n)


def test_byte_by_byte(port):
    with client(port) as s:
        s.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for byte in adu(GOOD):
            s.sendall(bytes([byte]))
        assert receive(s, 11) == adu(ANSWER)


def test_equal_transactions_of_two_clients_do_not_mix(port):
    with client(port) as one, client(port) as two:
        one.sendall(b"".join(adu("03 0001 0001", transaction=n) for n in range(20)))
        two.sendall(b"".join(adu("03 0002 0001", transaction=n) for n in range(20)))
        for n in range(20):
            assert receive(two, 11) == adu("03 02 0002", transaction=n)
            assert receive(one, 11) == adu("03 02 0001", transaction=n)


def test_a_client_that_never_reads_holds_up_nobody(port):
    greedy = adu("03 0000 007D") * 1000
    with client(port) as rude, client(port) as other:
        rude.setblocking(False)
        sent = 0
        with contextlib.suppress(BlockingIOError, ConnectionError):
            while sent < 200_000_000:
                sent += rude.send(greedy)
        assert sent < 200_000_000, "it is slowed down or closed, not buffered without end"
        assert ask(other, GOOD) == hexed(ANSWER)


def test_a_reset_in_mid_frame(port):
    for _ in range(20):
        with client(port) as s:
            s.sendall(adu(GOOD)[:9])
            s.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    with client(port) as s:
        assert ask(s, GOOD) == hexed(ANSWER)


def test_more_connections_than_it_takes(port):
    """Those that are there go on, whatever becomes of the others; when they go, new ones are taken again."""
    with contextlib.ExitStack() as crowd:
        first = crowd.enter_context(client(port))
        assert ask(first, GOOD) == hexed(ANSWER)
        for _ in range(400):
            with contextlib.suppress(OSError):
                crowd.enter_context(client(port))
        assert ask(first, GOOD) == hexed(ANSWER)

    def served():
        with contextlib.suppress(AssertionError, OSError), client(port) as s:
            return ask(s, GOOD) == hexed(ANSWER)
        return False
    until(served, "a new connection is served")


# --- serial lines

@contextlib.contextmanager
def line(pair, framing):
    """A blank device on the far end, and the near end as an open port."""
    with start("serve", "--port", f"{framing}://{pair.b}", "--unit", 1, "--fill", "ramp") as device:
        places.wait_slave(pair.a, 1, framing, device)
        with pyserial.Serial(pair.a, timeout=0.2) as port:
            yield port
        device.interrupt()


def recovers(port, framing):
    """Asks until there is the right answer and nothing but it: after the silence that ends what came before."""
    answer = request(framing, 1, ANSWER)

    def answered():
        port.write(request(framing, 1, GOOD))
        return port.read(len(answer)) == answer
    until(answered, "an answer again")


RTU = request("rtu", 1, GOOD)


@pytest.mark.parametrize("data", [
    RTU[:-1] + bytes([RTU[-1] ^ 1]), RTU[:5], b"\x01", b"\x00" * 3, b"\xA5" * 1_000_000, request("rtu", 2, GOOD),
    request("rtu", 2, "03 02 0007"), request("rtu", 0, GOOD), request("rtu", 248, GOOD), request("rtu", 1, "03" + "00" * 300),
], ids=["bad-crc", "cut", "one-byte", "zeros", "a-megabyte", "another-unit", "its-answer", "broadcast-read", "unit-248",
        "too-long"])
def test_rtu_silence_and_recovery(pair, data):
    with line(pair, "rtu") as port:
        before = len(pair.answered())
        port.write(data)
        assert port.read(1) == b"", "silence"
        assert len(pair.answered()) == before
        recovers(port, "rtu")


ASCII = request("ascii", 1, GOOD)


@pytest.mark.parametrize("data", [
    ASCII[:-4] + b"00\r\n", ASCII[:-3] + b"\r\n", b":01GG\r\n", b":\r\n", b":01\r\n",
    b":" + b"00" * 300 + b"\r\n", b":" + b"0" * 1_000_000, ASCII[:7] + b"\r", request("ascii", 2, GOOD), b"\r\n" * 50,
], ids=["bad-lrc", "odd-digits", "no-hex", "empty", "short", "too-long", "a-megabyte", "cr-alone", "another-unit", "line-ends"])
def test_ascii_silence_and_recovery(pair, data):
    with line(pair, "ascii") as port:
        port.write(data)
        assert port.read(1) == b"", "silence"
        recovers(port, "ascii")


def test_ascii_a_colon_begins_anew(pair):
    with line(pair, "ascii") as port:
        port.write(ASCII[:9] + ASCII)
        assert port.read(len(request("ascii", 1, ANSWER))) == request("ascii", 1, ANSWER)


def test_ascii_takes_small_letters(pair):
    with line(pair, "ascii") as port:
        port.write(ASCII.lower())
        assert port.read(len(request("ascii", 1, ANSWER))).upper() == request("ascii", 1, ANSWER)
