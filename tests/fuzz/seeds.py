#!/usr/bin/python3
"""Writes the first inputs of the fuzz targets into tests/fuzz/corpus: golden frames (docs/specification.md,
section 8) as the scripts of slave.hpp and master.hpp take them, the examples' projects and tables. Run it
again when a target's script changes."""
import pathlib
import random
import struct
import sys

FUZZ = pathlib.Path(__file__).resolve().parent
EXAMPLES = FUZZ.parent.parent / "examples"
sys.path.insert(0, str(FUZZ.parent))
# Request and response of every function.
PDUS = [
    ("01 0013 0013", "01 03 CD6B05"),
    ("02 00C4 0016", "02 03 ACDB35"),
    ("03 006B 0003", "03 06 022B00000064"),
    ("04 0008 0001", "04 02 000A"),
    ("05 00AC FF00", "05 00AC FF00"),
    ("06 0001 0003", "06 0001 0003"),
    ("07", "07 6D"),
    ("08 0000 A537", "08 0000 A537"),
    ("0B", "0B FFFF 0108"),
    ("0C", "0C 08 0000 0108 0121 2000"),
    ("0F 0013 000A 02 CD01", "0F 0013 000A"),
    ("10 0003 0002 04 000A0102", "10 0003 0002"),
    ("11", "11 03 01FF41"),
    ("14 0E 06 0004 0001 0002 06 0003 0009 0002", "14 0C 05 06 0DFE0020 05 06 33CD0040"),
    ("15 0D 06 0004 0007 0003 06AF04BE100D", "15 0D 06 0004 0007 0003 06AF04BE100D"),
    ("16 0004 00F2 0025", "16 0004 00F2 0025"),
    ("17 0003 0006 000E 0003 06 00FF00FF00FF", "17 0C 00FE0ACD00010003000D00FF"),
    ("18 04DE", "18 0006 0002 01B81284"),
    ("2B 0E 01 00", "2B 0E 01 01 00 00 02 00 01 41 01 01 42"),
    ("2B 0D 0000", "AB 01"),
    ("03 0003 0002", "83 02"),
    ("63 01", "E3 01"),
]


def write(target, name, data):
    folder = FUZZ / "corpus" / target
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(data)


def frame_steps(what):
    """One step a request: what, length - 1, PDU; then a pause for the answer."""
    for request, _ in PDUS:
        pdu = bytes.fromhex(request)
        yield bytes([what, len(pdu) - 1]) + pdu + bytes([5, 0x20, 0])


def seed_slaves():
    one, two, broadcast = 2 | 8, 2 | 16, 2  # a frame to unit 1, 2, 0
    for target in ("rtu_slave", "ascii_slave"):
        for choice in (0, 3, 31):
            write(target, f"golden-{choice}", bytes([choice]) + b"".join(frame_steps(one)))
        write(target, "units", b"\0" + b"".join(b"".join(frame_steps(unit)) for unit in (two, broadcast)))
        write(
            target, "pieces", b"\0" +
            b"".join(step[:2 + step[1] + 1] + b"\x03" + step[-3:] for step in frame_steps(one | 0x40)))
        write(target, "echo", b"\0" + b"".join(step + b"\6" for step in frame_steps(one)))
    for choice, name in ((0, "mbap"), (0xC1, "rtu"), (0xC0, "ascii")):
        write("tcp_slave", f"golden-{name}", bytes([choice]) + b"".join(frame_steps(1 | 8)))
        write(
            "tcp_slave", f"many-{name}",
            bytes([choice]) + b"\x06" + b"".join(
                bytes([4 | 8, len(bytes.fromhex(r)) - 1]) + bytes.fromhex(r) + b"\x27"
                for r, _ in PDUS
                if len(r) < 20) + b"\x06")
    write("tcp_slave", "http", b"\0" + b"\0\x0fGET / HTTP/1.1\r\n")
    write("tcp_slave", "half", bytes.fromhex("00 00 03 0001 0000 05 20"))


def seed_masters():
    for target in ("rtu_master", "ascii_master", "tcp_master"):
        steps = []
        for request, response in PDUS:
            asked, answered = bytes.fromhex(request), bytes.fromhex(response)
            steps.append(
                bytes([1 | 8, 50, len(asked) - 1]) + asked + bytes([5, 4, 0, 3, len(answered)]) + answered +
                bytes([5, 4, 0]))
        for choice in (0, 1, 2, 0x21):
            write(target, f"golden-{choice}", bytes([choice]) + b"".join(steps))
        write(target, "late", b"\0" + b"".join(step[:-3] + bytes([5, 0x80, 0]) for step in steps))
        write(target, "silent", b"\0" + bytes([0x81 | 8, 20, 3, 9, 5, 0x40, 0]) * 8)


def seed_texts():
    for request, response in PDUS:
        asked, answered = bytes.fromhex(request), bytes.fromhex(response)
        write("pdu", request.split()[0] + "-" + str(len(asked)), bytes([len(asked)]) + asked + answered)
    for path in EXAMPLES.glob("*.yaml"):
        table = EXAMPLES / (path.stem + ".csv")
        write("project", path.stem,
              path.read_bytes() + (b"\0" + table.read_bytes() if table.exists() else b""))
    for path in EXAMPLES.glob("*.csv"):
        for choice in (0, 0x84):
            write("csv", f"{path.stem}-{choice}", bytes([choice]) + path.read_bytes())


def seed_instruments():
    """A pause in which it is asked, then what it says."""

    def said(*answers):
        return b"".join(b"\x80\x03\xe8" + bytes([len(a)]) + a for a in answers)

    for talks in (0, 1):
        for template, answers in ((b"{weight} kg", (b"+  12.50 kg\r", b"-1e3 kg\r", b"12 lb\r",
                                                    b"\r\r7 kg\r8 k")), (b"ST,{a:hex},{*};{b:text}",
                                                                         (b"ST,1F,xx;abc \r", b"ST,,;\r"))):
            write("instrument", f"text-{talks}-{template[0]}",
                  bytes([talks, len(template)]) + template + said(*answers))
        # A start that is confirmed, a measurement, commands: confirmed, refused, interrupted by a restart or
        # a new link.
        template, wrote = b"{w} kg", b"\x7f\0" + said(b"OK\r", b"T5\r")
        steps = said(b"OK\r", b"1 kg\r") + wrote + b"\x7f\1" + said(b"E7\r") + b"\x7f\0" + \
            said(b"READY\r", b"OK\r") + wrote + \
            b"\x7f\1\x7e" + said(b"OK\r", b"OK\r", b"T5\r", b"2 kg\r") + said(b"") * 30
        write("instrument", f"commands-{talks}", bytes([16 | talks, len(template)]) + template + steps)
        for checksum in range(4):
            body = bytes.fromhex("02 41480000 01")
            ends = (b"\0\0", b"\0" + bytes([sum(body) % 256]), b"\0\x0a", b"\x12\x34")
            write("instrument", f"binary-{talks}-{checksum}",
                  bytes([2 | talks | checksum << 2]) + said(body + ends[checksum], body, b"\2" * 20))


def seed_rules():
    """Arbitrary bytes: every one is a choice. The first is the number of rules."""
    for seed in range(24):
        write("rules", f"random-{seed}", bytes([seed]) + random.Random(seed).randbytes(700))


def seed_captures():
    """The size of the pieces, then a file: a connection with cut, repeated and missing segments; frames of a
    serial line."""
    from captures import LINKS, Capture, Connection, adu
    from frames import pcap, request
    capture = Capture()
    connection = Connection(capture)
    for number, (asked, answered) in enumerate(PDUS[:12]):
        question, answer = adu(number, 1, asked), adu(number, 1, answered)
        connection.request(number * 100, question[:number])
        connection.request(number * 100 + 1, question[number:], captured=number != 5)
        connection.respond(number * 100 + 50, answer)
        if number % 4 == 0:
            connection.again(number * 100 + 60, True, answer)
    connection.close(9999)
    for number, link in enumerate(LINKS):
        write("capture", f"pcap-{link}",
              bytes([number]) + capture.pcap(link, number % 2 == 0, "<>"[number % 2]))
    write("capture", "pcapng", bytes([3]) + capture.pcapng("ethernet", 6, "<", 3))
    write("capture", "pcapng-big", bytes([255]) + capture.pcapng("cooked", 9, ">"))
    frames = [request(framing, 1, pdu) for framing in ("rtu", "ascii") for pair in PDUS[:8] for pdu in pair]
    write("capture", "serial", bytes([9]) + pcap(147, frames))
    write(
        "capture", "rtac",
        bytes([9]) +
        pcap(250, [struct.pack(">IIBBH", 0, 0, 1 + n % 2, 0, 0) + f for n, f in enumerate(frames)]))


def seed_listen():
    """Exchanges, 5 ms apart; a damaged frame; a tick."""
    from frames import request
    for choice, framing in ((0, "rtu"), (2, "rtu"), (8, "rtu"), (1, "ascii")):
        steps = [
            struct.pack(">HB", 100, len(frame)) + frame for pair in PDUS
            for pdu in pair for frame in [request(framing, 1, pdu)] if len(frame) < 255
        ]
        damaged = request(framing, 1, PDUS[2][1])[:-3]
        write(
            "listen", f"golden-{choice}",
            bytes([choice]) + b"".join(steps) + struct.pack(">HB", 100, len(damaged)) + damaged +
            b"\x90\0\xff")
        polls = [
            struct.pack(">HB", 2000, len(frame)) + frame for _ in range(12) for pdu in PDUS[2]
            for frame in [request(framing, 7, pdu)]
        ]
        write("listen", f"polls-{choice}", bytes([choice]) + b"".join(polls))


def seed_http():
    """Who it is, then pieces with their length: requests of a page, of a proxy, and what is refused."""
    host = "Host: localhost\r\n"
    token, marked = "Authorization: Bearer token\r\n", "X-Takt: 1\r\nContent-Type: application/json\r\n"
    requests = {
        "page":
            f"GET / HTTP/1.1\r\n{host}Accept-Encoding: gzip\r\n\r\n" * 2,
        "echo":
            f"GET /api/v1/echo?a=%D0%B4+b&token=token&lang=uk HTTP/1.1\r\n{host}\r\n",
        "proxy":
            f"GET /api/v1/echo HTTP/1.0\r\n{host}{token}X-Forwarded-For: 1.2.3.4, [::1]:5\r\n"
            "X-Forwarded-For: 10.0.0.1\r\nX-Forwarded-Proto: https\r\nConnection: keep-alive\r\n\r\n",
        "post":
            f"POST /api/v1/echo HTTP/1.1\r\n{host}{token}{marked}Expect: 100-continue\r\n"
            "Content-Length: 4\r\n\r\n{}{}" + f"HEAD /none HTTP/1.1\r\n{host}\r\n",
        "stranger":
            f"PUT /api/v1/echo HTTP/1.1\r\nHost: evil.example\r\n{marked}Content-Length: 9\r\n\r\n{{}}",
        "strict":
            f"GET /% HTTP/1.1\r\n{host}Transfer-Encoding: chunked\r\n\r\n",
    }
    for name, text in requests.items():
        for peer, size in ((0, 255), (1, 7)):
            data = text.encode()
            pieces = [data[at:at + size] for at in range(0, len(data), size)]
            write(
                "http", f"{name}-{size}",
                bytes([peer]) + b"".join(bytes([len(piece) - 1]) + piece for piece in pieces) + b"\xff\xff\0")


seed_captures()
seed_listen()
seed_http()
seed_slaves()
seed_masters()
seed_texts()
seed_instruments()
seed_rules()
