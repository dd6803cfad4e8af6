"""The four tables of the IDE, typed as their source prints them: to one project, and back in the same words."""
import pytest

from program import takt

STANDARD = """\
Имя переменной;Тип переменной;Энергонезависимость;Значение по умолчанию;Использование в проекте;Комментарий
r1;Целочисленн...;☑;1;Да;
r2;Целочисленное;☑;0;Да;
Var1;Булевское;☐;0;Нет;
< не выбрана >;Булевское;☐;0;Нет;
"""
MASTER = """\
Имя переменной;Тип переменной;Функция чтения;Функция записи;Адрес регистра;Адрес бита (ов);Комментарий
Variable-1;Булевское;0x01;0x05;0;0;
< не выбрана >;Булевское;0x01;0x05;0;1;
"""
SLAVE = """\
Имя переменной;Тип переменной;Адрес регистра;Использование в проекте;Комментарий
Variable;Целочисленное;513;Да;
< не выбрана >;Целочисленное;512;Нет;
"""


@pytest.fixture
def tables(tmp_path):
    paths = [tmp_path / name for name in ("Стандартные.csv", "Устройство, 16.csv", "Слот 2.csv")]
    for path, text in zip(paths, (STANDARD, MASTER, SLAVE), strict=True):
        path.write_text(text, encoding="utf-8")
    return paths


def test_several_tables_make_one_project(tables, tmp_path):
    out = tmp_path / "out.yaml"
    result = takt("convert", *tables, "-o", out)
    assert "error" not in result.err
    text = out.read_text(encoding="utf-8")
    assert "{name: Variable-1, type: bool, read: 0x01, write: 0x05, register: 0, bit: 0}" in text
    assert "{name: r1, type: int16, retain: true, default: 1, used: true}" in text
    assert "name: Устройство\n        address: 16" in text and "не выбрана" not in text
    takt("check", out)
    for kind, table in (("locals", STANDARD), ("variables", MASTER), ("server", SLAVE)):
        back = takt("convert", out, "--to", "csv", "--table", kind, "--headings", "ide", "--separator",
                    "semicolon").out
        rows = [row for row in table.replace("Целочисленн...", "Целочисленное").splitlines() if row[0] != "<"]
        if kind == "variables":
            rows = [("Линия;Устройство;Адрес устройства;", "line;Устройство;16;")[n] + row
                    for n, row in enumerate(rows)]
        assert back.splitlines() == rows


def test_a_slave_table_alone_is_a_serial_server(tables, tmp_path):
    out = tmp_path / "slave.yaml"
    takt("convert", tables[2], "-o", out, "--unit", "16", "--target", "rtu:///dev/ttyS3?baud=9600")
    text = out.read_text(encoding="utf-8")
    assert "port: /dev/ttyS3" in text and "address: 16" in text and "lines:" not in text
    takt("check", out)


def test_several_files_are_tables_of_one_project(tables, tmp_path):
    assert "--to yaml" in takt("convert", *tables, "-o", tmp_path / "out.csv", code=2).err
    project = tmp_path / "p.yaml"
    takt("convert", *tables, "-o", project)
    takt("convert", tables[0], project, "-o", tmp_path / "q.yaml", code=2)


def test_unknown_columns(tmp_path):
    table = tmp_path / "t.csv"
    table.write_text("Имя;Тип;Регистр;Функция чтения;Цвет\nT;Целочисленное;0;0x03;красный\n", encoding="utf-8")
    result = takt("convert", table)
    assert 'comment: "Цвет: красный"' in result.out and "warning" in result.err
    assert "Цвет" in takt("convert", table, "--strict", code=1).err


@pytest.mark.parametrize("notation, coil, register", [("coils_at_20001", "20001", "40001"),
                                                      ("zero_based", "20000", "40000")])
def test_classic_numbers_as_the_sources_print_them(tmp_path, notation, coil, register):
    table = tmp_path / "t.csv"
    table.write_text(f"name,type,read,register\nC,bool,1,{coil}\nR,int,3,{register}\n")
    out = takt("convert", table, "--notation", notation).out
    assert 'reference: "00001"' in out and 'reference: "40001"' in out
