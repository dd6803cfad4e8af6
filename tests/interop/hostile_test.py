"""Hostile and broken peers: the reaction of `takt serve` to invalid requests (docs/hostile-inputs.md). Each
case carries its number in the list of hostile inputs (1-27 over TCP, 35-47 on serial lines). "Others" are a
client of its own that goes on asking all the time: each of its requests is answered, in order, with the right
value.

Cases that need times or marks that a pseudo-terminal lacks are in src/serve/test/serial_slave_test.cpp and
src/line/test/line_parts_test.cpp: 37 (strict pauses), 40 (parity, framing, break), 43 (own echo), 47 (a pause
over a second)."""
import contextlib
import itertools
import os
import resource
import socket
import struct
import threading
import time

import pytest
import serial as pyserial

import endpoints
from frames import request
from program import DEADLINE, start, until

GOOD = "03 0007 0001"
ANSWER = "03 02 0007"


def adu(pdu, transaction=1, unit=1, protocol=0, length=None):
    body = bytes([unit]) + bytes.fromhex(pdu)
    return struct.pack(">HHH", transaction, protocol, len(body) if length is None else length) + body


def case(number, *values):
    return pytest.param(*values, id=f"{number}")


@contextlib.contextmanager
def serving(*options, host="127.0.0.1", **popen):
    """A blank device of ramps on TCP: its port and the running program."""
    port = endpoints.free_port()
    address = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
    with start("serve", "--listen", address, "--unit", 1, "--fill", "ramp", *options, **popen) as device:
        until(lambda: any("serving" in line for line in device.err), "that it serves")
        yield port, device
        if device.process.poll() is None:
            device.interrupt()


@pytest.fixture(scope="module")
def patient():
    """With its own limits."""
    with serving() as (port, _):
        yield port


@pytest.fixture(scope="module")
def strict():
    """With limits that a test can wait for."""
    with serving("--frame-timeout", "800ms", "--idle-timeout", "6s", "--write-timeout", "300ms") as (port, _):
        yield port


@contextlib.contextmanager
def client(port, host="127.0.0.1", **options):
    with socket.create_connection((host, port), timeout=DEADLINE, **options) as s:
        s.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
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
    """Whether the peer closes without having sent anything."""
    try:
        return s.recv(1) == b""
    except ConnectionError:
        return True


class Others(threading.Thread):
    """Asks without a pause, from its own thread and connection, until it is stopped."""

    def __init__(self, port, host="127.0.0.1"):
        super().__init__(daemon=True)
        self._port, self._host = port, host
        self._stop_requested, self.answered, self.trouble = threading.Event(), 0, None
        self.start()

    def run(self):
        try:
            with client(self._port, self._host) as s:
                while not self._stop_requested.is_set():
                    address = self.answered * 7 % 60000
                    assert ask(s, f"03 {address:04X} 0001",
                               self.answered % 65536) == hexed(f"03 02 {address:04X}")
                    self.answered += 1
                    time.sleep(0.001)
        except Exception as trouble:  # noqa: BLE001: reported by the test's own thread
            self.trouble = trouble

    def finish(self):
        self._stop_requested.set()
        self.join(DEADLINE)
        assert not self.is_alive(), "an answer is missing"
        assert self.trouble is None, f"after {self.answered} answers: {self.trouble!r}"


@contextlib.contextmanager
def others(port, host="127.0.0.1"):
    """They are answered before, during and after what is done within."""
    good = Others(port, host)
    until(lambda: good.answered or good.trouble, "that others are served")
    yield good
    before = good.answered
    until(lambda: good.answered > before or good.trouble, "that others are still served")
    good.finish()


# --- what is no Modbus: closed without a word

HTTP, TLS = b"GET / HTTP/1.1\r\nHost: x\r\n\r\n", bytes.fromhex("16 03 01 02 00 01 00 01 FC 03 03") + bytes(
    100)


@pytest.mark.parametrize("data", [
    case("1-protocol", adu(GOOD, protocol=1)),
    case("2-length-0", adu(GOOD, length=0)),
    case("3-length-1", adu(GOOD, length=1)),
    case("4-length-255",
         adu(GOOD, length=255)[:7]),
    case("5-length-65535",
         adu(GOOD, length=65535)[:7]),
    case("15-http", HTTP),
    case("15-tls", TLS),
    case("15-flood", b"\xff" * 1000),
    case("15-http-8", HTTP[:8]),
    case("15-tls-8", TLS[:8]),
    case("15-flood-8", b"\xff" * 8),
])
def test_other_protocols_are_closed_without_an_answer(patient, data):
    with others(patient), client(patient) as s:
        s.sendall(data)
        assert closes(s)


# --- requests that are refused: (request PDU, response PDU)

REFUSED = [
    case("6-hidden-write", "03 0007 0001 06 0010 BEEF", "83 03"),
    case("6-surplus", "03 0007 0001 00", "83 03"),
    case("6-after-a-write", "06 0010 BEEF 00", "86 03"),
    case("7-half", "03 00", "83 03"),
    case("7-nothing", "03", "83 03"),
    case("7-values", "10 0010 0001 02 00", "90 03"),
    case("7-coils", "0F 0000 0009 02 01", "8F 03"),
    case("7-mask", "16 0010 0000", "96 03"),
    case("7-both", "17 0000 0001 0000", "97 03"),
    case("16-none", "00", "80 01"),
    case("16-unknown", "63", "E3 01"),
    case("16-unknown-longer", "63 0000 0001", "E3 01"),
    case("16-exception", "83 0000 0001", "83 01"),
    case("16-greatest", "FF", "FF 01"),
    case("17-coils-0", "01 0000 0000", "81 03"),
    case("17-coils-2001", "01 0000 07D1", "81 03"),
    case("17-inputs-2001", "02 0000 07D1", "82 03"),
    case("17-registers-0", "03 0000 0000", "83 03"),
    case("17-registers-126", "03 0000 007E", "83 03"),
    case("17-registers-65535", "03 0000 FFFF", "83 03"),
    case("17-input-registers-126", "04 0000 007E", "84 03"),
    case("17-write-coils-0", "0F 0000 0000 00", "8F 03"),
    case("17-write-coils-1969", "0F 0000 07B1 F7" + "00" * 247, "8F 03"),
    case("17-write-registers-0", "10 0000 0000 00", "90 03"),
    case("17-write-registers-124", "10 0000 007C F8" + "00" * 247, "90 03"),
    case("17-both-reads-126", "17 0000 007E 0010 0001 02 BEEF", "97 03"),
    case("17-both-reads-0", "17 0000 0000 0010 0001 02 BEEF", "97 03"),
    case("17-both-writes-122", "17 0000 0001 0010 007A F4" + "00" * 243, "97 03"),
    case("18-registers", "03 FFFF 0002", "83 02"),
    case("18-coils", "01 FFFF 0002", "81 02"),
    case("18-inputs", "02 F831 07D0", "82 02"),
    case("18-write", "10 FFFF 0002 04 BEEF BEEF", "90 02"),
    case("18-write-coils", "0F FFFF 0002 01 03", "8F 02"),
    case("19-0001", "05 0010 0001", "85 03"),
    case("19-FFFF", "05 0010 FFFF", "85 03"),
    case("19-00FF", "05 0010 00FF", "85 03"),
    case("20-registers", "10 0010 0002 02 BEEF", "90 03"),
    case("20-coils", "0F 0010 0009 01 FF", "8F 03"),
    case("20-both", "17 0000 0001 0010 0002 02 BEEF", "97 03"),
    case("21-bad-read", "17 FFFF 0002 0010 0001 02 BEEF", "97 02"),
    case("21-bad-write", "17 0000 0001 FFFF 0002 04 BEEF BEEF", "97 02"),
    case("25-restart", "08 0001 0000", "88 01"),
    case("25-listen-only", "08 0004 0000", "88 01"),
]


@pytest.mark.parametrize("asked, answer", REFUSED)
def test_refused_requests_are_not_executed(patient, asked, answer):
    with client(patient) as s:
        assert ask(s, asked) == answer
        assert ask(s, "03 0010 0002") == "03 04 00 10 00 11", "nothing was written"
        assert ask(s, "01 0010 0008") == "01 01 AA"
        assert ask(s, GOOD) == hexed(ANSWER)


def test_refusals_delay_no_other_client_6_7_16_to_21_27(patient):
    """Ten thousand of them without a pause: no sleeping, and every one is answered in order."""
    rows = [row.values for row in REFUSED]
    with others(patient), client(patient) as s:
        for burst in range(0, 10_000, 100):
            numbered = [(n % 65536, *rows[n % len(rows)]) for n in range(burst, burst + 100)]
            s.sendall(b"".join(adu(asked, n) for n, asked, _ in numbered))
            for n, _, answer in numbered:
                assert receive(s, 9) == adu(answer, n)


# --- clients that are slow, silent, greedy or gone


def test_slow_and_silent_clients_are_closed_8_9(strict):
    """A byte now and then does not prolong a request's time; half a header and nothing at all end too.
    Meanwhile others are served."""
    with others(strict), client(strict) as slow, client(strict) as half, client(strict) as silent:
        half.sendall(adu(GOOD)[:4])
        for byte in adu(GOOD):
            with contextlib.suppress(ConnectionError):
                slow.sendall(bytes([byte]))
            time.sleep(0.12)  # 12 of them take longer than a request may
        assert closes(slow) and closes(half) and closes(silent)


def test_more_connections_than_allowed_10():
    with serving("--max-connections", 4) as (port, _), others(port), contextlib.ExitStack() as crowd:
        for _ in range(3):
            assert ask(crowd.enter_context(client(port)), GOOD) == hexed(ANSWER)
        for _ in range(20):
            with client(port) as refused:
                assert closes(refused)
        crowd.close()
        until(lambda: is_served(port), "a new connection is taken when another has gone")


def test_more_connections_from_one_address_than_allowed_10():
    with serving("--max-per-peer", 2, host="0.0.0.0") as (port, _), others(port), client(port) as mine:
        assert ask(mine, GOOD) == hexed(ANSWER)
        with client(port) as refused:
            assert closes(refused)
        with client(port, source_address=("127.0.0.2", 0)) as elsewhere:
            assert ask(elsewhere, GOOD) == hexed(ANSWER)


def is_served(port, host="127.0.0.1"):
    with contextlib.suppress(AssertionError, OSError), client(port, host) as s:
        return ask(s, GOOD) == hexed(ANSWER)
    return False


def test_no_descriptors_left_10():
    """Open connections continue, new ones are refused. Accepting resumes when descriptors are free. The
    summary counts it."""
    with serving("--json") as (port, device):
        # A build with sanitizers checks the type of an object with descriptors of its own: once for each
        # kind.
        assert is_served(port)
        resource.prlimit(device.process.pid, resource.RLIMIT_NOFILE, (24, 24))
        with others(port), contextlib.ExitStack() as crowd:
            for _ in range(60):
                with contextlib.suppress(OSError):
                    crowd.enter_context(client(port))
        until(lambda: is_served(port), "a new connection is taken")
    summary = device.interrupt().json["served"][0]["connections"]
    assert summary["refused"]["descriptors"] > 0 and summary["refused"]["connections"] == 0


def test_descriptors_above_1024_work_11():
    most = 1200
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    assert hard >= most, "the system must allow the test so many"
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    with serving("--max-connections", most, "--max-per-peer",
                 most) as (port, _), contextlib.ExitStack() as crowd:
        crowded = [crowd.enter_context(client(port)) for _ in range(1100)]
        for s in (crowded[0], crowded[1050], crowded[-1]):
            assert ask(s, GOOD) == hexed(ANSWER)


def test_fifty_requests_in_one_segment_are_answered_in_order_12(patient):
    with client(patient) as s:
        s.sendall(b"".join(adu(f"03 {n:04X} 0001", transaction=n) for n in range(50)))
        for n in range(50):
            assert receive(s, 11) == adu(f"03 02 {n:04X}", transaction=n)


def test_a_client_that_reads_late_gets_everything_in_order_12(patient):
    """More requests than the program and the system hold: the client is made to wait, and nothing is lost."""
    count = 20_000
    asked = b"".join(adu(f"03 {n:04X} 007D", transaction=n) for n in range(count))
    with others(patient), client(patient) as s:
        sender = threading.Thread(target=s.sendall, args=(asked, ), daemon=True)
        sender.start()
        time.sleep(0.3)
        for n in range(count):
            head = receive(s, 9)
            assert head == adu("03 FA", transaction=n, length=253)
            assert receive(s, 250) == struct.pack(">125H", *range(n, n + 125))
        sender.join(DEADLINE)


def test_a_client_that_never_reads_is_cut_off_13(strict):
    greedy = adu("03 0000 007D") * 1000
    with others(strict), client(strict) as rude:
        sent = 0
        with pytest.raises(ConnectionError):  # reset: its last bytes were not read any more
            while sent < 500_000_000:
                sent += rude.send(greedy)
        assert sent < 500_000_000, "it is slowed down, not buffered without end"


def test_byte_by_byte(patient):
    with client(patient) as s:
        for byte in adu(GOOD):
            s.sendall(bytes([byte]))
        assert receive(s, 11) == adu(ANSWER)


def test_a_reset_in_mid_frame_leaves_nothing_behind_14():

    def descriptors():
        return len(os.listdir(f"/proc/{device.process.pid}/fd"))

    with serving() as (port, device), others(port):
        before = descriptors()
        for _ in range(100):
            with client(port) as s:
                s.sendall(adu(GOOD)[:9])
                s.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        until(lambda: descriptors() <= before, "that their descriptors are closed")


def test_refusals_are_counted_and_reported_15():
    with serving("--json", "--max-connections", 2) as (port, device):
        for data in (HTTP, TLS, b"\xff" * 100):
            with client(port) as s:
                s.sendall(data)
                assert closes(s)
        until(lambda: is_served(port), "that it serves")
        summary = device.interrupt().json["served"][0]
    assert summary["connections"]["ended"]["bad_header"] == 3 and summary["dropped"]["bad_header"] == 3
    assert summary["answers"] == summary["requests"] >= 1 and summary["where"] == f"tcp://127.0.0.1:{port}"


def test_equal_transactions_of_two_clients_do_not_mix_26(patient):
    with client(patient) as one, client(patient) as two:
        one.sendall(b"".join(adu("03 0001 0001", transaction=n) for n in range(20)))
        two.sendall(b"".join(adu("03 0002 0001", transaction=n) for n in range(20)))
        for n in range(20):
            assert receive(two, 11) == adu("03 02 0002", transaction=n)
            assert receive(one, 11) == adu("03 02 0001", transaction=n)


def test_ipv6():
    with socket.socket(socket.AF_INET6) as probe:
        try:
            probe.bind(("::1", 0))
        except OSError:
            pytest.skip("this machine has no IPv6")
    with serving(host="::1") as (port, _), others(port, "::1"), client(port, "::1") as s:
        s.sendall(HTTP)
        assert closes(s)


# --- serial lines


@contextlib.contextmanager
def line(folder, framing):
    """A blank device on the far end, and the near end as an open port."""
    with endpoints.serial_pair(folder, record=False) as pair, \
            start("serve", "--port", f"{framing}://{pair.b}", "--unit", 1, "--fill", "ramp") as device:
        endpoints.wait_slave(pair.a, 1, framing, device)
        with pyserial.Serial(pair.a, timeout=0.1) as port:
            yield port
        device.interrupt()


@pytest.fixture(scope="module")
def rtu(tmp_path_factory):
    with line(tmp_path_factory.mktemp("rtu"), "rtu") as port:
        yield port


@pytest.fixture(scope="module")
def ascii_line(tmp_path_factory):
    with line(tmp_path_factory.mktemp("ascii"), "ascii") as port:
        yield port


def question(port, framing, asked, answer):
    """Asks until there is that answer and nothing but it: after the silence that ends what came before. A
    request that a busy machine hands over together with what came before it may be lost."""
    right = request(framing, 1, answer)

    def answered():
        port.reset_input_buffer()
        port.write(request(framing, 1, asked))
        return read(port, len(right), 2.0) == right

    until(answered, "an answer again")
    settle(port, framing)


_marks = itertools.cycle(range(1000, 60000))


def settle(port, framing):
    """Returns when no answer is on its way any more: a new question is answered after all others."""

    def settled():
        mark = next(_marks)
        right = request(framing, 1, f"03 02 {mark:04X}")
        port.write(request(framing, 1, f"03 {mark:04X} 0001"))
        received, end = b"", time.monotonic() + 2.0
        while not received.endswith(right) and time.monotonic() < end:
            received += port.read(1)
        return received.endswith(right)

    until(settled, "an answer to the last question")


def read(port, size, seconds=DEADLINE):
    """So many bytes, or what came within that time."""
    data, end = b"", time.monotonic() + seconds
    while len(data) < size and time.monotonic() < end:
        data += port.read(size - len(data))  # waits for 0.1 s
    return data


def silent(port, framing, data):
    settle(port, framing)
    port.write(data)
    assert port.read(1) == b"", "silence"
    question(port, framing, GOOD, ANSWER)


RTU = request("rtu", 1, GOOD)


@pytest.mark.parametrize("data", [
    case("35-bad-crc", RTU[:-1] + bytes([RTU[-1] ^ 1])),
    case("36-cut", RTU[:5]),
    case("36-one-byte", b"\x01"),
    case("36-three-bytes", b"\x00" * 3),
    case("36-a-megabyte", b"\xA5" * 1_000_000),
    case("36-too-long", request("rtu", 1, "03" + "00" * 300)),
    case("38-another-unit", request("rtu", 2, GOOD)),
    case("38-its-answer", request("rtu", 2, "03 02 0007")),
    case("38-both",
         request("rtu", 2, GOOD) + request("rtu", 2, "03 02 0007")),
    case("42-broadcast-read", request("rtu", 0, GOOD)),
    case("42-unit-248", request("rtu", 248, GOOD)),
    case("42-unit-255", request("rtu", 255, GOOD)),
])
def test_rtu_silence_and_recovery(rtu, data):
    silent(rtu, "rtu", data)


def test_rtu_beside_a_dead_unit_it_is_never_deaf_38(rtu):
    """A stray byte, half a frame or a request to a unit that is dead, each followed by a good request after a
    silence. (That the very first is answered is shown in src/serve/test, where nothing but the line takes
    time.)"""
    for n in range(60):
        rtu.write([b"\x00", RTU[:4], request("rtu", 2, GOOD)][n % 3])
        time.sleep(0.01)  # far more than t3.5
        question(rtu, "rtu", GOOD, ANSWER)


def test_rtu_glued_frames_39(rtu):
    """The first is served; the rest is dropped up to the next silence."""
    settle(rtu, "rtu")
    rtu.write(RTU + request("rtu", 1, "03 0001 0001"))
    answer = request("rtu", 1, ANSWER)
    assert read(rtu, len(answer)) == answer
    assert rtu.read(1) == b""
    question(rtu, "rtu", GOOD, ANSWER)


def test_rtu_noise_right_before_a_frame_39(rtu):
    rtu.write(b"\xFF" + RTU)
    read(rtu, len(request("rtu", 1, ANSWER)), 0.2)  # that one may be lost
    question(rtu, "rtu", GOOD, ANSWER)


@pytest.mark.parametrize("asked, answer", [
    case("41-surplus", "03 0007 0001 00", "83 03"),
    case("41-half", "03 00", "83 03"),
    case("41-values", "10 0010 0001 04 00", "90 03"),
    case("16-unknown", "63 0000", "E3 01"),
])
def test_rtu_a_good_checksum_and_a_wrong_length(rtu, asked, answer):
    question(rtu, "rtu", asked, answer)


def test_rtu_a_broadcast_is_done_and_not_answered_42(rtu):
    for value in (0x1234, 0x0064):
        silent(rtu, "rtu", request("rtu", 0, f"06 0064 {value:04X}"))
        question(rtu, "rtu", "03 0064 0001", f"03 02 {value:04X}")


ASCII = request("ascii", 1, GOOD)


@pytest.mark.parametrize("data", [
    case("45-odd", ASCII[:-3] + b"\r\n"),
    case("45-no-hex", b":01GG\r\n"),
    case("46-bad-lrc", ASCII[:-4] + b"00\r\n"),
    case("46-empty", b":\r\n"),
    case("46-short", b":01\r\n"),
    case("47-too-long", b":" + b"00" * 300 + b"\r\n"),
    case("47-a-megabyte", b":" + b"0" * 1_000_000),
    case("47-cr-alone", ASCII[:7] + b"\r"),
    case("47-cr-and-more", ASCII[:-1] + b"x"),
    case("38-another-unit", request("ascii", 2, GOOD)),
    case("42-broadcast-read", request("ascii", 0, GOOD)),
    case("47-line-ends", b"\r\n" * 50),
])
def test_ascii_silence_and_recovery(ascii_line, data):
    silent(ascii_line, "ascii", data)


def test_ascii_a_colon_begins_anew_44(ascii_line):
    settle(ascii_line, "ascii")
    ascii_line.write(ASCII[:9] + ASCII)
    assert read(ascii_line, len(request("ascii", 1, ANSWER))) == request("ascii", 1, ANSWER)


def test_ascii_takes_small_letters(ascii_line):
    settle(ascii_line, "ascii")
    ascii_line.write(ASCII.lower())
    assert read(ascii_line, len(request("ascii", 1, ANSWER))).upper() == request("ascii", 1, ANSWER)


def test_ascii_a_good_checksum_and_a_wrong_length_41(ascii_line):
    question(ascii_line, "ascii", "03 0007 0001 00", "83 03")
