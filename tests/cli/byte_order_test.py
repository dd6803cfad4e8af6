"""The order of bytes as people see it: a permutation in the project, in reports and in tables."""
import pytest

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
    orders = {name: order for r in requests for name, order in zip(r["variables"], r["byte_orders"], strict=True)}
    assert orders == {"F": "4321", "W": "12", "Q": "21436587", "B": None, "G": "2143"}
    assert "D 4321 (W 12, Q 21436587)" in takt("plan", path).out
    assert takt("check", path, "--json").json["devices"] == [
        {"line": "L", "name": "D", "unit": 1, "byte_order": "4321",
         "variables": [{"name": "W", "byte_order": "12"}, {"name": "Q", "byte_order": "21436587"}]},
        {"line": "L", "name": "E", "unit": 2, "byte_order": "2143", "variables": []}]


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
    orders = [order for r in takt("plan", whole, "--json").json["lines"][0]["requests"] for order in r["byte_orders"]]
    assert sorted(map(str, orders)) == ["12", "2143", "21436587", "4321", "None"]


def test_the_words_of_the_ide_are_read(tmp_path):
    table = tmp_path / "t.csv"
    table.write_text("Имя;Тип;Регистр;Функция чтения;Порядок байт\nF;Вещественный;0;3;Float: 2 1 4 3\n",
                     encoding="utf-8")
    assert 'byte_order: "2143"' in takt("convert", table).out


@pytest.mark.parametrize("language, part", [("en", "contradicts"), ("ru", "противоречит"), ("uk", "суперечить")])
def test_a_contradiction_is_a_finding(project, language, part):
    path = project(PROJECT.replace('byte_order: "4321"', 'byte_order: "4321"\n        high_byte_first: false'))
    [finding] = takt("check", path, "--json", "--lang", language, code=1).json["findings"]
    assert (finding["code"], finding["line"], finding["allowed"]) == ("byte_order.contradiction", 9, "true")
    assert part in finding["message"]
