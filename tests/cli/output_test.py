"""`read`, `write` and `raw` against a blank device: their output, and the order of values in registers."""
import socket

import pytest

from endpoints import free_port
from program import start, takt, until


@pytest.fixture
def device(blank_device):

    def target(fill="ramp"):
        return f"tcp://127.0.0.1:{blank_device(fill)}"

    return target


def test_read_prints_a_line_a_value(device):
    lines = takt("read", device(), "holding", 10, 3).lines
    assert [line.split() for line in lines] == [["10", "10"], ["11", "11"], ["12", "12"]]


def test_read_as_json_is_one_object(device):
    target = device()
    result = takt("read", target, "input", 5, 4, "--json")
    assert {k: v
            for k, v in result.json.items() if k != "time_ms"} == {
                "target": target,
                "unit": 1,
                "function": 4,
                "start": 5,
                "type": result.json["type"],
                "values": [5, 6, 7, 8]
            }
    assert result.json["time_ms"] >= 0


def test_the_ramp_of_bits(device):
    target = device()
    for area in ("coils", "discrete"):
        values = takt("read", target, area, 7, 5, "--json").json["values"]
        assert [int(v) for v in values] == [1, 0, 1, 0, 1]


@pytest.mark.parametrize("area, count", [("coils", 5000), ("discrete", 2001), ("holding", 300),
                                         ("input", 126)])
def test_more_than_a_request_holds_is_read_in_several(device, area, count):
    values = takt("read", device(), area, 1, count, "--json").json["values"]
    expected = range(1, count + 1)
    assert [int(v) for v in values] == [x & 1 if area in ("coils", "discrete") else x for x in expected]


def test_the_last_address(device):
    target = device()
    assert takt("read", target, "holding", 65535, "--json").json["values"] == [65535]
    takt("write", target, "holding", 65535, 1)
    assert takt("read", target, "holding", 65535, "--json").json["values"] == [1]


# A value, its type, and its registers in the order 2143 (low register first, high byte first).
TYPES = [
    ("int16", "-2", [0xFFFE]),
    ("uint16", "65534", [0xFFFE]),
    ("int32", "-2", [0xFFFE, 0xFFFF]),
    ("uint32", "305419896", [0x5678, 0x1234]),
    ("int64", "-2", [0xFFFE, 0xFFFF, 0xFFFF, 0xFFFF]),
    ("uint64", "18446744073709551614", [0xFFFE, 0xFFFF, 0xFFFF, 0xFFFF]),
    ("float", "1.0", [0x0000, 0x3F80]),
    ("double", "1.0", [0, 0, 0, 0x3FF0]),
]


@pytest.mark.parametrize("kind, value, registers", TYPES, ids=[t[0] for t in TYPES])
def test_types(device, kind, value, registers):
    target = device("zero")
    takt("write", target, "--type", kind, "holding", 20,
         *(["--", value] if value.startswith("-") else [value]))
    assert takt("read", target, "holding", 20, len(registers), "--type", "uint16",
                "--json").json["values"] == registers
    read = takt("read", target, "holding", 20, "--type", kind, "--json").json["values"][0]
    assert float(read) == float(value)


@pytest.mark.parametrize("order, registers", [("2143", [0x5678, 0x1234]), ("1234", [0x7856, 0x3412]),
                                              ("4321", [0x1234, 0x5678]), ("3412", [0x3412, 0x7856]),
                                              ("CDAB", [0x5678, 0x1234]), ("DCBA", [0x7856, 0x3412]),
                                              ("ABCD", [0x1234, 0x5678]), ("badc", [0x3412, 0x7856])])
def test_orders(device, order, registers):
    """Bytes numbered from the least significant, in the order they are sent: 2143 sends 56 78 12 34 of
    0x12345678."""
    target = device("zero")
    takt("write", target, "--type", "uint32", "--order", order, "holding", 0, 0x12345678)
    assert takt("read", target, "holding", 0, 2, "--json").json["values"] == registers
    assert takt("read", target, "holding", 0, "--type", "uint32", "--order", order,
                "--json").json["values"] == [0x12345678]


def test_a_string(device):
    target = device("zero")
    takt("write", target, "--type", "string", "holding", 0, "Takt 1")
    assert takt("read", target, "holding", 0, 3, "--json").json["values"] == [0x5461, 0x6B74, 0x2031]


def test_several_values(device):
    target = device("zero")
    takt("write", target, "holding", 0, 1, 2, 3)
    takt("write", target, "coils", 3, 1, 0, 1)
    assert takt("read", target, "holding", 0, 4, "--json").json["values"] == [1, 2, 3, 0]
    assert [int(v) for v in takt("read", target, "coils", 2, 5, "--json").json["values"]] == [0, 1, 0, 1, 0]


@pytest.mark.parametrize("arguments, function", [
    (["holding", 0, 1], "06"),
    (["--multiple", "holding", 0, 1], "10"),
    (["holding", 0, 1, 2], "10"),
    (["--type", "float", "holding", 0, "1.5"], "10"),
    (["coils", 0, 1], "05"),
    (["--multiple", "coils", 0, 1], "0F"),
    (["coils", 0, 1, 1], "0F"),
], ids=lambda a: "-".join(map(str, a)) if isinstance(a, list) else a)
def test_the_function_of_a_write(device, tmp_path, arguments, function):
    log = tmp_path / "log"
    takt("write", device("zero"), *arguments, "--traffic", log)
    sent = [line for line in log.read_text().splitlines() if " Tx: " in line]
    assert len(sent) == 1 and sent[0].split("] ")[2].split()[7] == function


def test_raw_prints_the_response_as_hex(device):
    target = device()
    result = takt("raw", target, "03 00 01 00 02")
    assert result.out.split() == ["03", "04", "00", "01", "00", "02"]
    assert "holding" in result.err
    assert takt("raw", target, "03", "00", "01", "00", "02").out == result.out
    assert takt("raw", target, "0300010002").out == result.out


def test_ipv6():
    try:
        with socket.socket(socket.AF_INET6) as probe:
            probe.bind(("::1", 0))
    except OSError:
        pytest.skip("no IPv6 on this machine")
    target = f"[::1]:{free_port()}"
    with start("serve", "--listen", target, "--unit", 1, "--fill", "ramp") as running:
        until(lambda: takt("read", f"tcp://{target}", "holding", 3, code=None).code == 0, "an answer")
        running.interrupt()


def test_the_random_fill_is_not_zero(device):
    values = takt("read", device("random"), "holding", 0, 50, "--json").json["values"]
    assert len(set(values)) > 10


@pytest.mark.parametrize("arguments, allowed", [
    (["plna", "x"], "plan"),
    (["read", "tcp://127.0.0.1:1", "holdign", 0], "holding"),
    (["read", "tcp://127.0.0.1:1", "holding", 0, "--type", "strnig"], "string"),
    (["serve", "--fill", "full"], "ramp"),
    (["read", "tcp://127.0.0.1:1", "holding", 0, "--timeout", "0s"], "1ms"),
])
def test_an_unknown_word_is_reported_with_the_allowed_ones(arguments, allowed):
    result = takt(*arguments, code=2)
    assert allowed in result.err
    assert not any(ord(c) < 32 and c != "\n" for c in result.err)
