"""Every frame through Wireshark's dissectors: nothing malformed, no warning, every CRC right."""
import subprocess

import pytest

import endpoints
from frames import TcpCapture, pcap, request, traffic
from overheard import MBAP, Tap, judge, rtu_connection
from program import DEADLINE, PEERS, start, takt, until
from projects import at, serial, tcp

USER_0 = 147  # a link type without a meaning of its own, decoded below as Modbus RTU
RTU_OPTIONS = ["-o", 'uat:user_dlts:"User 0 (DLT=147)","mbrtu","0","","0",""']


def judge_tcp(tap, path, least):
    assert tap.chunks() >= least
    judge(tap.write(path), tap.frames())


def test_our_slave_over_tcp(blank_device, tmp_path):
    """A libmodbus master tries every function."""
    with Tap(blank_device("ramp")) as tap:
        subprocess.run([str(PEERS / "libmodbus_client"), "tcp", "127.0.0.1",
                        str(tap.port), "1"], check=True, timeout=DEADLINE, stdout=subprocess.DEVNULL)
        judge_tcp(tap, tmp_path / "tcp.pcap", 100)


def test_our_master_over_tcp(project, blank_device, tmp_path):
    variables = at(range(0, 20, 2), "type: float, read: 0x03") \
        + at(range(30, 35), "type: int16, read: 0x04") \
        + [f"type: bool, coil: {c}, read: 0x01" for c in range(5)] \
        + ["name: Out, type: int16, register: 50, read: 0x03, write: 0x10, write_on_change: true",
           "name: One, type: int16, register: 60, write: 0x06",
           "name: Lamp, type: bool, coil: 70, write: 0x05"]
    with Tap(blank_device("ramp")) as tap:
        with start("run", project(tcp(variables, tap.port)), "--json", "--stdin") as run:
            for command, name in (("set", "Out"), ("write", "One"), ("write", "Lamp")):
                run.send(f"{command} {name} 1")
            for name in ("One", "Lamp"):
                run.wait_event(lambda e, n=name: e["event"] == "outcome" and e["name"] == n, "the outcome")
            until(lambda: tap.chunks() > 40, "traffic")
            run.interrupt()
        for raw in ("16 0004 00F2 0025", "17 0003 0006 000E 0003 06 00FF 00FF 00FF", "0F 0013 000A 02 CD 01"):
            takt("raw", f"tcp://127.0.0.1:{tap.port}", raw)
        takt("read", f"tcp://127.0.0.1:{tap.port}", "discrete", 0, 2500)
        judge_tcp(tap, tmp_path / "tcp.pcap", 40)


def rtu_capture(path, frames):
    path.write_bytes(pcap(USER_0, frames))
    return path


def test_rtu_frames_of_a_run(project, pair, tmp_path):
    """The frames of the traffic log: our master's and, as it received them, our slave's."""
    variables = at(range(0, 20, 2), "type: float, read: 0x03") \
        + at(range(30, 35), "type: int16, read: 0x04") \
        + [f"type: bool, register: 2, bit: {b}, read: 0x01" for b in range(5)] \
        + ["name: Out, type: int16, register: 50, read: 0x03, write: 0x10, write_on_change: true"]
    path, log = project(serial(variables, port=pair.a, address=1)), tmp_path / "traffic.log"
    with start("serve", "--port", f"rtu://{pair.b}?baud=115200&parity=none", "--unit", 1) as device:
        endpoints.wait_slave(pair.a, 1, process=device)
        with start("run", path, "--json", "--stdin", "--traffic", log) as run:
            run.send("set Out 7")
            run.wait_event(lambda e: e["event"] == "value" and e["name"] == "Out" and e["value"] == 7,
                           "the write")
            for number in (1, 11, 16):  # one of each read
                run.wait_event(lambda e, n=f"V{number}": e["event"] == "value" and e["name"] == n,
                               "the reads")
            run.interrupt()
        for number, raw in enumerate(
            ("05 0013 FF00", "06 0001 0003", "0F 0013 000A 02 CD 01", "16 0004 00F2 0025", "01 0000 07D0",
             "17 0003 0006 000E 0003 06 00FF 00FF 00FF", "02 0000 07D1", "03 FFFF 0002")):
            target = f"rtu://{pair.a}?baud=115200&parity=none"
            takt("raw", target, raw, "--traffic", tmp_path / f"raw-{number}.log", code=5 if number > 5 else 0)
        device.interrupt()
    frames = [f for name in [log, *sorted(tmp_path.glob("raw-*.log"))] for f in traffic(name.read_text())]
    assert {f.bytes[1] & 0x7F for f in frames} >= {1, 2, 3, 4, 5, 6, 15, 16, 22, 23}
    judge(rtu_capture(tmp_path / "rtu.pcap", [f.bytes for f in frames]), len(frames), *RTU_OPTIONS)


@pytest.mark.parametrize(
    "harm", [lambda f: f[:-1] + bytes([f[-1] ^ 1]), lambda f: f[:2] + b"\x09" + f[3:-2] + b"\0\0"],
    ids=["checksum", "length"])
def test_the_judge_detects_errors(tmp_path, harm):
    frame = request("rtu", 1, "03 04 00 07 00 08")
    with pytest.raises(AssertionError):
        judge(rtu_capture(tmp_path / "bad.pcap", [frame, harm(frame)]), 2, *RTU_OPTIONS)
    judge(rtu_capture(tmp_path / "good.pcap", [frame, frame]), 2, *RTU_OPTIONS)


def test_the_judge_of_tcp_detects_errors(tmp_path):

    def capture(quantity_bytes):
        built = TcpCapture(40000, MBAP)
        built.chunk(False, bytes.fromhex("0001 0000 0006 01 03 0000 0002"))
        built.chunk(
            True,
            bytes.fromhex("0001 0000") + (3 + quantity_bytes).to_bytes(2, "big") + bytes([1, 3, 4]) +
            bytes(quantity_bytes))
        path = tmp_path / "tcp.pcap"
        path.write_bytes(pcap(TcpCapture.LINK_TYPE, built.packets))
        return path

    judge(capture(4), 2)
    with pytest.raises(AssertionError):
        judge(capture(1), 2)


def test_the_judge_of_serial_lines_detects_errors(tmp_path):

    def capture(answer):
        built, count = rtu_connection([(False, request("rtu", 1, "03 0007 0002")[:3]),
                                       (False, request("rtu", 1, "03 0007 0002")[3:]),
                                       (True, request("rtu", 1, answer)), (False, request("rtu", 1, "11"))])
        path = tmp_path / "rtu.pcap"
        path.write_bytes(pcap(TcpCapture.LINK_TYPE, built.capture.packets))
        assert count == 2
        return path

    judge(capture("03 04 0007 0008"), 2)
    with pytest.raises(AssertionError):
        judge(capture("03 08 0007 0008"), 2)
