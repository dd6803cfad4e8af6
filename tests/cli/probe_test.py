"""`takt probe` finds the ranges of a device in few requests, ready for a project."""
import datetime
import re
import signal

import pytest

import endpoints
from fake_slave import TcpSlave, tcp_answer
from program import start, takt, until
from projects import tcp
from pty_slave import Device, PtyLine


def registers(*ranges):
    return {a: a for first, last in ranges for a in range(first, last + 1)}


def target(line):
    return f"rtu://{line.port}?baud=19200&parity=none"


def holding(result):
    area, = [a for a in result["areas"] if a["area"] == "holding_register"]
    return area


MAP = [(0, 99), (101, 130), (200, 200)]


@pytest.mark.parametrize("no", [1, 2, 3, 4])
def test_ranges_of_a_device_that_refuses(no):
    with PtyLine(Device(7, registers=registers(*MAP), exception=no)) as line:
        result = takt("probe", target(line), "--unit", 7, "--area", "holding", "--to", 250, "--json",
                      "--timeout", "20s").json
        assert holding(result)["ranges"] == [list(r) for r in MAP]
        assert holding(result)["end"] == "complete" and result["complete"]
        assert line.asked == result["transmissions"]
        assert holding(result)[
            "requests"] < 200, "70 addresses are not there, each is asked once; the rest is read in groups"


class Forgetful(Device):
    """Every 30th answer is lost."""

    answered = 0

    def answer(self, pdu):
        self.answered += 1
        return None if self.answered % 30 == 0 else super().answer(pdu)


def lost_answers(traffic, timeout_ms):
    """How many requests of a traffic log got no answer in time: the busy machine may lose some too."""
    found = re.findall(r"(?m)^\[(.*?)\] TRA : .* ([TR]x): ", traffic.read_text())
    lines = [(datetime.datetime.fromisoformat(at), way) for at, way in found] + [(None, "Tx")]
    late = datetime.timedelta(milliseconds=timeout_ms - 2)
    return sum(way == "Tx" and (next_way == "Tx" or next_at - at > late)
               for (at, way), (next_at, next_way) in zip(lines, lines[1:]))


def test_a_line_that_loses_answers(tmp_path):
    device, log = Forgetful(7, registers=registers(*MAP)), tmp_path / "traffic"
    with PtyLine(device) as line:
        result = takt("probe", target(line), "--unit", 7, "--area", "holding", "--to", 250, "--json",
                      "--timeout", "400ms", "--traffic", log, deadline=250).json
        assert holding(result)["ranges"] == [list(r) for r in MAP]
        # A lost answer costs one repetition. The answer may still come, so the next two normal responses that
        # look like it are repeated. After those two it counts as lost; an exception in doubt is taken without
        # a repetition.
        lost = lost_answers(log, 400)
        assert lost >= device.answered // 30 >= 4
        assert result["requests"] + lost <= result["transmissions"] <= result["requests"] + 3 * lost


def test_a_device_that_refuses_by_silence():
    with PtyLine(Device(7, registers=registers((0, 9), (12, 14)), exception=0)) as line:
        result = takt("probe", target(line), "--unit", 7, "--area", "holding", "--to", 16, "--json",
                      "--timeout", "200ms").json
        assert holding(result)["ranges"] == [[0, 9], [12, 14]]


def test_the_longest_read_of_a_device():
    with PtyLine(Device(7, registers=registers((0, 59)), limit=16)) as line:
        result = takt("probe", target(line), "--unit", 7, "--area", "holding", "--to", 63, "--json",
                      "--timeout", "20s").json
        assert holding(result)["ranges"] == [[0, 59]]
        assert (holding(result)["limited"], holding(result)["longest_read"]) == (True, 16)


def test_the_output_is_valid_project_yaml(project):
    with PtyLine(Device(7, registers=registers(*MAP))) as line:
        yaml = takt("probe", target(line), "--unit", 7, "--to", 250, "--yaml", "--timeout", "20s").out
        assert "holding_register: [0..99, 101..130, 200]" in yaml
        text = takt("probe", target(line), "--unit", 7, "--area", "holding", "--to", 250, "--timeout",
                    "20s").lines
        assert text == ["holding_register 0..99", "holding_register 101..130", "holding_register 200"]
    readable = next(line for line in yaml.splitlines() if "holding_register" in line).strip()
    path = project(
        tcp(["name: A, type: int16, register: 0, read: 0x03"], 1502, strategy="optimal",
            readable=f"{{{readable}}}"))
    assert not [f for f in takt("check", path, "--json").json["findings"] if f["severity"] == "error"
                ], path.read_text()


def scattered():
    """A device over TCP whose registers are few and far between, at low addresses and near round numbers."""
    there = set(range(0, 4)) | {37, 250, 1001, 4099, 12002, 12003, 40300} | set(range(20480, 20620))

    def answer(adu):
        function, start, count = adu[7], int.from_bytes(adu[8:10], "big"), int.from_bytes(adu[10:12], "big")
        if function != 3:
            return tcp_answer(adu, f"{function | 0x80:02X} 01")
        if not there.issuperset(range(start, start + count)):
            return tcp_answer(adu, "83 02")
        return tcp_answer(adu, f"03 {2 * count:02X}" + " 00 07" * count)

    return TcpSlave(answer), [[0, 3], [37, 37], [250, 250], [1001, 1001], [4099, 4099], [12002, 12003],
                              [20480, 20619], [40300, 40300]]


def items(ranges):
    return {a for first, last in ranges for a in range(first, last + 1)}


def test_a_finer_step_finds_at_least_as_much():
    slave, there = scattered()
    with slave:
        url = f"tcp://127.0.0.1:{slave.port}"
        default = holding(takt("probe", url, "--area", "holding", "--json", deadline=250).json)
        assert default["ranges"] == there and default[
            "step"] == 128, "low addresses and round numbers are searched densely"
        fine = holding(
            takt("probe", url, "--area", "holding", "--step", 1, "--json", code=7, deadline=250).json)
        assert fine["end"] == "out_of_requests"
        assert items(fine["ranges"]) >= items(default["ranges"])
        assert items(fine["tested_ranges"]) >= items(default["tested_ranges"])


def test_what_was_and_was_not_tested():
    slave, _ = scattered()
    with slave:
        url = f"tcp://127.0.0.1:{slave.port}"
        whole = takt("probe", url, "--area", "holding", "--to", 2000, deadline=250)
        assert "all 2001 addresses 0..2000 were tested" in whole.err
        part = takt("probe", url, "--area", "holding", deadline=250)
        result = holding(takt("probe", url, "--area", "holding", "--json", deadline=250).json)
        first, last = result["longest_gap"]
        tested = items(result["tested_ranges"])
        assert len(tested) == result["tested"] and not tested & set(range(first, last + 1))
        assert f"{result['tested']} of 65536 addresses" in part.err and f"{first}..{last}" in part.err


def test_registers_that_exist_and_refuse():
    refused = {20: 4, 21: 4, 22: 3}
    with PtyLine(Device(7, registers=registers((0, 9)), refused=refused)) as line:
        arguments = ("probe", target(line), "--unit", 7, "--area", "holding", "--to", 40, "--timeout", "20s")
        assert holding(takt(*arguments, "--json").json)["refused"] == [{
            "first": 20,
            "last": 21,
            "exception": 4
        }, {
            "first": 22,
            "last": 22,
            "exception": 3
        }]
        result = takt(*arguments)
        assert result.lines == [
            "holding_register 0..9", "holding_register 20..21 exception 4", "holding_register 22 exception 3"
        ]
        assert "20..21: exists" in result.err


def test_all_of_a_blank_device(blank_device):
    port = blank_device()
    result = takt("probe", f"tcp://127.0.0.1:{port}", "--unit", 1, "--json").json
    assert [a["ranges"] for a in result["areas"]] == [[[0, 65535]]] * 4
    assert result["requests"] < 1300, "525 full reads for the registers of each area, 33 for its bits"


def test_the_limit_of_requests(blank_device):
    port = blank_device()
    result = takt("probe", f"tcp://127.0.0.1:{port}", "--area", "holding", "--max-requests", 10, "--json",
                  code=7).json
    assert holding(result)["end"] == "out_of_requests" and holding(result)["requests"] == 10
    assert holding(result)["ranges"] == [[0, 1125]] and holding(result)["next"] is not None


def test_no_device_and_no_register():
    with PtyLine(Device(7, registers={})) as line:
        takt("probe", target(line), "--unit", 9, "--timeout", "50ms", code=4)
        takt("probe", target(line), "--unit", 7, "--area", "holding", "--to", 20, "--timeout", "20s", code=1)
    takt("probe", f"tcp://127.0.0.1:{endpoints.free_port()}", code=3)


def test_interrupted():
    with PtyLine(Device(7, registers=registers((0, 3)), delay=0.05)) as line:
        with start("probe", target(line), "--unit", 7, "--area", "holding", "--to", 999) as running:
            until(lambda: line.asked >= 12, "a few addresses asked")
            result = running.interrupt(signal.SIGINT, code=7)
            assert result.lines == ["holding_register 0..3"]
            assert "of 1000 addresses 0..999 were tested" in result.err


def test_interrupted_before_anything_answered():
    with PtyLine(Device(7, registers={})) as line:
        with start("probe", target(line), "--unit", 9, "--timeout", "60s", "--json") as running:
            until(lambda: line.asked, "asked")
            result = running.interrupt(signal.SIGINT, code=7)
            assert result.json["areas"] == [] and result.json["complete"] is False


@pytest.mark.parametrize("arguments", [
    [],
    ["--area", "shoes"],
    ["--from", "9", "--to", "3"],
    ["--step", "0"],
    ["--max-requests", "0"],
    ["--to", "65536"],
], ids=" ".join)
def test_bad_usage(arguments):
    result = takt("probe", *(["tcp://127.0.0.1:1"] if arguments else []), *arguments, code=2)
    assert result.out == "" and result.err.strip()
