"""docs/specification.md, sections 7 and 12, and docs/hostile-inputs.md against the running program, sentence
by sentence."""
import contextlib
import random
import socket
import time

import endpoints
from fake_slave import Device, RtuDevices, TcpSlave, tcp_answer
from frames import request
from program import start, takt, until
from projects import at, serial, tcp

INT = "type: int16, read: 0x03"
STATE = ["name: state, type: int"]


def value(name, wanted=None, quality="good"):
    return lambda e: e["event"] == "value" and e["name"] == name and e["quality"] == quality and wanted in (
        None, e["value"])


def status(code):
    return lambda e: e["event"] == "value" and e["name"] == "state" and e["value"] == code


def outcome(run, command, after=None):
    before = len(run.out) if after is None else after
    run.send(command)
    return run.wait_event(lambda e: e["event"] == "outcome", f"the outcome of {command!r}", after=before)


def test_a_status_shows_success_every_exception_and_every_failure(project):
    device = Device({0: 7})
    with TcpSlave(device.over_tcp) as slave:
        path = project(
            tcp([f"register: 0, {INT}, period: 20ms, status: state"], slave.port, local=STATE,
                response_timeout="50ms", backoff="100ms"))
        with start("run", path, "--json") as run:
            run.wait_event(value("V1", 7), "a good value")
            for code in (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11):
                device.meddle = lambda pdu, code=code: bytes([0x83, code])
                run.wait_event(status(code), f"exception {code}")
                device.meddle, seen = lambda pdu: None, len(run.out)
                run.wait_event(status(0), "success again", after=seen)
            for code in (0x7F, 0xFF):
                device.meddle = lambda pdu, code=code: bytes([0x83, code])
                run.wait_event(
                    lambda e, code=code: e["event"] == "value" and e["reason"] == f"exception {code}",
                    f"exception {code} is reported unchanged")
            device.meddle = lambda pdu: bytes([3, 4, 0, 1, 0, 2])
            run.wait_event(status(102), "another byte count than asked for")
            device.meddle, seen = lambda pdu: None, len(run.out)
            run.wait_event(status(0), "success again", after=seen)
            device.meddle = lambda pdu: "silence"
            run.wait_event(status(100), "a time-out")
            run.wait_event(status(105), "not answering")
            device.meddle = lambda pdu: None
            seen = len(run.out)
            run.wait_event(status(0), "success again", after=seen)
            run.interrupt()
            good = [e["value"] for e in run.events() if value("V1")(e)]
    assert set(good) == {7}, "nothing else ever was a good value"


def test_a_connection_lost_under_a_write_leaves_it_unknown_and_comes_back(project):
    device, port = Device({0: 7}), endpoints.free_port()

    cuts = [True, True]  # one for each write

    def cut(adu):
        return "close" if adu[7] == 16 and cuts and cuts.pop() else device.over_tcp(adu)

    variables = [
        f"name: V, register: 0, write: 0x10, {INT}",
        f"name: Safe, register: 5, write: 0x10, safe_to_repeat: true, {INT}"
    ]
    path = project(tcp(variables, port))
    with start("run", path, "--json", "--stdin") as run:
        with TcpSlave(cut, port):
            run.wait_event(value("V", 7), "a good value")
            lost = outcome(run, "write V 50")
            assert (lost["outcome"], lost["reason"]) == ("unknown", "closed")
            before = len(run.out)
            run.send("write Safe 3")
            run.wait_event(
                lambda e: e["event"] == "outcome" and (e["name"], e["outcome"]) == ("Safe", "done"),
                "what is safe to repeat is repeated", after=before)
        run.wait_event(lambda e: e["event"] == "link" and "refused" in e.get("text", ""), "no listener",
                       after=before)
        before = len(run.out)
        with TcpSlave(device.over_tcp, port):
            run.wait_event(value("V", 7), "the value again", after=before)
            run.interrupt()
    assert device.writes() == ["10 00 05 00 01 02 00 03"], "what is not, is not"


def test_an_adapter_pulled_out_under_a_write_and_plugged_in_again(project, tmp_path):
    device = Device({0: 7})
    pair = endpoints.SerialPair(tmp_path)
    path = project(serial([f"name: V, register: 0, write: 0x10, {INT}"], port=pair.a, response_timeout="5s"))
    device.meddle = lambda pdu: "silence" if pdu[0] == 16 else None
    with start("run", path, "--json", "--stdin") as run:
        with RtuDevices(pair.b, {16: device}) as slave:
            run.wait_event(value("V", 7), "a good value")
            before = len(run.out)
            run.send("write V 50")
            until(lambda: any(f[1] == 16 for f in slave.seen), "the write is on the line")
        pair.close()
        lost = run.wait_event(lambda e: e["event"] == "outcome", "the outcome", after=before)
        assert (lost["outcome"], lost["reason"]) == ("unknown", "link_lost")
        run.wait_event(lambda e: e["event"] == "link" and not e["up"], "the port is gone", after=before)
        before = len(run.out)
        with contextlib.closing(endpoints.SerialPair(tmp_path)) as again, RtuDevices(
                again.b, {16: Device({0: 9})}) as slave:
            run.wait_event(value("V", 9), "it comes back by itself", after=before)
            assert not any(f[1] == 16 for f in slave.seen), "and does not repeat what may have been done"
            run.interrupt()


def test_a_group_never_writes_unknown_values(project):
    device = Device({0: 1, 1: 2})
    device.meddle = lambda pdu: bytes([0x83, 2]) if pdu[0] == 3 else None
    with TcpSlave(device.over_tcp) as slave:
        path = project(
            tcp([
                f"name: A, register: 0, write: 0x10, write_on_change: true, {INT}",
                f"name: B, register: 1, write: 0x10, write_on_change: true, {INT}"
            ], slave.port))
        with start("run", path, "--json", "--stdin") as run:
            run.send("set A 5")
            waiting = run.wait_event(lambda e: e["event"] == "write_waiting", "it reports that it waits")
            assert waiting["name"] == "B"
            assert device.writes() == []
            device.meddle = lambda pdu: None
            until(device.writes, "written once the other is known")
            run.interrupt()
    assert device.writes() == ["10 00 00 00 02 04 00 05 00 02"
                               ], "one request, with what was set and what was read"


def test_default_or_last_value_while_a_device_does_not_answer_and_the_dead_band(project):
    device = Device({0: 100, 1: 7, 2: 9})
    with TcpSlave(device.over_tcp) as slave:
        path = project(
            tcp([
                f"name: Band, register: 0, dead_band: 5, period: 20ms, {INT}",
                f"name: Held, register: 1, hold_last: true, default: -1, period: 20ms, {INT}",
                f"name: Default, register: 2, default: -2, period: 20ms, {INT}"
            ], slave.port, response_timeout="1s"))
        with start("run", path, "--json") as run:
            run.wait_event(value("Default", 9), "all are read")
            for number in (103, 96, 105, 95, 106):
                asked = len(device.done)
                device.registers[0] = number
                until(lambda asked=asked: len(device.done) > asked + 3, "it was read")
            run.wait_event(value("Band", 106), "a change beyond the band")
            device.meddle = lambda pdu: "silence"
            assert run.wait_event(value("Held", quality="bad"), "bad")["value"] == 7
            assert run.wait_event(value("Default", quality="bad"), "bad")["value"] == -2
            run.interrupt()
            values = [e["value"] for e in run.events() if value("Band")(e)]
    assert values == [100, 106]


def test_an_overrun_is_reported_with_the_real_period(project):
    device = Device()

    def slowly(adu):
        time.sleep(0.03)
        return device.over_tcp(adu)

    with TcpSlave(slowly) as slave, start("run",
                                          project(tcp([f"register: 0, {INT}, period: 10ms"], slave.port)),
                                          "--json") as run:
        event = run.wait_event(lambda e: e["event"] == "overrun" and e["overrun"], "the overrun")
        assert event["period_ms"] == 10 and event["real_period_ms"] >= 30
        run.interrupt()


def test_a_broadcast_reaches_all_and_waits_for_no_answer(project, pair):
    text = serial(at([0], INT), port=pair.a, poll_period="1h") + """\
      - name: All
        address: 0
        variables:
          - {name: Everywhere, type: int16, register: 3, read: none, write: 0x06}
          - {name: Changed, type: int16, register: 4, read: none, write: 0x10, write_on_change: true}
"""
    devices = {16: Device(), 17: Device()}
    with RtuDevices(pair.b, devices) as slave:
        with start("run", project(text), "--json", "--stdin") as run:
            run.wait_event(value("V1", 0), "the line works")
            assert outcome(run, "write Everywhere 5")["outcome"] == "done"
            run.send("set Changed 6")
            until(lambda: all(d.registers.get(4) == 6 for d in devices.values()), "the group of unit 0")
            run.interrupt()
        assert all(d.registers[3] == 5 for d in devices.values())
        takt("write", f"rtu://{pair.a}?baud=115200&parity=none", "--unit", 0, "holding", 9, 77)
        until(lambda: all(d.registers.get(9) == 77 for d in devices.values()), "a single command")
        takt("read", f"rtu://{pair.a}?baud=115200&parity=none", "--unit", 0, "holding", 9, code=2)
        assert [f[0] for f in slave.seen].count(0) == 3


class Nasty(RtuDevices):
    """Answers rightly, and puts what must not be believed around and instead of it."""

    def __init__(self, port, devices, seed):
        super().__init__(port, devices)
        self.to_play = 2 * list(KINDS)
        random.Random(seed).shuffle(self.to_play)

    def _take(self, frame):
        self.seen.append(frame)
        right = request("rtu", frame[0], self.devices[frame[0]](frame[1:-2]))
        kind = self.to_play.pop() if self.to_play else "right"
        for piece in KINDS[kind](self, frame, right):
            if isinstance(piece, float):
                self._stop.wait(piece)
            else:
                self._line.write(piece)


KINDS = {
    "right": lambda slave, asked, right: [right],
    "silence": lambda slave, asked, right: [],
    "late": lambda slave, asked, right: [0.4, right],
    "twice": lambda slave, asked, right: [right, right],
    "foreign unit": lambda slave, asked, right: [request("rtu", 99, "03 02 7E7E"), 0.004, right],
    "other function": lambda slave, asked, right: [request("rtu", asked[0], "04 02 7E7E")],
    "other byte count": lambda slave, asked, right: [request("rtu", asked[0], "03 04 7E7E 7E7E")],
    "oversized": lambda slave, asked, right: [request("rtu", asked[0], "03 F0" + "7E" * 240)],
    "longer than a frame": lambda slave, asked, right: [b"\x7E" * 600],
    "garbage before": lambda slave, asked, right: [b"\x00\xFF\x7E", 0.04, right],
    "garbage behind": lambda slave, asked, right: [right + b"\x7E\x7E\x7E"],
    "bad check": lambda slave, asked, right: [right[:-1] + bytes([right[-1] ^ 0x10])],
    "cut": lambda slave, asked, right: [right[:-2]],
    "exception": lambda slave, asked, right: [request("rtu", asked[0], "83 04")],
    "strange exception": lambda slave, asked, right: [request("rtu", asked[0], "83 FF")],
}


def test_nothing_false_ever_becomes_a_value(project, pair):
    """Late, double, foreign, oversized, cut and garbled answers: every good value is the one the device
    holds."""
    registers = {0: 1000, 10: 1010, 20: 1020}
    text = serial(at(registers, INT + ", period: 30ms"), port=pair.a, response_timeout="300ms", attempts=50,
                  strategy="single", group_requests="false")
    with Nasty(pair.b, {16: Device(registers)}, seed=11) as slave, start("run", project(text),
                                                                         "--json") as run:
        until(lambda: not slave.to_play, "every kind was played, twice")
        calm = len(run.out)
        for name in ("V1", "V2", "V3"):
            if next((e for e in reversed(run.events()) if e.get("name") == name),
                    {"quality": ""})["quality"] != "good":
                run.wait_event(value(name), f"{name} is well again", after=calm)
        run.interrupt()
        for number, true in enumerate(registers.values(), 1):
            values = {e["value"] for e in run.events() if value(f"V{number}")(e)}
            assert values == {true}, f"V{number}: {values}"


def test_one_late_answer_costs_one_request(project, pair):
    device, late = Device({0: 5}), []

    class Late(RtuDevices):

        def _take(self, frame):
            self.seen.append(frame)
            answer = request("rtu", frame[0], device(frame[1:-2]))
            if len(self.seen) == 4:
                late.append(answer)
                self._stop.wait(2.5)
            self._line.write(answer)

    path = project(serial([f"register: 0, {INT}, period: 50ms"], port=pair.a, response_timeout="2s"))
    with Late(pair.b, {}) as slave, start("run", path, "--json") as run:
        until(lambda: len(slave.seen) >= 24, "twenty requests after the late answer")
        summary = run.interrupt() and run.events()[-1]
    counters = summary["lines"][0]["counters"]
    assert late and counters["timeouts"] == 1 and counters["late_answers"] == 1
    assert counters["checksums"] + counters["unexpected"] + counters["exceptions"] == 0
    assert counters["answered"] >= 20


def test_the_response_to_a_write_must_repeat_it(project):
    device = Device()
    device.meddle = lambda pdu: bytes.fromhex("10 0000 0002") if pdu[0] == 16 else None
    with TcpSlave(device.over_tcp) as slave:
        with start("run", project(tcp([f"name: V, register: 0, write: 0x10, {INT}"], slave.port)), "--json",
                   "--stdin") as run:
            run.wait_event(value("V", 0), "a value")
            result = outcome(run, "write V 5")
            assert (result["outcome"], result["reason"]) == ("unknown", "unexpected_reply")
            device.meddle = lambda pdu: bytes([0x90, 3]) if pdu[0] == 16 else None
            result = outcome(run, "write V 6")
            assert (result["outcome"], result["reason"]) == ("refused",
                                                             "exception 3"), "a refusal is not retried"
            run.interrupt()


def test_answers_of_another_transaction_are_passed_over(project):
    device = Device({0: 7})

    def answer(adu):
        wrong = tcp_answer(adu, "03 02 7E7E", transaction=int.from_bytes(adu[:2], "big") ^ 0x1234)
        return wrong + device.over_tcp(adu) + device.over_tcp(adu)

    with TcpSlave(answer) as slave, start("run",
                                          project(tcp([f"register: 0, {INT}, period: 20ms"], slave.port)),
                                          "--json") as run:
        run.wait_event(value("V1", 7), "the value")
        until(lambda: len(device.done) > 40, "more requests")
        run.interrupt()
        assert {e["value"] for e in run.events() if value("V1")(e)} == {7}


def test_unsolicited_bytes_cost_nothing_but_a_count(project, pair):
    path = project(
        serial([f"register: 0, {INT}, period: 1h, read_trigger: go"], port=pair.a,
               local=["name: go, type: bool"]))
    noise = bytes(range(200)) + request("rtu", 16, "03 02 7E7E")
    answer = len(request("rtu", 16, "03 02 0007"))
    with RtuDevices(pair.b, {16: Device({0: 7})}) as slave, start("run", path, "--json", "--stdin") as run:
        run.wait_event(value("V1", 7), "a value")
        for turn in range(1, 6):
            for _ in range(4):  # while the master waits for nothing
                slave.send(noise)
            until(lambda n=turn: len(pair.answered()) == len(slave.seen) * answer + n * 4 * len(noise),
                  "the noise on the line")
            run.send("set go 1")
            until(lambda n=turn: len(slave.seen) > n, "it goes on asking")
            run.send("set go 0")
        run.interrupt()
        assert {e["value"] for e in run.events() if value("V1")(e)} == {7}
        assert run.events()[-1]["lines"][0]["counters"]["unsolicited_bytes"] > 0


def test_a_host_that_swallows_connections_holds_up_no_other(project):
    device = Device({5: 55})
    with contextlib.ExitStack() as stack, TcpSlave(device.over_tcp) as slave:
        full = stack.enter_context(socket.create_server(("127.0.0.1", 0), backlog=0))
        for _ in range(3):  # beyond them the system answers no further attempt
            waiting = stack.enter_context(socket.socket())
            waiting.setblocking(False)
            waiting.connect_ex(full.getsockname())
        text = tcp(at([0], INT), full.getsockname()[1])
        other = tcp([f"name: Alive, register: 5, period: 20ms, write: 0x06, {INT}"],
                    slave.port).replace("name: net", "name: other")
        text += other[other.index("  - name: other"):].replace("Node1", "Node2")
        with start("run", project(text), "--json", "--stdin") as run:
            run.wait_event(value("Alive", 55), "the other line's value")
            until(lambda: len(device.done) > 50, "it goes on")
            assert outcome(run, "write Alive 6")["outcome"] == "done"
            run.interrupt()
            assert not any(e["event"] == "link" and e["line"] == "net" and e["up"] for e in run.events())


def test_writes_get_through_polling_without_pause(project):
    device = Device()
    with TcpSlave(device.over_tcp) as slave:
        path = project(
            tcp([f"name: V{i}, register: {10 * i}, period: 0ms, write: 0x06, {INT}" for i in range(20)],
                slave.port))
        with start("run", path, "--json", "--stdin") as run:
            run.wait_event(value("V19", 0), "all are polled")
            # At once, so that all wait.
            run.send("\n".join(f"write V{number % 20} {number}" for number in range(1, 31)))
            until(lambda: len([e for e in run.events() if e["event"] == "outcome"]) == 30, "thirty outcomes")
            run.interrupt()
    written = [int(pdu[-5:].replace(" ", ""), 16) for pdu in device.writes()]
    assert written == list(range(1, 31)), "each once, in their order"
    positions = [i for i, pdu in enumerate(device.done) if pdu.startswith("06")]
    assert all(
        b - a <= 2
        for a, b in zip(positions, positions[1:])), "with at most one transaction between two that wait"
