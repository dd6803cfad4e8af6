"""Writing on a real line: bits by mask and by read-modify-write, a read and a write at once."""
import endpoints
from frames import traffic
from program import start, takt, until
from projects import serial

BITS = [
    "name: A, type: bool, register: 5, bit: 3, read: 0x03, write: 0x06, write_on_change: true, period: 1h",
    "name: B, type: bool, register: 5, bit: 9, read: 0x03, write: 0x06, write_on_change: true, period: 1h"
]


def writes(log, functions):
    """PDUs sent with one of these functions, in hexadecimal."""
    if not log.exists():
        return []
    pdus = [f.bytes[1:-2] for f in traffic(log.read_text()) if f.way == "Tx"]
    return [pdu.hex(" ").upper() for pdu in pdus if pdu[0] in functions]


def test_a_bit_by_mask(project, pair, tmp_path):
    path = project(serial(BITS, port=pair.a, fc22="true"))
    log = tmp_path / "traffic.log"
    with start("serve", path, "--port", pair.b) as device:
        endpoints.wait_slave(pair.a, 16, "rtu", device)
        with start("run", path, "--stdin", "--json", "--traffic", log) as run:
            run.send("set A 1")
            until(lambda: writes(log, {0x16}) == ["16 00 05 FF F7 00 08"], "the mask of one bit")
            run.send("write B 1")
            until(lambda: writes(log, {0x16})[1:] == ["16 00 05 FD FF 02 00"], "the mask of the other")
            run.send("quit")
            run.finish()
        assert writes(log, {0x06, 0x10}) == []
        device.interrupt()


def test_a_bit_by_read_modify_write(project, pair, tmp_path):
    path = project(serial(BITS, port=pair.a, read_modify_write="true"))
    log = tmp_path / "traffic.log"
    with start("serve", path, "--port", pair.b) as device:
        endpoints.wait_slave(pair.a, 16, "rtu", device)
        with start("run", path, "--stdin", "--json", "--traffic", log) as run:
            until(lambda: len(writes(log, {0x03})) >= 1, "the first round")
            run.send("set A 1")
            until(lambda: len(writes(log, {0x06})) == 1, "the register written back")
            run.send("quit")
            run.finish()
        sent = writes(log, {0x03, 0x06})
        at = next(i for i, pdu in enumerate(sent) if pdu.startswith("06"))
        assert sent[at - 1] == "03 00 05 00 01", "read right before it is written"
        written = int(sent[at].replace(" ", "")[-4:], 16)
        frames = traffic(log.read_text())
        place = [f.hex for f in frames if f.way == "Tx"].index(next(f.hex for f in frames if f.bytes[1] == 6))
        answers = [f.bytes for f in frames if f.way == "Rx"]
        assert written == int.from_bytes(answers[place - 1][3:5],
                                         "big") | 1 << 3, "the other bits as they were"
        device.interrupt()


def test_a_trigger_reads_and_writes_at_once(project, pair, tmp_path):
    variables = [
        "name: In, type: int, register: 0, read: 0x03, read_trigger: go, period: 1h",
        "name: Out, type: int, register: 10, write: 0x10, write_trigger: go"
    ]
    path = project(
        serial(variables, port=pair.a, strategy="optimal", fc23="true", local=["name: go, type: bool"]))
    planned = takt("plan", path, "--json").json["lines"][0]["requests"]
    both = [r for r in planned if r["write_function"] == 0x17]
    assert [(r["function"], r["start"], r["quantity"], r["write_start"], r["write_quantity"])
            for r in both] == [(0x17, 0, 1, 10, 1)]
    log = tmp_path / "traffic.log"
    with start("serve", path, "--port", pair.b) as device:
        endpoints.wait_slave(pair.a, 16, "rtu", device)
        with start("run", path, "--stdin", "--json", "--traffic", log) as run:
            run.send("set Out 258")
            run.send("set go 1")
            until(lambda: writes(log, {0x17}) == ["17 00 00 00 01 00 0A 00 01 02 01 02"],
                  "one request for both")
            run.wait_event(lambda e: e.get("name") == "In" and e.get("quality") == "good", "the value read")
            run.send("quit")
            run.finish()
        assert writes(log, {0x06, 0x10}) == []
        device.interrupt()
