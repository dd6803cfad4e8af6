"""docs/specification.md, section 5, on the line: the frames of `takt run` in its own log and in a record of
the line."""
import contextlib

import pytest

import endpoints
from fake_slave import SerialSlave, TcpSlave, rtu_answers, tcp_answer
from frames import crc16, split_rtu, traffic, without_checks
from program import start, takt, until
from projects import at, scenario_1, scenario_3, serial

GROUPED = "10 03 00 00 00 14 46 84"
# As captured in the source; its first and last are given there.
UNGROUPED = [(body := f"10 03 00 {register:02X} 00 02") + " " + crc16(bytes.fromhex(body)).hex(" ").upper()
             for register in range(0, 20, 2)]
PAIR, THIRD = "10 03 01 F4 00 02 87 44", "10 04 01 FA 00 01 13 46"


@contextlib.contextmanager
def served(path, pair, framing="rtu"):
    """`takt serve` as the devices of the project, on the far end of the pair."""
    with start("serve", path, "--port", pair.b) as device:
        endpoints.wait_slave(pair.a, 16, framing, device)
        yield device
        device.interrupt()


def run_until(path, pair, tmp_path, requests):
    """Runs the project until at least so many requests were answered; gives the frames of its traffic log,
    after comparing them with what passed on the line."""
    sent, answered = len(pair.sent()), len(pair.answered())
    log = tmp_path / "traffic.log"
    with start("run", path, "--traffic", log, "--json") as run:
        until(lambda: log.exists() and log.read_text().count(" Rx: ") >= requests, f"{requests} answers")
        run.interrupt()
    frames = traffic(log.read_text())
    tx, rx = (b"".join(f.bytes for f in frames if f.way == way) for way in ("Tx", "Rx"))
    until(lambda: len(pair.sent()) - sent >= len(tx), "all that was logged on the line")
    assert pair.sent()[sent:] == tx, "the log's Tx is what passed"
    assert pair.answered()[answered:].startswith(rx), "the log's Rx is what passed"
    return frames


def requests_of(frames):
    return [f.hex for f in frames if f.way == "Tx"]


def test_the_frames_of_the_source_decode_as_expected():
    assert (UNGROUPED[0], UNGROUPED[-1]) == ("10 03 00 00 00 02 C7 4A", "10 03 00 12 00 02 67 4F")
    for frame in (GROUPED, PAIR, THIRD):
        assert crc16(bytes.fromhex(frame)[:-2]) == bytes.fromhex(frame)[-2:]


def test_scenario_1_sends_one_request_and_nothing_else(project, pair, tmp_path):
    path = project(scenario_1(port=pair.a))
    with served(path, pair):
        frames = run_until(path, pair, tmp_path, 3)
    assert set(requests_of(frames)) == {GROUPED}
    answers = [f for f in frames if f.way == "Rx"]
    assert answers and all(len(f.bytes) == 5 + 40 and f.bytes[:3] == b"\x10\x03\x28" for f in answers)
    assert {(f.line, f.device, f.port) for f in frames} == {("rs485-1", "Node1", pair.a)}
    assert "unit 16" in frames[0].words and "holding" in frames[0].words


def test_scenario_1_in_ascii(project, pair, tmp_path):
    text = scenario_1(registers_per_request=61, port=pair.a).replace("framing: rtu",
                                                                     "framing: ascii\n    data_bits: 7")
    path = project(text)
    with served(path, pair, "ascii"):
        frames = run_until(path, pair, tmp_path, 3)
    assert {f.bytes for f in frames if f.way == "Tx"} == {b":100300000014D9\r\n"}
    answers = [f.bytes for f in frames if f.way == "Rx"]
    assert answers and all(a.startswith(b":100328") and len(a) == 2 * (1 + 2 + 40 + 1) + 3 for a in answers)


def test_scenario_2_sends_the_ten_requests_of_the_source(project, pair, tmp_path):
    path = project(scenario_1(grouped=False, port=pair.a))
    with served(path, pair):
        # On a slow machine some are repeated, or are checks of requests that look alike.
        sent = requests_of(run_until(path, pair, tmp_path, 4 * len(UNGROUPED)))
    sent = list(dict.fromkeys(without_checks(sent)))
    assert sent == UNGROUPED, "these ten, first by ascending address, and nothing else"


def test_scenario_3_sends_two_requests(project, pair, tmp_path):
    path = project(scenario_3(port=pair.a))
    with served(path, pair):
        sent = requests_of(run_until(path, pair, tmp_path, 12))
    assert set(sent) == {PAIR, THIRD}
    # 50 ms beside 100 ms: about twice as often, but never less often on however busy a machine
    assert sent.count(THIRD) >= sent.count(PAIR) - 1


def test_scenario_3_ungrouped_sends_three_requests(project, pair, tmp_path):
    path = project(scenario_3(grouped=False, port=pair.a))
    with served(path, pair):
        sent = requests_of(run_until(path, pair, tmp_path, 12))
    singles = {
        body + " " + crc16(bytes.fromhex(body)).hex(" ").upper()
        for body in ("10 03 01 F4 00 01", "10 03 01 F5 00 01")
    }
    # Two that look alike are checked once a second, by a read of one more register.
    assert set(sent) >= singles | {THIRD}
    assert all(frame in singles | {THIRD} or frame.split()[5] == "02" for frame in sent), sent


def test_a_trigger_puts_one_request_at_once(project, pair, tmp_path):
    path = project(scenario_3(port=pair.a, pair_period="1h", third_period="1h"))
    log = tmp_path / "traffic.log"

    def sent():
        return requests_of(traffic(log.read_text())) if log.exists() else []

    with served(path, pair), start("run", path, "--stdin", "--json", "--traffic", log) as run:
        until(lambda: sorted(sent()) == sorted([PAIR, THIRD]), "the first round")
        run.send("set T512 1")
        until(lambda: sent()[2:] == [PAIR], "one request of the pair, for its trigger")
        run.send("set T512 1")  # still 1: no edge
        run.send("set T512 0")  # a falling edge triggers nothing
        run.send("set T600 1")
        until(lambda: sent()[3:] == [THIRD], "one request of the third, for its trigger")
        run.send("set T512 true")
        until(lambda: sent()[4:] == [PAIR], "a new edge, a new request")
        run.send("quit")
        run.finish()
    assert sent()[5:] == []


# docs/specification.md, section 5: responses captured with the values 1.0 to 5.0.
GOLDEN_FLOATS = {
    0: ("3F 80", 1.0, "EB 62"),
    2: ("40 00", 2.0, "CA F2"),
    4: ("40 40", 3.0, "CB 02"),
    6: ("40 80", 4.0, "CB 52"),
    8: ("40 A0", 5.0, "CA 8A")
}


def golden_slave(port):
    return SerialSlave(
        port,
        rtu_answers(
            {f"03 00 {r:02X} 00 02": f"03 04 00 00 {high}"
             for r, (high, _, _) in GOLDEN_FLOATS.items()}))


def test_golden_floats(project, pair, tmp_path):
    path = project(
        serial(at(GOLDEN_FLOATS, "type: float, read: 0x03"), port=pair.a, group_requests="false",
               strategy="single"))
    with golden_slave(pair.b), start("run", path, "--json") as run:
        for number, (_, value, _) in enumerate(GOLDEN_FLOATS.values(), 1):
            run.wait_event(
                lambda e, n=number, v=value: e["event"] == "value" and e["name"] == f"V{n}" and e["value"] ==
                v and e["quality"] == "good", f"V{number} = {value}")
        run.interrupt()
    answers = split_rtu(pair.answered(), [9])
    captured = {bytes.fromhex(f"10 03 04 00 00 {high} {crc}") for high, _, crc in GOLDEN_FLOATS.values()}
    assert set(answers) == captured, "the frames of the source, their CRCs too"


def test_the_slave_side_puts_a_float_as_the_source_does(pair, tmp_path):
    log = tmp_path / "traffic.log"
    with start("serve", "--port", f"rtu://{pair.b}", "--unit", 16) as device:
        endpoints.wait_slave(pair.a, 16, process=device)
        for register, (_, value, _) in GOLDEN_FLOATS.items():
            takt("write", f"rtu://{pair.a}", "--unit", 16, "--type", "float", "holding", register, value)
            takt("read", f"rtu://{pair.a}", "--unit", 16, "--type", "float", "holding", register, "--traffic",
                 log)
        device.interrupt()
    seen = {f.hex for f in traffic(log.read_text()) if f.way == "Rx"}
    assert f"10 03 04 00 00 {GOLDEN_FLOATS[8][0]} {GOLDEN_FLOATS[8][2]}" in seen


# docs/specification.md, section 8.
@pytest.mark.parametrize("unit, asked, answer, code, frames", [
    (1, "04 00 00 00 02", "04 04 00 02 00 03", 0, ["01 04 00 00 00 02 71 CB", "01 04 04 00 02 00 03 1A 45"]),
    (1, "04 00 00 00 10", "84 02", 5, ["01 04 00 00 00 10 F1 C6", "01 84 02 C2 C1"]),
], ids=["two-input-registers", "illegal-data-address"])
def test_frames_of_section_8(pair, tmp_path, unit, asked, answer, code, frames):
    log = tmp_path / "traffic.log"
    with SerialSlave(pair.b, rtu_answers({asked: answer})):
        result = takt("read", f"rtu://{pair.a}", "--unit", unit, "input", 0, int(asked[-2:], 16), "--traffic",
                      log, code=code)
    assert [f.hex for f in traffic(log.read_text())] == frames
    if code == 0:
        assert [line.split()[-1] for line in result.lines] == ["2", "3"]


def test_tcp_frame_of_section_8():
    seen = []

    def answer(adu):
        seen.append(adu)
        return tcp_answer(adu, "03 06 02 2B 00 64 00 7F")

    with TcpSlave(answer) as slave:
        read = takt("read", f"tcp://127.0.0.1:{slave.port}", "--unit", 17, "holding", 0x6B, 3, "--json").json
    assert read["values"] == [555, 100, 127]
    assert seen[0][2:] == bytes.fromhex("0000 0006 11 03 006B 0003")
