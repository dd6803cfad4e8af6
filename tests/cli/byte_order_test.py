"""The order of bytes as people see it: a permutation in the project, in reports and in tables."""
import json
import struct

import pytest

from fake_slave import Device, TcpSlave
from program import takt

PROJECT = """\
takt: 1
lines:
  - name: L
    port: /dev/ttyS0
    devices:
      - name: D
        address: 1
        byte_order: "4321"
        variables:
          - {name: F, type: float, register: 0, read: 3}
          - {name: W, type: int, register: 2, read: 3, byte_order: "12"}
          - {name: Q, type: double, register: 4, read: 3, high_register_first: false}
          - {name: B, type: bool, coil: 4, read: 1}
      - {name: E, address: 2, variables: [{name: G, type: float, register: 0, read: 3}]}
"""


def test_plan_and_check_show_the_permutation(project):
    path = project(PROJECT)
    requests = takt("plan", path, "--json").json["lines"][0]["requests"]
    orders = {
        name: order
        for r in requests for name, order in zip(r["variables"], r["byte_orders"], strict=True)
    }
    assert orders == {"F": "4321", "W": "12", "Q": "21436587", "B": None, "G": "2143"}
    assert "D 4321 (W 12, Q 21436587)" in takt("plan", path).out
    assert takt("check", path, "--json").json["devices"] == [{
        "line": "L",
        "name": "D",
        "unit": 1,
        "byte_order": "4321",
        "variables": [{
            "name": "W",
            "byte_order": "12"
        }, {
            "name": "Q",
            "byte_order": "21436587"
        }]
    }, {
        "line": "L",
        "name": "E",
        "unit": 2,
        "byte_order": "2143",
        "variables": []
    }]


@pytest.mark.parametrize("headings, heading", [("keys", "byte_order"), ("ru", "Порядок байт"),
                                               ("uk", "Порядок байтів"), ("en", "Byte order")])
def test_a_table_has_the_permutation(project, tmp_path, headings, heading):
    table = tmp_path / "t.csv"
    takt("convert", project(PROJECT), "-o", table, "--headings", headings)
    head, *rows = [line.split(",") for line in table.read_text(encoding="utf-8").splitlines()]
    column = head.index(heading)
    assert [row[column] for row in rows] == ["4321", "3412", "2143", "", ""]  # a coil has no bytes
    whole = tmp_path / "whole.yaml"
    takt("convert", table, "-o", whole)
    assert 'byte_order: "4321"' in whole.read_text(encoding="utf-8")
    orders = [
        order for r in takt("plan", whole, "--json").json["lines"][0]["requests"]
        for order in r["byte_orders"]
    ]
    assert sorted(map(str, orders)) == ["12", "2143", "21436587", "4321", "None"]


def test_the_words_of_the_ide_are_read(tmp_path):
    table = tmp_path / "t.csv"
    table.write_text("Имя;Тип;Регистр;Функция чтения;Порядок байт\nF;Вещественный;0;3;Float: 2 1 4 3\n",
                     encoding="utf-8")
    assert 'byte_order: "2143"' in takt("convert", table).out


@pytest.mark.parametrize("language, part", [("en", "contradicts"), ("ru", "противоречит"),
                                            ("uk", "суперечить")])
def test_a_contradiction_is_a_finding(project, language, part):
    path = project(PROJECT.replace('byte_order: "4321"',
                                   'byte_order: "4321"\n        high_byte_first: false'))
    [finding] = takt("check", path, "--json", "--lang", language, code=1).json["findings"]
    assert (finding["code"], finding["line"], finding["allowed"]) == ("byte_order.contradiction", 9, "true")
    assert part in finding["message"]


NAMES = [("ABCD", "4321"), ("CDAB", "2143"), ("BADC", "3412"), ("DCBA", "1234"), ("AB", "21"), ("BA", "12"),
         ("ABCDEFGH", "87654321"), ("GHEFCDAB", "21436587"), ("BADCFEHG", "78563412"),
         ("HGFEDCBA", "12345678")]


@pytest.mark.parametrize("letters, digits", NAMES, ids=[n for n, _ in NAMES])
def test_a_name_is_its_permutation_everywhere(planned_orders, letters, digits):
    """In a project and in a table."""
    for orders in planned_orders:
        assert [orders[f"{letters}_{form}"] for form in ("letters", "digits", "small")] == [digits] * 3


@pytest.fixture(scope="module")
def planned_orders(tmp_path_factory):
    """The order of a variable for each name, in each form, planned from a project and from a table of all of
    them."""
    folder = tmp_path_factory.mktemp("orders")
    rows = []
    for letters, digits in NAMES:
        kind = {2: "int", 4: "float", 8: "double"}[len(digits)]
        for form, order in (("letters", letters), ("digits", digits), ("small", letters.lower())):
            rows.append((f"{letters}_{form}", kind, 20 + 4 * len(rows), order))
    project, table, whole = folder / "project.yaml", folder / "t.csv", folder / "whole.yaml"
    entries = "".join(f"          - {{name: {name}, type: {kind}, register: {at}, read: 3, "
                      f"byte_order: {order}}}\n" for name, kind, at, order in rows)
    own = "          - {name: F, type: float, register: 0, read: 3}\n"
    assert own in PROJECT
    project.write_text(PROJECT.replace(own, own + entries))
    table.write_text("name,type,register,read,byte_order\n" + "".join(f"{name},{kind},{at},3,{order}\n"
                                                                      for name, kind, at, order in rows))
    takt("convert", table, "-o", whole)
    return [{
        name: order
        for line in takt("plan", path, "--json").json["lines"] for r in line["requests"]
        for name, order in zip(r["variables"], r["byte_orders"], strict=True)
    } for path in (project, whole)]


def test_the_plan_names_the_orders(project):
    assert "4321 = ABCD" in takt("plan", project(PROJECT)).out


def words(kind, value):
    return struct.unpack(f">{struct.calcsize(kind) // 2}H", struct.pack(f">{kind}", value))


def test_a_range_in_every_type_and_order():
    device = Device(dict(enumerate((*words("f", 21.5), *words("i", -70000)), start=10)))
    with TcpSlave(device.over_tcp) as slave:
        url = f"tcp://127.0.0.1:{slave.port}"
        result = takt("read", url, "holding", 10, 4, "--type", "all", "--json").json
        shown = {(v["address"], v["type"], v["order"]): v["value"] for v in result["values"]}
        assert shown[10, "float", "ABCD"] == 21.5 and shown[12, "int32", "ABCD"] == -70000
        assert result["registers"][0] == {"address": 10, "hex": "41AC", "binary": "0100000110101100"}
        # NaN differs from itself; the whole numbers show every order.
        whole = [v for v in result["values"] if v["type"] not in ("string", "double", "float")]
        assert all(v["byte_order"] == dict(NAMES)[v["order"]] for v in whole)
        named = [f"holding:{v['address']}:1:{v['type']}:{v['order']}" for v in whole]
        watched = takt("read", url, "holding", 0, "--watch", "--for", "1ms", "--json",
                       *(part for each in named for part in ("--also", each)))
        sample = json.loads(watched.lines[0])["values"][1:]
        assert [v["value"] for v in sample] == [v["value"] for v in whole], "as alone"
        for value in {v["type"]: v for v in whole}.values():  # one of each type
            alone = takt("read", url, "holding", value["address"], "--type", value["type"], "--order",
                         value["order"], "--json")
            assert alone.json["values"] == [value["value"]]
        text = takt("read", url, "holding", 10, "--type", "all")
        assert max(map(len, text.lines)) <= 80 and "21.5" in text.out and "ABCD 4321" in text.out
        for other in (["--watch"], ["--order", "ABCD"], ["--length", 4]):
            assert other[0] in takt("read", url, "holding", 10, "--type", "all", *other, code=2).err


def test_also_takes_a_type_of_its_own():
    device = Device(dict(enumerate((*words("f", 21.5), *words("i", -70000)), start=10)))
    with TcpSlave(device.over_tcp) as slave:
        result = takt("read", f"tcp://127.0.0.1:{slave.port}", "holding", 10, "--watch", "--for", "1ms",
                      "--json", "--also", "holding:10:float:ABCD", "--also", "input:12:1:int32:4321")
        sample = json.loads(result.lines[0])
        assert [(v["area"], v["address"], v["type"], v["value"])
                for v in sample["values"]] == [("holding", 10, "uint16", 0x41AC),
                                               ("holding", 10, "float", 21.5), ("input", 12, "int32", -70000)]
