"""Every function beyond reading and writing, of a server of `takt serve`: asked by pymodbus, and by
`takt raw` where pymodbus cannot. Which keys give which function: docs/project-file.md."""
import contextlib
import pathlib

import pytest

import endpoints
from overheard import overheard
from program import DEADLINE, start, takt
from projects import ALL_ITEMS, slave

BAUD = "19200"
LONG = "x" * 61
UNIT = [
    "files: [{number: 4, records: 100}, {number: 5, records: 10}, {number: 6, records: 200}]",
    "fifos: [{register: 1246, values: [440, 4740]}]",
    "identification: [{id: 0, text: Vendor}, {id: 1, text: Product}, {id: 2, text: '3.1'}, " +
    ", ".join(f"{{id: {i}, text: {LONG}}}" for i in range(128, 132)) + "]", "server_id: Pump",
    "restart: true", "listen_only: true", "exception_coils: 8",
    "limits: [{registers: [50], least: 100, greatest: 200}]"
]


@contextlib.contextmanager
def served(pair, framing, unit, *options, banks=ALL_ITEMS):
    """A unit filled with the ramp; gives the endpoint and its target."""
    if framing == "tcp":
        endpoint = endpoints.free_port()
        place = ["listen: 127.0.0.1", f"tcp_port: {endpoint}"]
    else:
        endpoint = pair.a
        settings = f"?baud={BAUD}&parity=even" + ("&data_bits=7" if framing == "ascii" else "")
        place = ["transport: serial", f"port: {pair.b}", f"framing: {framing}", f"baud: {BAUD}"]
        place += ["data_bits: 7"] * (framing == "ascii")
    path = pathlib.Path(pair.a).with_name("unit.yaml")
    path.write_text(slave(place, unit, banks), encoding="utf-8")
    with start("serve", path, "--fill", "ramp", *options) as running:
        if framing == "tcp":
            endpoints.wait_listening(endpoint, running)
        else:
            endpoints.wait_slave(endpoint, 1, framing, running)
        with overheard(framing, endpoint, pair) as tapped:
            serial = framing != "tcp"
            yield tapped, f"{framing}://{tapped}{settings}" if serial else f"tcp://127.0.0.1:{tapped}"
        running.interrupt()


@contextlib.contextmanager
def connected(framing, endpoint):
    from pymodbus.client import ModbusSerialClient, ModbusTcpClient
    from pymodbus.transaction import ModbusAsciiFramer, ModbusRtuFramer
    if framing == "tcp":
        client = ModbusTcpClient("127.0.0.1", port=endpoint, timeout=DEADLINE)
    else:
        framer = ModbusRtuFramer if framing == "rtu" else ModbusAsciiFramer
        client = ModbusSerialClient(endpoint, framer=framer, baudrate=int(BAUD), timeout=DEADLINE)
    assert client.connect()

    def ask(request):
        request.unit_id = 1
        response = client.execute(request)
        assert not response.isError(), response
        return response

    try:
        yield ask
    finally:
        client.close()


@pytest.mark.parametrize("framing", ["tcp", "rtu", "ascii"])
def test_pymodbus_asks_for_every_further_function(pair, framing):
    from pymodbus.diag_message import (ClearCountersRequest, ReturnBusExceptionErrorCountRequest,
                                       ReturnQueryDataRequest, ReturnSlaveMessageCountRequest)
    from pymodbus.file_message import FileRecord, ReadFileRecordRequest, WriteFileRecordRequest
    from pymodbus.mei_message import ReadDeviceInformationRequest
    from pymodbus.other_message import (GetCommEventCounterRequest, GetCommEventLogRequest,
                                        ReadExceptionStatusRequest, ReportSlaveIdRequest)
    with served(pair, framing, UNIT) as (endpoint, _), connected(framing, endpoint) as ask:
        ask(ClearCountersRequest())
        assert ask(ReturnQueryDataRequest(0xA537)).message == (0xA537, )
        assert ask(ReturnSlaveMessageCountRequest()).message == (2, )
        assert ask(ReturnBusExceptionErrorCountRequest()).message == (0, )
        assert ask(ReadExceptionStatusRequest()).status == 0xAA, "coils 8..15 of the ramp"
        counted = ask(GetCommEventCounterRequest()).count
        log = ask(GetCommEventLogRequest())
        assert log.event_count == counted and log.events[0] == 0x80 and len(log.events) >= 10
        assert ask(ReportSlaveIdRequest()).identifier == b"\x01\xFFPump"
        basic = ask(ReadDeviceInformationRequest(1, 0))
        assert basic.information == {0: b"Vendor", 1: b"Product", 2: b"3.1"} and basic.conformity == 0x83
        assert ask(ReadDeviceInformationRequest(4, 0x80)).information == {0x80: LONG.encode()}
        extended = ask(ReadDeviceInformationRequest(3, 0))
        assert extended.more_follows == 0xFF and extended.next_object_id == 0x83
        ask(
            WriteFileRecordRequest(
                [FileRecord(file_number=4, record_number=7, record_data=b"\x06\xaf\x04\xbe")]))
        read = ask(
            ReadFileRecordRequest([
                FileRecord(file_number=4, record_number=6, record_length=4),
                FileRecord(file_number=5, record_number=9, record_length=1)
            ]))
        assert [r.record_data for r in read.records] == [b"\0\x06\x06\xaf\x04\xbe\0\x09", b"\0\x09"]


@pytest.mark.parametrize("framing", ["tcp", "rtu", "ascii"])
def test_pymodbus_asks_for_every_diagnosis(pair, framing):
    from pymodbus import diag_message as diag
    counters = (diag.ReturnBusCommunicationErrorCountRequest, diag.ReturnBusExceptionErrorCountRequest,
                diag.ReturnSlaveNoResponseCountRequest, diag.ReturnSlaveNAKCountRequest,
                diag.ReturnSlaveBusyCountRequest, diag.ReturnSlaveBusCharacterOverrunCountRequest)
    with served(pair, framing, UNIT) as (endpoint, _), connected(framing, endpoint) as ask:
        ask(diag.ClearCountersRequest())
        for asked, counter in enumerate(
            (diag.ReturnBusMessageCountRequest, diag.ReturnSlaveMessageCountRequest), 1):
            assert ask(counter()).message == (asked, ), counter
        for request in (*counters, diag.ReturnDiagnosticRegisterRequest, diag.ClearOverrunCountRequest):
            assert ask(request()).message == (0, ), request
        assert ask(diag.ChangeAsciiInputDelimiterRequest(0x0A00)).message == (0x0A00, )
        ask(diag.RestartCommunicationsOptionRequest(False))
        for request in (diag.ReturnIopOverrunCountRequest,
                        diag.GetClearModbusPlusRequest):  # not of the specification, of old Modicons
            with pytest.raises(AssertionError, match="ExceptionResponse"):
                ask(request(data=0))


# Requests and their responses. The order matters only where a request changes something.
ANSWERS = [
    ("18 04DE", "18 00 06 00 02 01 B8 12 84"),
    ("08 0002 0000", "08 00 02 00 00"),
    ("08 0003 0A00", "08 00 03 0A 00"),
    ("08 000C 0000", "08 00 0C 00 00"),
    ("08 0010 0000", "08 00 10 00 00"),
    ("08 0011 0000", "08 00 11 00 00"),
    ("08 0012 0000", "08 00 12 00 00"),
    ("08 0014 0000", "08 00 14 00 00"),
    ("08 0001 FF00", "08 00 01 FF 00"),
    ("2B 0E 04 00", "2B 0E 04 83 00 00 01 00 06 56 65 6E 64 6F 72"),
    ("41 0102", "C1 01"),
    ("2B 0D 00", "AB 01"),
    ("08 0005 0000", "88 01"),
    ("08 0002 0001", "88 03"),
    ("14 07 06 0004 0064 0001", "94 02"),
    ("14 07 07 0004 0000 0001", "94 03"),
    ("18 04DF", "98 02"),
    ("2B 0E 05 00", "AB 03"),
    ("2B 0E 04 33", "AB 02"),
]


@pytest.mark.parametrize("framing", ["tcp", "rtu", "ascii"])
def test_answers_and_exceptions(pair, framing):
    with served(pair, framing, UNIT) as (_, target):
        for request, answer in ANSWERS:
            refused = int(answer[:2], 16) & 0x80
            assert takt("raw", target, "--timeout", "30s", request,
                        code=5 if refused else 0).out.strip() == answer, request


def test_rights_and_files_are_refused_without_their_key(pair):
    with served(pair, "tcp", ["server_id: takt"]) as (_, target):
        for request in ("08 0001 0000", "08 0004 0000"):
            assert takt("raw", target, request, code=5).out.strip() == "88 01"
        assert takt("raw", target, "11").out.strip() == "11 06 01 FF 74 61 6B 74"
        assert takt("raw", target, "14 07 06 0001 0000 0001", code=5).out.strip() == "94 01"


def test_listen_only_mode_until_restarted(pair):
    with served(pair, "tcp", ["listen_only: true", "restart: true"]) as (_, target):
        takt("raw", target, "08 0004 0000", "--timeout", "300ms", code=4)
        takt("read", target, "holding", 0, "--timeout", "300ms", code=4)
        takt("raw", target, "08 0001 0000", "--timeout", "300ms", code=4)
        assert takt("read", target, "holding", 0).code == 0


def test_layout_of_the_banks(pair):
    banks = ("banks: [{area: holding_register, items: [0..9, 0x20..0x21], read_only: [3]}, "
             "{area: coil, items: [0..159], overlay: holding_register}]")
    limits = ["limits: [{registers: [4], least: -5, greatest: 5}]"]
    with served(pair, "tcp", limits, banks=banks) as (_, target):

        def ask(request, code=0):
            return takt("raw", target, request, code=code).out.strip()

        assert ask("03 0020 0002") == "03 04 00 20 00 21"
        assert ask("03 0009 0002", 5) == "83 02"
        assert ask("06 0003 0001", 5) == "86 02"
        assert ask("06 0004 FFFA", 5) == "86 03"
        assert ask("06 0004 FFFB") == "06 00 04 FF FB"
        assert ask("01 0050 0010") == "01 02 05 00", "the bits of register 5"
        assert ask("05 0033 FF00", 5) == "85 02", "register 3 is read only"
        assert ask("05 00A0 FF00", 5) == "85 02", "there is no coil 160"
        assert ask("0F 0010 0008 01 81") == "0F 00 10 00 08"
        assert ask("03 0001 0001") == "03 02 00 81"
