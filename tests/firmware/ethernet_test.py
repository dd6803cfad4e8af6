"""The TCP slave on emulated boards, with frames made by hand: what a network and its peers can do."""
import json
import os
import socket
import struct
import time

import pytest

from ethernet import ACK, FIN, RST, SYN, Peer, Wire, adu, checksum, running

CONNECTIONS = 4  # of the image
COUNTERS = ["stack", "accepted", "refused", "closed", "unsent", "connections", "pool", "heap", "most_heap"]
TIMES = int(os.environ.get("TAKT_NETWORK_TIMES", 1))  # tools/firmware --soak
STACK_LIMIT = 2048  # tools/firmware


@pytest.fixture(scope="module", name="wire")
def wire_of_a_board(tmp_path_factory, results):
    assert results  # other boards run beside this one
    wire = Wire()
    with running("an386", "tcp", tmp_path_factory.mktemp("board"), *wire.options()):
        wire.ask_for_mac()
        yield wire


def counters(peer):
    values = peer.ask(f"04 0000 {len(COUNTERS):04x}")
    return dict(zip(COUNTERS, struct.unpack(f">{len(COUNTERS)}H", values[2:])))


@pytest.fixture(name="other")
def other_of(wire):
    """A peer that must be served all the time; without leaks behind it."""
    wire.faults = (0, 0, 0)
    peer = Peer(wire).open()
    yield peer
    assert peer.ask("03 0001 0001")[:2] == b"\x03\x02"
    for each in list(wire.peers.values()):
        if each is not peer:
            each.abort()
    wire.pump(0.02)
    left = counters(peer)
    assert left["connections"] == 1 and left["pool"] == 0 and left["heap"] < 1500, left
    assert left["stack"] < STACK_LIMIT
    peer.abort()


def test_ping(wire):
    echo = struct.pack(">BBHHH", 8, 0, 0, 7, 1) + b"x" * 400
    wire.send_ip(1, echo[:2] + struct.pack(">H", checksum(echo)) + echo[4:])
    reply = b"x" * 400
    wire.until(lambda: any(frame[34:35] == b"\0" and frame.endswith(reply) for frame in wire.raw), "a reply")


@pytest.mark.parametrize("seed", range(3 * TIMES))
def test_loss_duplicates_and_reordering(wire, other, seed):
    """No byte is lost, doubled or out of order: every response is the one of its request."""
    wire.random.seed(seed)
    peers = [Peer(wire).open() for _ in range(CONNECTIONS - 1)]
    wire.faults = (0.04, 0.08, 0.08)
    expected = {}
    for number, peer in enumerate(peers):
        requests, expected[peer] = b"", b""
        for i in range(40):
            register = 20 * number + i % 10
            write = struct.pack(">BHH", 6, register, 1000 * number + i)
            read = struct.pack(">BHH", 3, register, 1)
            requests += adu(write, 2 * i) + adu(read, 2 * i + 1)
            expected[peer] += adu(write, 2 * i) + adu(struct.pack(">BBH", 3, 2, 1000 * number + i), 2 * i + 1)
        peer.send(requests)
    for peer in peers:
        assert peer.take(len(expected[peer])) == expected[peer]
    wire.faults = (0, 0, 0)
    wire.delayed.clear()
    assert other.ask("03 0000 0001")[0] == 3


def test_a_response_is_sent_again(wire, other):
    peer = Peer(wire).open()
    peer.mute = True
    peer.send(adu("06 0010 1234"))
    wire.pump(0.1)
    peer.mute = False
    assert peer.take(12) == adu("06 0010 1234")
    assert other.ask("03 0010 0001") == bytes.fromhex("03 02 1234")


def test_a_peer_that_does_not_read(wire, other):
    """The window is closed: the requests wait, others are served, and nothing is lost when it opens."""
    peer = Peer(wire).open()
    peer.window = 0
    requests = b"".join(adu("03 0000 007d", i) for i in range(300))
    peer.send(requests)
    wire.until(lambda: peer.board_window < 12, "the board reads no more")
    for i in range(20):
        assert other.ask("03 0001 0001", i)[0] == 3
    held = len(requests) - len(peer.out)
    assert held < 5000
    peer.window = 8192
    peer.acknowledge()
    for i in range(300):
        assert peer.take(259)[:2] == struct.pack(">H", i)


def test_a_fifth_connection_is_refused(wire, other):
    peers = [Peer(wire).open() for _ in range(CONNECTIONS - 1)]
    fifth = Peer(wire)
    wire.until(lambda: fifth.reset, "a reset")
    for peer in [other, *peers]:
        assert peer.ask("03 0001 0001")[0] == 3
    peers[0].close()
    assert Peer(wire).open().ask("03 0001 0001")[0] == 3


def test_many_connections_leave_nothing(wire, other):
    before = counters(other)
    for i in range(200 * TIMES):
        peer = Peer(wire).open()
        if i % 2:
            peer.ask("03 0001 0001")
        if i % 4 < 2:
            peer.close()
        else:
            peer.abort()
    wire.pump(0.05)
    after = counters(other)
    assert (after["accepted"] - before["accepted"]) % 65536 == 200 * TIMES
    assert after["refused"] == before["refused"]
    assert after["connections"] <= 1 + 2 * CONNECTIONS, after  # TIME-WAIT included


def half_open(wire, number):
    for i in range(number):
        wire.segment(30_000 + i, 7, 0, SYN)


def test_a_flood_of_handshakes(wire, other):
    third = Peer(wire).open()
    half_open(wire, 300)
    for i in range(30):
        half_open(wire, 20)
        assert other.ask("03 0001 0001", i)[0] == 3 and third.ask("03 0002 0001", i)[0] == 3
    # The handshakes that the board has answered end here by resets, instead of after 20 s.
    wire.pump(0.1)
    for segment in wire.raw:
        port, flags = struct.unpack(">H", segment[2:4])[0], segment[13]
        if flags == SYN | ACK:
            wire.segment(port, 8, struct.unpack(">I", segment[4:8])[0] + 1, RST)
    wire.raw.clear()
    assert Peer(wire).open().ask("03 0001 0001")[0] == 3


if TIMES > 1:  # it takes 20 s

    def test_half_open_peers_are_forgotten(wire, other):
        half_open(wire, 50)
        start = time.monotonic()
        peer = Peer(wire).open()
        assert 5 < time.monotonic() - start < 60
        assert peer.ask("03 0001 0001")[0] == 3 and other.ask("03 0001 0001")[0] == 3


def closed_without_response(peer):
    peer.wire.until(lambda: peer.ended or peer.reset, "the board closes")
    return peer.received == b""


# hostile-inputs.md: 1, 2, 3, 4, 5, 15
@pytest.mark.parametrize("characters", [
    "0001 0001 0006 01 03 0000 0001", "0001 ffff 0006 01 03 0000 0001", "0001 0000 0000 01",
    "0001 0000 0001 01",
    "0001 0000 00ff 01", "0001 0000 ffff 01", "ff" * 100, b"GET / HTTP/1.1\r\nHost: board\r\n\r\n".hex(),
    "160301020001000001fc0303" + "55" * 200
])
def test_no_modbus_ends_the_connection(wire, other, characters):
    peer = Peer(wire).open()
    peer.send(bytes.fromhex(characters))
    assert closed_without_response(peer)
    assert other.ask("03 0001 0001")[0] == 3


# hostile-inputs.md: 6, 7, 16 to 25
@pytest.mark.parametrize("request_, response", [
    ("03 0000 0001 00 02", "83 03"),
    ("03 0000 0001 0001 0000 0006 01 06 0000 4444", "83 03"),
    ("03 0000 00", "83 03"),
    ("10 0000", "90 03"),
    ("00", "80 01"),
    ("41 00", "c1 01"),
    ("83 0000 0001", "83 01"),
    ("ff", "ff 01"),
    ("03 0000 0000", "83 03"),
    ("03 0000 007e", "83 03"),
    ("01 0000 07d1", "81 03"),
    ("0f 0000 07b1 f7" + "00" * 247, "8f 03"),
    ("10 0000 007c f8" + "00" * 247, "90 03"),
    ("17 0000 007e 0000 0001 02 4444", "97 03"),
    ("17 0000 0001 0000 007a f4" + "44" * 243, "97 03"),
    ("03 ffff 0002", "83 02"),
    ("03 0080 0001", "83 02"),
    ("10 007f 0002 04 4444 4444", "90 02"),
    ("05 0000 1234", "85 03"),
    ("0f 0000 0009 01 ff", "8f 03"),
    ("10 0000 0002 02 4444", "90 03"),
    ("17 0080 0001 0000 0001 02 4444", "97 02"),
    ("14 07 05 0001 0000 0001", "94 01"),
    ("15 09 06 0001 fffe 0001 4444", "95 01"),
    ("18 0000", "98 01"),
    ("2b 0e 01 00", "ab 01"),
    ("08 0001 0000", "88 01"),
    ("08 0004 0000", "88 01"),
])
def test_wrong_requests(wire, other, request_, response):
    """Each gets its exception, and none is executed."""
    assert other.ask("06 0000 0a0b") == bytes.fromhex("06 0000 0a0b")
    assert other.ask(request_, 77) == bytes.fromhex(response)
    assert other.ask("03 0000 0001") == bytes.fromhex("03 02 0a0b")


def test_slow_peers(wire, other):
    """8, 9: one character each 400 ms, half a header and silence: the deadline of the frame ends both."""
    slow, silent = Peer(wire).open(), Peer(wire).open()
    silent.send(bytes.fromhex("000100"))
    for character in adu("03 0000 0001"):
        if slow.ended or slow.reset:
            break
        slow.send(bytes([character]))
        wire.pump(0.4)
        assert other.ask("03 0001 0001")[0] == 3
    assert closed_without_response(slow) and closed_without_response(silent)


def test_fifty_requests_in_one_segment(wire, other):
    """12, 26: in their order, with the transaction numbers of another client."""
    peer = Peer(wire).open()
    peer.send(b"".join(adu(f"03 {i:04x} 0001", i) for i in range(50)))
    assert other.ask("03 0001 0001", 7)[0] == 3
    responses = peer.take(50 * 11)
    transactions = [struct.unpack(">H", responses[i:i + 2])[0] for i in range(0, len(responses), 11)]
    assert transactions == list(range(50))


def test_a_reset_in_the_middle_of_a_frame(wire, other):
    """14"""
    for _ in range(20):
        peer = Peer(wire).open()
        peer.send(adu("03 0000 0001")[:9])
        wire.pump(0.005)
        peer.abort()
    assert other.ask("03 0001 0001")[0] == 3


def test_malformed_requests_without_end(wire, other):
    """27, and frames that are no IP, broken IP, broken TCP"""
    peer = Peer(wire).open()
    for i in range(150 * TIMES):
        peer.send(adu("03 0000 0000", i % 65536) + adu("55", i % 65536))
        noise = wire.random.randbytes(wire.random.randrange(1, 1486))
        wire.send(wire.random.choice([b"\x08\x00", b"\x08\x06", b"\x86\xdd", b"\0\x10"]), noise)
        wire.send_ip(wire.random.choice([1, 2, 6, 17, 255]), noise[:1400])
        if i % 10 == 0:
            assert other.ask("03 0001 0001", i % 65536)[0] == 3
    responses = peer.take(150 * TIMES * 18)
    assert responses[7:9] == b"\x83\x03" and len(responses) == 150 * TIMES * 18


def cable_off_and_on(folder):
    wire = Wire()
    qmp = folder / "qmp"
    with running("an385", "tcp", folder, *wire.options(), "-qmp", f"unix:{qmp},server=on,wait=off"):
        wire.ask_for_mac()
        with socket.socket(socket.AF_UNIX) as control:
            control.connect(str(qmp))
            lines = control.makefile("rw")
            lines.readline()

            def execute(what, **arguments):
                lines.write(json.dumps({"execute": what, "arguments": arguments}) + "\n")
                lines.flush()
                while "return" not in (answer := json.loads(lines.readline())):
                    assert "error" not in answer, answer

            execute("qmp_capabilities")
            peer = Peer(wire).open()
            for i in range(3):
                assert peer.ask(f"06 0005 {i:04x}")[0] == 6
                execute("set_link", name="n0", up=False)
                peer.send(adu("03 0005 0001", i))
                wire.pump(0.3)
                assert peer.received == b""
                execute("set_link", name="n0", up=True)
                assert peer.take(11) == adu(f"03 02 {i:04x}", i)


def served(wire):
    peer = Peer(wire).open()
    if not peer.reset:
        peer.send(adu("03 0001 0001"))
        wire.until(lambda: peer.reset or len(peer.received) == 11, "a response or a reset")
    accepted = not peer.reset
    if accepted:
        peer.close()
    peer.forget()
    return accepted


def dead_and_idle_peers(folder):
    """The image has a keep-alive of 1 s and an idle deadline of 4 s."""
    wire = Wire()
    with running("an385", "test_tcp", folder, *wire.options()):
        wire.ask_for_mac()
        start = time.monotonic()
        dead, idle, deaf = [Peer(wire).open() for _ in range(2)], Peer(wire).open(), Peer(wire).open()
        for peer in dead:
            peer.mute = True
        deaf.window = 0
        deaf.send(b"".join(adu("03 0000 007d", i) for i in range(200)))
        assert not served(wire)
        wire.until(lambda: served(wire), "the end of a dead peer")
        for peer in dead:
            assert len(peer.ignored) > 1 and peer.ignored[-1] & RST and not peer.ignored[-1] & FIN
        wire.until(lambda: idle.ended and deaf.reset, "the idle deadline")
        assert time.monotonic() - start > 3.5, "they acknowledge the probes"
        idle.close()
        assert counters(Peer(wire).open())["pool"] == 0


CASES = {"dead and idle peers": (dead_and_idle_peers,), "cable off and on": (cable_off_and_on,)}


@pytest.mark.parametrize("case", CASES)
def test_a_board_of_its_own(results, case):
    results[case].result()
