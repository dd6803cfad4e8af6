"""docs/specification.md, sections 7 and 12: what `takt run` reports and does on failures, and how it
recovers."""
import threading

import endpoints
from fake_slave import SerialSlave, TcpSlave, rtu_answers, tcp_answer
from frames import request
from program import start, until
from projects import at, serial, tcp

INT = "type: int16, read: 0x03"
WITH_STATUS = ["name: V1, register: 0, type: int16, read: 0x03, default: -1, status: state"]
STATE = ["name: state, type: int", "name: enabled, type: bool, default: true"]


def value(name, wanted=None, quality="good"):
    return lambda e: e["event"] == "value" and e["name"] == name and e["quality"] == quality and wanted in (
        None, e["value"])


def status(code):
    return lambda e: e["event"] == "value" and e["name"] == "state" and e["value"] == code


def test_a_server_that_talks_nonsense_once(project):
    """After a header that is none nothing of that connection can be understood: a new one is made."""
    garbled = []

    def answer(adu):
        if not garbled:
            garbled.append(adu)
            return b"HTTP/1.1 400 Bad Request\r\n\r\n"
        return tcp_answer(adu, "03 02 00 07")

    with TcpSlave(answer) as slave, start("run", project(tcp(at([0], INT), slave.port)), "--json") as run:
        run.wait_event(value("V1", 7), "a good value on a new connection")
        run.interrupt()


def test_a_server_that_comes_and_goes(project):
    port = endpoints.free_port()
    path = project(tcp(WITH_STATUS, port, local=STATE, attempts=1))
    device = ["serve", "--listen", f"127.0.0.1:{port}", "--unit", 1]
    with start("run", path, "--json") as run:
        run.wait_event(status(103), "no connection")
        with start(*device) as running:
            run.wait_event(value("V1", 0), "a good value")
            run.wait_event(status(0), "success")
            seen = len(run.out)
            running.interrupt()
        run.wait_event(status(103), "the connection is lost", after=seen)
        run.wait_event(value("V1", -1, "bad"), "the default value", after=seen)
        seen = len(run.out)
        with start(*device) as running:
            run.wait_event(value("V1", 0), "a good value again", after=seen)
            run.wait_event(status(0), "success again", after=seen)
            running.interrupt()
        run.interrupt()


def test_a_serial_device_that_falls_silent(project, pair):
    """Default value and status while it does not answer; found again by its probes."""
    answers = {"03 0000 0001": "03 02 0007"}
    path = project(serial(WITH_STATUS, port=pair.a, local=STATE, attempts=2, response_timeout="500ms"))
    with start("run", path, "--json") as run:
        run.wait_event(lambda e: status(100)(e) or status(105)(e), "no answer")
        with SerialSlave(pair.b, rtu_answers(answers)):
            run.wait_event(value("V1", 7), "a good value")
            seen = len(run.out)
        run.wait_event(status(105), "not answering", after=seen)
        run.wait_event(value("V1", -1, "bad"), "the default value", after=seen)
        run.wait_event(lambda e: e["event"] == "device" and e["state"] == "not_answering",
                       "the device's state", after=seen)
        seen = len(run.out)
        with SerialSlave(pair.b, rtu_answers(answers)):
            run.wait_event(value("V1", 7), "a good value again", after=seen)
        run.interrupt()


def test_exceptions_and_bad_checksums_show_in_the_status(project, pair):
    answer = [request("rtu", 16, "83 02")]
    path = project(serial(WITH_STATUS, port=pair.a, local=STATE, attempts=255))
    with SerialSlave(pair.b, lambda _: answer[0]), start("run", path, "--json") as run:
        run.wait_event(status(2), "exception 2")
        answer[0] = request("rtu", 16, "03 02 0007")
        run.wait_event(status(0), "success")
        answer[0] = answer[0][:-1] + bytes([answer[0][-1] ^ 1])
        run.wait_event(status(101), "a bad checksum")
        answer[0] = request("rtu", 16, "03 04 0007 0008")
        run.wait_event(status(102), "another byte count than was asked for")
        run.interrupt()


def test_poll_enable_stops_the_polling(project, pair):
    path = project(serial(WITH_STATUS, port=pair.a, local=STATE, poll_enable="enabled"))
    with SerialSlave(pair.b, rtu_answers({"03 0000 0001": "03 02 0007"})) as slave, \
            start("run", path, "--json", "--stdin") as run:
        run.wait_event(value("V1", 7), "a good value")
        run.send("set enabled 0")
        run.wait_event(status(104), "switched off")
        asked = len(slave.seen)
        seen = len(run.out)
        run.send("set enabled 1")
        run.wait_event(value("V1", 7), "a good value again", after=seen)
        assert len(slave.seen) > asked
        run.interrupt()


def test_a_late_response_is_never_taken_for_another_value(project, pair):
    """docs/specification.md, section 12: register 0 is answered after the time-out; that must not become the
    value of register 10."""
    late = request("rtu", 16, "03 02 1111")
    timers = []

    def answer(frame):
        if frame[3] == 10:
            return request("rtu", 16, "03 02 2222")
        if timers:
            return late
        timers.append(threading.Timer(2.6, lambda: slave.send(late)))
        timers[0].start()
        return None

    path = project(
        serial([
            "name: Asked, register: 0, type: uint16, read: 0x03",
            "name: Other, register: 10, type: uint16, read: 0x03"
        ], port=pair.a, response_timeout="2s"))
    with SerialSlave(pair.b, answer) as slave, start("run", path, "--json") as run:
        run.wait_event(value("Other", 0x2222), "the right value")
        run.wait_event(value("Asked", 0x1111), "the right value")
        timers[0].join()
        run.interrupt()
        assert {e["value"] for e in run.events() if value("Other")(e)} == {0x2222}


def test_a_dead_line_does_not_hold_up_another(project, pair, blank_device):
    text = serial(at([0], INT), port=pair.a, response_timeout="1s")
    other = tcp(["name: Alive, register: 5, type: int16, read: 0x03"], blank_device("ramp"))
    path = project(text + other[other.index("  - name: net"):].replace("Node1", "Node2"))
    with start("run", path, "--json") as run:
        run.wait_event(value("Alive", 5), "the other line's value")
        run.interrupt()


def test_an_adapter_that_is_not_there_yet_ends_no_run_with_other_lines(project, pair, blank_device, tmp_path):
    adapter = tmp_path / "adapter"
    other = tcp(["name: Alive, register: 5, type: int16, read: 0x03"], blank_device("ramp"))
    path = project(
        serial(at([0], INT), port=adapter) + other[other.index("  - name: net"):].replace("Node1", "Node2"))
    with start("run", path, "--json") as run:
        run.wait_event(value("Alive", 5), "the other line's value")
        run.wait_event(lambda e: e["event"] == "link" and e["line"] == "rs485-1" and not e["up"],
                       "the missing port is reported")
        with SerialSlave(pair.b, rtu_answers({"03 00 00 00 01": "03 02 0007"})):
            adapter.symlink_to(pair.a)
            run.wait_event(value("V1", 7), "the value behind the adapter")
            run.interrupt()


def test_a_dead_device_does_not_hold_up_its_line(project, pair):
    text = serial(at([0], INT), port=pair.a, response_timeout="2s") + """\
      - name: Dead
        address: 17
        response_timeout: 100ms
        variables:
          - {name: Nothing, type: int16, register: 0, read: 0x03}
"""
    with SerialSlave(pair.b, lambda f: request("rtu", 16, "03 02 0007") if f[0] == 16 else None) as slave, \
            start("run", project(text), "--json") as run:
        run.wait_event(
            lambda e: e["event"] == "device" and (e["device"], e["state"]) == ("Dead", "not_answering"),
            "the dead one is found out")
        dead = sum(f[0] == 17 for f in slave.seen)
        alive = sum(f[0] == 16 for f in slave.seen)
        more = lambda: sum(f[0] == 16 for f in slave.seen) - alive
        until(lambda: more() >= 20, "twenty more answers of the living one")
        assert sum(f[0] == 17 for f in slave.seen) - dead <= 1 + more() / 4, "only probed"
        run.interrupt()
