"""The four tables of the IDE, typed as their source prints them: to one project, and back in the same
words."""
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
    table.write_text("Имя;Тип;Регистр;Функция чтения;Цвет\nT;Целочисленное;0;0x03;красный\n",
                     encoding="utf-8")
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


SERVED = "Имя переменной;Тип переменной;Адрес регистра;Использование в проекте;Комментарий\n"


def converted(tmp_path, text, *options, name="t.csv", code=0):
    table = tmp_path / name
    table.write_text(text, encoding="utf-8")
    return takt("convert", table, "--to", "yaml", *options, code=code)


@pytest.mark.parametrize("options",
                         [["--notation", "standard"], ["--addresses", "reference"], ["--addresses", "auto"]])
def test_a_slave_table_may_have_classic_numbers(tmp_path, options):
    text = SERVED + "A;Целочисленное;40513;Да;\nB;С плавающей запятой;40515;Нет;\n"
    assert "{area: holding_register, items: [512..515]}" in converted(tmp_path, text, *options).out


@pytest.mark.parametrize("notation, coil, register", [("coils_at_20001", 16, 512), ("zero_based", 17, 513)])
def test_a_slave_table_may_have_another_notation(tmp_path, notation, coil, register):
    result = converted(tmp_path, SERVED + "A;Целочисленное;513;Да;\nC;Булевское;20017;Да;\n", "--notation",
                       notation)
    assert f"{{area: coil, items: [{coil}..{coil}]}}" in result.out
    assert f"{{area: holding_register, items: [{register}..{register}]}}" in result.out


def test_a_bad_register_does_not_hide_the_banks_of_the_others(tmp_path):
    text = SERVED + "A;С плавающей запятой;512;Да;\nE;С плавающей запятой;65535;Да;\n"
    errors = converted(tmp_path, text, code=1).err
    assert "exceeds the last address" in errors and "in no bank" not in errors


def test_a_server_comes_back_from_its_table(tmp_path):
    project = tmp_path / "p.yaml"
    project.write_text(
        """\
takt: 1
servers:
  - name: s
    listen: 127.0.0.1
    units:
      - address: 1
        high_register_first: true
        banks:
          - {area: holding_register, items: [0..9]}
          - {area: input_register, items: [0..9]}
          - {area: coil, items: [0..99]}
        variables:
          - {name: A, type: int16, area: holding_register, register: 3}
          - {name: B, type: float, area: input_register, register: 4, used: false}
          - {name: C, type: bool, area: coil, coil: 20}
""", encoding="utf-8")
    for headings in ("ide", "keys", "en"):
        table = tmp_path / f"{headings}.csv"
        takt("convert", project, "-o", table, "--table", "server", "--headings", headings)
        back = takt("convert", table, "--to", "yaml").out
        assert "servers:" in back and "lines:" not in back
        assert "{area: coil, items: [20..20]}" in back and "{area: input_register, items: [4..5]}" in back
        assert 'byte_order: "4321"' in back


def test_a_slave_table_without_variables_is_a_server(tmp_path):
    out = converted(tmp_path, SERVED + "< не выбрана >;Целочисленное;512;Нет;\n").out
    assert "servers:" in out and "lines:" not in out


def test_variables_without_functions_are_imported_with_a_warning(tmp_path):
    result = converted(
        tmp_path,
        MASTER.splitlines()[0] + "\nA;Целочисленное;Нет;Нет;0;;\n"
        "B;Целочисленное;< не выбрана >;Нет;1;;\nC;Целочисленное;;;2;;\nD;Булевское;Нет;Нет;2;1;\n")
    assert result.err.count("the variable is neither read nor written") == 4 and "error" not in result.err
    assert result.out.count("read: none") == 4


def test_the_address_of_two_devices_is_found_in_their_tables(tables, tmp_path):
    other = tmp_path / "Прибор, 16.csv"
    other.write_text(MASTER.replace("Variable-1", "Other"), encoding="utf-8")
    errors = takt("convert", tables[1], other, "--to", "yaml", code=1).err
    assert f"{other}:1:1: error: lines[0].devices[1].address" in errors and f"{tables[1]}:1\n" in errors


def test_a_number_outside_the_notation_is_quoted_as_typed(tmp_path):
    text = MASTER.splitlines()[0] + "\nc;Булевское;0x01;0x05;20000;;\nh;Целочисленное;0x03;Нет;40108;;\n"
    errors = converted(tmp_path, text, "--notation", "coils_at_20001", code=1).err
    assert ":2:23: error: the number 20000" in errors and "20001..29999" in errors and "00000" not in errors
    assert converted(tmp_path, text, "--notation", "zero_based").out


def test_options_that_contradict_the_table(tmp_path):
    table = tmp_path / "t.csv"
    table.write_text(MASTER, encoding="utf-8")
    assert "--addresses zero-based" in takt("convert", table, "--notation", "zero_based", "--addresses",
                                            "zero-based", code=2).err
    assert "--table" in takt("convert", table, "--table", "server", code=2).err


def test_the_placeholder_is_none_in_a_project_too(tmp_path):
    project = tmp_path / "p.yaml"
    project.write_text(
        """\
takt: 1
lines:
  - name: Node1
    port: /dev/ttyUSB0
    devices:
      - name: Device1
        address: 16
        turnaround: 5ms
        status: "< не выбрана >"
        poll_enable: "‹ не выбрана ›"
        byte_order: "Float: 2 1 4 3"
        variables:
          - {name: V, type: float, register: 0, read: 0x03, write: "< не выбрана >", status: "< не выбр...",
             read_trigger: "<не выбрана>"}
          - {name: "< не выбрана >", type: float, register: 2, read: 0x03}
""", encoding="utf-8")
    result = takt("check", project)
    assert "errors: 0, warnings: 0" in result.out + result.err
    table = takt("convert", project, "--to", "csv", "--headings", "ide").out
    assert "2143" in table and "не выб" not in table


def test_a_comment_that_is_cut_is_reported(tmp_path):
    long = "я" * 1100
    text = "Имя;Тип;Регистр;Функция чтения;Цвет\n" \
        f"A;Целочисленное;0;0x03;{long}Ъ\nB;Целочисленное;1;0x03;{long}\n"
    result = converted(tmp_path, text)
    assert result.err.count("longer than 1000 characters") == 1 and "the comments of 2 rows" in result.err
    assert ":2:" in result.err and "яяя" in result.err


def test_a_heading_that_is_cut_too_much_is_reported(tmp_path):
    result = converted(tmp_path, "Имя;Тип;Адрес регистра;Функция ...\nA;Целочисленное;0;0x03\n")
    assert "it is read as Функция чтения" in result.err and "read: 0x03" in result.out
    both = converted(tmp_path,
                     "Имя;Тип;Адрес регистра;Функция ...;Функция ...\nA;Целочисленное;0;0x03;0x10\n")
    assert "read: 0x03" in both.out and "write: 0x10" in both.out
    twice = converted(tmp_path, "Имя;Тип;Адрес регистра;Комментарий;Комментарий\nA;Целочисленное;0;;\n",
                      code=1)
    assert "the columns Комментарий (4) and Комментарий (5)" in twice.err


def test_the_export_has_the_words_of_the_ide(tmp_path):
    project = tmp_path / "p.yaml"
    project.write_text(
        """\
takt: 1
lines:
  - name: L
    port: /dev/ttyUSB0
    devices:
      - name: D
        address: 16
        turnaround: 5ms
        variables:
          - {name: A, type: float, area: holding_register, register: 0, high_byte_first: true,
             high_register_first: false}
          - {name: B, type: bool, reference: "10001"}
          - {name: C, type: int, register: 4, write: 0x10, write_on_change: true, used: false}
""", encoding="utf-8")
    options = ["--to", "csv", "--headings", "ide", "--separator", "semicolon"]
    result = takt("convert", project, *options)
    head, *rows = result.out.splitlines()
    assert head == (
        "Линия;Устройство;Адрес устройства;Имя переменной;Тип переменной;Функция чтения;Функция записи;"
        "Адрес регистра;Адрес бита (ов);Комментарий;Обозначение 40001;Запись по изменению;"
        "Использование в проекте;Старшим байтом вперед;Старшим регистром вперед")
    assert [row.split(";")[5:7] for row in rows] == [["0x03", "Нет"], ["0x02", "Нет"], ["Нет", "0x10"]]
    assert [row.split(";")[11:] for row in rows] == [["☐", "", "☒", "☐"], ["☐", "", "", ""],
                                                     ["☑", "Нет", "", ""]]
    before = takt("plan", project, "--json").json["lines"]
    for table in ("variables", "list"):
        exported = tmp_path / f"{table}.csv"
        takt("convert", project, *options, "--table", table, "-o", exported)
        back = tmp_path / f"{table}.yaml"
        takt("convert", exported, "-o", back)
        after = takt("plan", back, "--json").json["lines"]
        assert [r["variables"]
                for r in after[0]["requests"]] == [r["variables"] for r in before[0]["requests"]]
        assert [r["function"] for r in after[0]["requests"]] == [r["function"] for r in before[0]["requests"]]
    assert ";Тип;" in takt("convert", project, *options, "--table", "list").out


DEVICE = """\
Имя;Device1
Адрес;16
Период опроса, мс;200
Таймаут ответа, мс;150
Кол-во попыток;3
Статус;state
Опрос;< не выбрана >
Протокол;Modbus ASCII
Группировать запросы;Да
Кол-во регистров в запросе;60
Порядок байт;Float: 2 1 4 3
Старшим байтом вперед;☒
Старшим регистром вперед;☐
Комментарий;boiler
"""
SETTINGS = [
    "name: Device1", "address: 16", "poll_period: 200ms", "response_timeout: 150ms", "attempts: 3",
    "status: state", "group_requests: true", "registers_per_request: 60", 'byte_order: "2143"',
    "comment: boiler", "framing: ascii", "{name: state, type: int}"
]


# As the window prints it; the device has the name that the IDE gives to a new one.
PRINTED = """\
Имя;Устройство
Адрес;16
Период опроса, мс;100
Таймаут ответа, мс;100
Кол-во попыток;3
Группировать запросы;Да
Кол-во регистров в запросе;20
Порядок байт;☒ Старшим байтом вперед ☐ Старшим регистром вперед
"""
ORDER = PRINTED.splitlines()[-1]


def as_one_row(window):
    return "\n".join(";".join(cells)
                     for cells in zip(*(line.split(";") for line in window.splitlines()))) + "\n"


@pytest.mark.parametrize("text", [DEVICE, "Поле;Значение\n" + DEVICE, as_one_row(DEVICE)])
def test_the_window_of_a_device_is_its_settings(tmp_path, text):
    result = converted(tmp_path, text)
    assert [line for line in SETTINGS if line not in result.out] == []
    assert result.err == "" and "poll_enable" not in result.out and "comment: Т" not in result.out
    listed = tmp_path / "Список.csv"
    listed.write_text("Имя переменной;Тип;Адрес регистра;Комментарий\nV;Целочисленное;7;\n", encoding="utf-8")
    both = takt("convert", tmp_path / "t.csv", listed, "--to", "yaml").out
    assert [line for line in SETTINGS if line not in both] == []
    assert both.count("address: ") == 1 and "{name: V, type: int16, register: 7" in both


@pytest.mark.parametrize("name", ["Устройство", "Device", "Адрес", "Статус", "Тип", "Период", "Device1"])
@pytest.mark.parametrize("separator", [";", "\t"])
@pytest.mark.parametrize("more", ["", "Float;2 1 4 3\n"])
def test_a_device_may_have_the_name_of_a_field(tmp_path, name, separator, more):
    window = PRINTED.replace(";Устройство", f";{name}") + more
    result = converted(tmp_path, window.replace(";", separator))
    settings = [
        f"name: {name}", "address: 16", "poll_period: 100ms", "response_timeout: 100ms", "attempts: 3",
        "group_requests: true", "registers_per_request: 20", 'byte_order: "2143"'
    ]
    assert [line for line in settings if line not in result.out] == []
    assert result.err == "" and "type:" not in result.out


@pytest.mark.parametrize("order, digits", [
    ("Порядок байт;☒ Старшим байтом вперед, ☒ Старшим регистром вперед", "4321"),
    ("Порядок байт;☒ Старшим байтом вперед;☐ Старшим регистром вперед;Float: 2 1 4 3", "2143"),
    ("Порядок байт;☐ Старшим байтом вперед ☐ Старшим регистром вперед\nFloat;1 2 3 4", "1234"),
    ("Порядок байт;[x] Старшим байтом вперед [ ] Старшим регистром вперед", "2143"),
    ("Порядок байт;Старшим байтом вперед ☒ Старшим регистром вперед ☐", None),
    ("Порядок байт;\n☒ Старшим байтом вперед\n☐ Старшим регистром вперед\nFloat: 2 1 4 3", "2143"),
])
def test_the_order_of_bytes_as_the_window_shows_it(tmp_path, order, digits):
    result = converted(tmp_path, PRINTED.replace(ORDER, order), code=0 if digits else 1)
    if digits:
        assert result.err == "" and f'byte_order: "{digits}"' in result.out


def test_two_orders_of_bytes_are_an_error(tmp_path):
    errors = converted(tmp_path, PRINTED + "Float;4 3 2 1\n", code=1).err
    assert "two values for `byte_order`: 2143 and 4321" in errors and errors.count("error:") == 1


def test_devices_of_the_same_name_have_their_own_windows(tmp_path):
    windows = [tmp_path / f"{n}.csv" for n in "ab"]
    lists = [tmp_path / f"Устройство, {n}.csv" for n in (17, 16)]
    for n, (window, listed) in enumerate(zip(windows, lists, strict=True)):
        settings = PRINTED.replace("16", str(16 + n)).replace("опроса, мс;100", f"опроса, мс;{n + 1}00")
        window.write_text(settings, encoding="utf-8")
        listed.write_text("Имя переменной;Тип;Адрес регистра;Комментарий\n"
                          f"V{17 - n};Целочисленное;7;\n", encoding="utf-8")
    out = takt("convert", *windows, *lists, "--to", "yaml").out
    devices = out.split("- name: Устройство")[1:]
    assert [("address: 17" in d, "poll_period: 200ms" in d, "name: V17" in d) for d in devices] == [
        (True, True, True), (False, False, False)]


def test_a_table_of_variables_that_are_named_like_fields(tmp_path):
    out = converted(tmp_path, "Имя;Тип\nПериод;Целочисленное\nСтатус;Целочисленное\nОпрос;Булевское\n",
                    code=1).err
    assert out.count(".area: the area of the variable is not given") == 3


def test_the_number_of_registers_counts_only_where_requests_are_grouped(tmp_path):
    result = converted(tmp_path, DEVICE.replace("запросы;Да", "запросы;Нет"))
    assert "group_requests: false" in result.out and "registers_per_request: 60" in result.out
    assert result.err == ""


def test_the_window_of_a_variable_is_a_variable(tmp_path):
    result = converted(
        tmp_path, "Имя;V1\nТип;Целочисленное\nРегистр;5\nБит;0\nФункция чтения;0x03\nФункция записи;0x10\n"
        "Запись по изменению;☑\nКоличество регистров;2\nЗапуск чтения;go\nСтатус;< не выбрана >\n")
    assert "{name: V1, type: int32, register: 5, read: 0x03, write: 0x10, write_on_change: true, " \
        "read_trigger: go}" in result.out


def test_columns_of_the_device_are_its_settings(tmp_path):
    head = "Имя;Тип;Функция чтения;Адрес регистра;Таймаут ответа, мс;Кол-во попыток;Протокол\n"
    rows = "A;Целочисленное;0x03;0;150;5;Modbus RTU\nB;Целочисленное;0x03;1;150;{};Modbus RTU\n"
    result = converted(tmp_path, head + rows.format(5))
    assert "response_timeout: 150ms" in result.out and "attempts: 5" in result.out and result.err == ""
    assert "{name: A, type: int16, read: 0x03, register: 0}" in result.out
    again = takt("convert", tmp_path / "t.csv", "--to", "csv").out
    assert "response_timeout" in again.splitlines()[0] and "150ms" in again
    assert "two values for `attempts`: 5 and 6" in converted(tmp_path, head + rows.format(6), code=1).err
    project = tmp_path / "p.yaml"
    (tmp_path / "t.csv").write_text(head + rows.format(5), encoding="utf-8")
    project.write_text(
        "takt: 1\nlines: [{name: L, port: p, devices: [{name: D, address: 1, turnaround: 5ms, variables: "
        "t.csv}]}]\n")
    assert takt("check", project).out.count("is a setting of the device") == 3


TREE = "RS485, Слот 1, Master\nУстройство, 16\n"
LIST = "Имя переменной;Тип;Адрес регистра;Комментарий\nVar1;С плавающей запя...;0;\nVar2;Целочисленное;2;\n"
DEVICE_16 = ["name: Устройство", "address: 16", "poll_period: 100ms", "group_requests: true",
             "registers_per_request: 20", "{name: Var1, type: float, register: 0", "{name: Var2, type: int16"]


@pytest.mark.parametrize("text", [
    PRINTED + LIST,
    PRINTED + "\n" + LIST.replace(";", "\t"),
    TREE + PRINTED + LIST,
    "RS485\nСлот 1\nMaster\n" + PRINTED + "\n\n" + LIST,
    "RS485\n└── Слот 1, Master\n│     └─ Устройство, 16\n" + PRINTED + LIST,
    PRINTED.replace(";", ": ") + LIST,
    PRINTED.replace(";", "\t") + LIST,
])
def test_a_window_and_its_table_are_one_device(tmp_path, text):
    result = converted(tmp_path, text)
    assert [its for its in DEVICE_16 if its not in result.out] == []
    assert result.out.count("- name: ") == 2 and "error" not in result.err
    assert result.out.count("{name: ") == 2


def test_several_windows_with_their_tables_are_several_devices(tmp_path):
    second = TREE.replace("16", "17") + PRINTED.replace("16", "17") + LIST.replace("Var", "Other")
    out = converted(tmp_path, TREE + PRINTED + LIST + "\n" + second).out
    devices = out.split("- name: Устройство")[1:]
    assert [("address: 17" in d, "Var1" in d, "Other2" in d) for d in devices] == [
        (False, True, False), (True, False, True)]
    listed = converted(tmp_path, TREE + LIST + TREE.replace("16", "17") + LIST.replace("Var", "Other")).out
    assert [d.count("type:") for d in listed.split("- name: Устройство")[1:]] == [2, 2]


@pytest.mark.parametrize("text, settings", [
    ("Имя;Котёл\nАдрес;16\n", ["name: Котёл", "address: 16"]),
    ("Имя;Устройство\nАдрес;16\nКол-во попыток;5\n",
     ["name: Устройство", "address: 16", "attempts: 5"]),
    ("Адрес;16\nПериод опроса, мс;200\n", ["name: t", "address: 16", "poll_period: 200ms"]),
    ("Имя: Котёл\nАдрес: 16\nПериод опроса, мс: 200\n",
     ["name: Котёл", "address: 16", "poll_period: 200ms"]),
    ("Котёл, 16\nПериод опроса, мс;200\n", ["name: Котёл", "address: 16", "poll_period: 200ms"]),
    ("Name,Boiler\nAddress,16\nAttempts,5\n", ["name: Boiler", "address: 16", "attempts: 5"]),
])
def test_short_windows(tmp_path, text, settings):
    result = converted(tmp_path, text)
    assert [its for its in settings if its not in result.out] == []
    assert result.err == "" and "type:" not in result.out


def test_a_line_that_is_not_understood_is_an_error(tmp_path):
    def errors(text):
        return converted(tmp_path, text, code=1).err
    assert "t.csv:9:1: error: the line is no headings of a table, no field of a window and no line of a " \
        "tree: Var1;float;0" in errors(PRINTED + "Var1;float;0\nVar2;float;2\n")
    assert "t.csv:3:1" in errors("Имя;Котёл\nАдрес;16\nАдрес;16;17\nКол-во попыток;3\n")
    assert "the tree names the device 17, its window 16" in errors(TREE.replace("16", "17") + PRINTED)
    assert "belongs to no device" in errors(LIST + "\n" + PRINTED + LIST.replace("Var", "X"))
    assert "belongs to no device" in errors(PRINTED + LIST + "\n" + STANDARD)


def test_a_project_names_tables_of_variables_only(tmp_path):
    (tmp_path / "t.csv").write_text(PRINTED + LIST, encoding="utf-8")
    project = tmp_path / "p.yaml"
    project.write_text(
        "takt: 1\nlines: [{name: L, port: p, devices: [{name: D, address: 1, variables: t.csv}]}]\n")
    assert "has the settings of a device" in takt("check", project, code=1).out
    refused = takt("convert", tmp_path / "t.csv", "--to", "csv", code=2).err
    assert "one table cannot hold the settings" in refused


def test_rows_that_look_like_a_tree_or_a_window_are_rows(tmp_path):
    out = converted(tmp_path, LIST + "Master;Булевское;5;\nСлот 1;Булевское;6;\nИмя;Целочисленное;8;\n"
                    "Статус;Целочисленное;9;\n\nТип;Целочисленное;10;\n").out
    assert out.count("type: ") == 7
