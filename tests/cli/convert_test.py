"""`takt convert`: tables of variables to projects, to other tables, and back."""
import json
import pathlib
import re

import pytest

from program import ROOT, takt

IDE = ROOT / "examples" / "boiler-ide.csv"
PROJECT = """\
takt: 1
lines:
  - name: rs485-1
    port: /dev/ttyUSB0
    devices:
      - name: Boiler
        address: 16
        poll_period: 2s
        variables:
          - {name: T1, type: float, register: 0, read: 0x03, write: 0x10, write_trigger: go,
             comment: "a; \\"b\\""}
          - {name: Насос, type: bool, coil: 7, read: 0x01}
      - name: Meter
        address: 17
        variables:
          - {name: P, type: int32, reference: "40108", scale: 0.1, unit: кВт}
locals:
  - {name: go, type: bool}
"""


def variables(text):
    """The lines of a project's variables."""
    return [
        line.strip() for line in text.split("locals:")[0].splitlines() if line.strip().startswith("- {name")
    ]


def test_the_table_of_the_ide_becomes_a_project_that_can_be_planned(tmp_path):
    out = tmp_path / "boiler.yaml"
    result = takt("convert", IDE, "-o", out, "--device", "Котёл", "--unit", 16, "--target",
                  "rtu:///dev/ttyS1?baud=9600&parity=none")
    assert result.out == "" and "4" in result.err
    text = out.read_text(encoding="utf-8")
    assert "port: /dev/ttyS1" in text and "baud: 9600" in text and "address: 16" in text
    assert variables(text)[1] == ('- {name: Давление, type: int16, read: 0x04, write: none, register: 0x10, '
                                  'comment: "Коллектор; в барах", period: 500ms, scale: 0.01, unit: бар}')
    takt("check", out)
    plan = takt("plan", out, "--json").json
    assert sum(len(r["variables"]) for r in plan["lines"][0]["requests"]) == 4


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1251"])
def test_a_project_may_name_the_table_of_the_ide(project, tmp_path, encoding):
    text = IDE.read_text(encoding="utf-8").replace("Датчик на выходе котла", '"два\nряда"')
    (tmp_path / "boiler.csv").write_bytes(text.replace("\n", "\r\n").encode(encoding))
    path = project("takt: 1\nlines: [{name: L, port: /dev/ttyS0, devices: "
                   "[{name: D, address: 1, variables: boiler.csv}]}]\n")
    findings = takt("check", path, "--json").json["findings"]
    assert [f for f in findings if not f["code"].startswith("guarantee.")] == []
    assert takt("convert", tmp_path / "boiler.csv").out == takt("convert",
                                                                tmp_path / "boiler.csv", "--encoding",
                                                                encoding.replace("-sig", "")).out


@pytest.fixture(scope="module")
def plain_table(tmp_path_factory):
    """The device of the project as a table in the form that none asked for."""
    folder = tmp_path_factory.mktemp("plain")
    (folder / "project.yaml").write_text(PROJECT, encoding="utf-8")
    takt("convert", folder / "project.yaml", "-o", folder / "first.csv", "--device", "Boiler")
    takt("convert", folder / "first.csv", "-o", folder / "plain.csv")
    return folder / "plain.csv"


@pytest.mark.parametrize("headings, first", [("en", "Variable name"), ("ru", "Имя переменной"),
                                             ("uk", "Ім'я змінної"), ("keys", "name")])
@pytest.mark.parametrize("separator", ["comma", "semicolon", "tab"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-bom", "cp1251"])
def test_there_and_back(project, tmp_path, plain_table, headings, first, separator, encoding):
    path, table = project(PROJECT), tmp_path / "t.csv"
    takt("convert", path, "-o", table, "--device", "Boiler", "--headings", headings, "--separator", separator,
         "--encoding", encoding)
    text = table.read_bytes().decode(encoding.replace("-bom", "-sig"))
    assert text.startswith(first) and text.count("\r\n") == text.count("\n") == 3
    again = tmp_path / "again.csv"
    takt("convert", table, "-o", again)
    assert again.read_bytes() == plain_table.read_bytes(), "whatever its form was"


def test_a_table_becomes_a_project_and_itself(plain_table, tmp_path):
    back = takt("convert", plain_table).out
    assert variables(back)[0] == ('- {name: T1, type: float, read: 0x03, write: 0x10, register: 0, '
                                  'comment: "a; \\"b\\"", write_trigger: go, period: 2s}')
    assert variables(back)[1] == "- {name: Насос, type: bool, read: 0x01, coil: 7, period: 2s}"
    again = tmp_path / "again.csv"
    takt("convert", plain_table, "-o", again)
    once = again.read_bytes()
    takt("convert", again, "-o", again, "--force")
    assert again.read_bytes() == once == plain_table.read_bytes()


def test_all_devices_in_one_table(project, tmp_path):
    table = tmp_path / "all.csv"
    takt("convert", project(PROJECT), "-o", table)
    assert [line.split(",")[:4] for line in table.read_text(encoding="utf-8").splitlines()
            ] == [["line", "device", "unit_address", "name"], ["rs485-1", "Boiler", "16", "T1"],
                  ["rs485-1", "Boiler", "16", "Насос"], ["rs485-1", "Meter", "17", "P"]]
    whole = tmp_path / "all.yaml"
    takt("convert", table, "-o", whole)
    takt("check", whole)
    assert len(variables(whole.read_text(encoding="utf-8"))) == 3
    one = takt("convert", table, "--device", "Meter").out
    assert "address: 17" in one and len(variables(one)) == 1
    assert "Boiler, Meter" in takt("convert", table, "--device", "Pump", code=2).err


def test_two_lines_there_and_back(project, tmp_path):
    second = PROJECT.replace(
        "locals:", """\
  - name: net
    host: 10.0.0.5
    devices:
      - {name: PLC, address: 1, variables: [{name: L, type: int16, register: 1, read: 0x03}]}
locals:""")
    table, whole = tmp_path / "all.csv", tmp_path / "all.yaml"
    takt("convert", project(second), "-o", table)
    takt("convert", table, "-o", whole)
    lines = takt("plan", whole, "--json").json["lines"]
    assert [line["name"] for line in lines] == ["rs485-1", "net"]
    assert "host: \"10.0.0.5\"" in whole.read_text(encoding="utf-8")
    text = table.read_text(encoding="utf-8").replace("tcp://10.0.0.5:502", "tpc://10.0.0.5")
    table.write_text(text, encoding="utf-8")
    assert "tpc://10.0.0.5" in takt("convert", table, code=1).err


def test_nothing_is_overwritten_unasked(tmp_path):
    out = tmp_path / "out.yaml"
    out.write_text("mine")
    assert "--force" in takt("convert", IDE, "-o", out, code=2).err
    assert out.read_text() == "mine"
    takt("convert", IDE, "-o", out, "--force")
    assert out.read_text(encoding="utf-8").startswith("takt: 1")
    takt("convert", IDE, "-o", tmp_path / "no" / "such.yaml", code=3)
    bad = tmp_path / "bad.csv"
    bad.write_text("name,type,read,register\nA,colour,3,1\nB,int,3,99999\n")
    result = takt("convert", bad, "-o", out, "--force", code=1)
    assert f"{bad}:2:3:" in result.err and "colour" in result.err and f"{bad}:3:9:" in result.err
    assert out.read_text(encoding="utf-8").startswith("takt: 1"), "still the old one"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bad.csv", "out.yaml"]


@pytest.mark.parametrize("options, register", [((), "register: 40108"),
                                               (("--addresses", "auto"), "reference: \"40108\""),
                                               (("--addresses", "zero-based"), "register: 40108"),
                                               (("--addresses", "reference"), "reference: \"40108\"")])
def test_addresses_from_40001(tmp_path, options, register):
    table = tmp_path / "t.csv"
    table.write_text("Name;Type;Read function;Address\nA;int;3;40108\n")
    result = takt("convert", table, *options)
    assert register in result.out
    assert result.err.count("warning: ") == (0 if "reference" in options else 1)


@pytest.mark.parametrize("column, names", [("Slave ID", ["plant 1", "plant 2"]),
                                           ("Device;Slave ID", ["A", "B"])])
def test_a_table_of_several_devices_is_one_project(tmp_path, column, names):
    table, project, again = tmp_path / "plant.csv", tmp_path / "p.yaml", tmp_path / "again.csv"
    rows = [(names[0], 1, "Temp", 0), (names[0], 1, "Only", 1), (names[1], 2, "Temp", 0)]
    table.write_text(f"{column};Name;Type;Function;Address\n" + "".join(
        (f"{device};" if "Device" in column else "") + f"{unit};{name};int;3;{register}\n"
        for device, unit, name, register in rows))
    result = takt("convert", table, "-o", project)
    assert result.err.count("warning: ") == 1 and f"{names[0]}.Temp" in result.err
    line, = json.loads(takt("plan", project, "--json").out)["lines"]
    seen = {(r["device"], r["unit"], v) for r in line["requests"] for v in r["variables"]}
    assert seen == {(names[0], 1, f"{names[0]}.Temp"), (names[0], 1, "Only"),
                    (names[1], 2, f"{names[1]}.Temp")}
    takt("convert", project, "-o", again)
    assert takt("convert", again).err.count("warning") == 0


def test_a_project_a_table_and_a_conversion_warn_alike_of_40001(tmp_path):
    device = "lines: [{name: L, transport: tcp, host: h, devices: [{name: D, address: 1, variables: "
    text = tmp_path / "text.yaml"
    text.write_text(f"takt: 1\n{device}[{{name: A, type: int, register: 40001, read: 3}}]}}]}}]\n")
    table = tmp_path / "t.csv"
    table.write_text("name,type,register,read\nA,int,40001,3\n")
    named = tmp_path / "named.yaml"
    named.write_text(f"takt: 1\n{device}t.csv}}]}}]\n")
    warnings = [[
        line.split("warning: ")[1] for line in (result.out + result.err).splitlines() if "warning: " in line
    ] for result in (takt("convert", table), *(takt("check", p, "--no-notes") for p in (text, named)))]
    assert len(warnings[0]) == 1 and "number 0 of the area holding_register" in warnings[0][0]
    assert warnings[0] == warnings[1] == warnings[2]
    planned = json.loads(takt("plan", named, "--json").out)
    assert planned["lines"][0]["requests"][0]["start"] == 40001
    text.write_text(text.read_text().replace("register", "reference"))
    assert json.loads(takt("plan", text, "--json").out)["lines"][0]["requests"][0]["start"] == 0
    assert "warning:" not in takt("check", text).out


def test_errors_name_unrepresentable_characters(project, tmp_path):
    result = takt("convert", project(PROJECT.replace("кВт", "中")), "--encoding", "cp1251", code=1)
    assert result.out == "" and "中" in result.err and "unit" in result.err and ":16:" in result.err
    texts = {
        language: takt("convert", project(PROJECT.replace("кВт", "中")), "--encoding", "cp1251", "--lang",
                       language, code=1).err
        for language in ("en", "ru", "uk")
    }
    assert len(set(texts.values())) == 3


@pytest.mark.parametrize("content", [
    b"", b"\0", b"\"", b"\xff\xfe\0n", b"," * 100_000, b"name\n\"", b"sep=;\n",
    b"name,type\n" + b"A," * 100_000, "Имя;Тип\n\x98".encode("utf-8"), b"\x98\xff"
], ids=range(10))
def test_hostile_tables(tmp_path, content):
    table = tmp_path / "t.csv"
    table.write_bytes(content)
    result = takt("convert", table, code=None)
    assert result.code in (1, 2) and "t.csv:" in result.err and result.out == ""


def test_bad_usage(tmp_path, project):
    path = project(PROJECT)
    for arguments in [(path, "--to", "yaml"), (path, "-o", tmp_path / "x.yml"), (tmp_path / "x.csv", ),
                      (tmp_path / "x.dat", ), (IDE, "--target", "nowhere"), (IDE, "--addresses", "odd"),
                      (IDE, "--encoding", "koi8-r"), (IDE, "--unit", "300"), ()]:
        assert takt("convert", *arguments, code=2).err
    assert takt("convert", IDE, "--from", "csv", "--to", "csv", "--headings",
                "uk").out.startswith("Ім'я змінної,")
    takt("convert", pathlib.Path("/dev/null"), "--from", "csv", code=2)


def properties_of_a_variable(schema):
    if isinstance(schema, dict):
        own = schema.get("properties", {})
        if "read_trigger" in own and "register" in own:
            return set(own)
    inner = schema.values() if isinstance(schema, dict) else schema if isinstance(schema, list) else []
    return set().union(*(properties_of_a_variable(part) for part in inner))


@pytest.mark.parametrize("language", ["en", "ru", "uk"])
def test_labels_of_the_page_are_headings(tmp_path, language):
    """What a user copies from a form is understood in a table."""
    source = (ROOT / f"ui/src/i18n/{language}/keys.ts").read_text().partition("\n}")[0]
    of_servers = {"source", "writes_to", "answer"}
    known = (properties_of_a_variable(json.loads(takt("schema").out)) | {"attempts"}) - of_servers
    labels = {key: text for key, text in re.findall(r"^  (\w+): '([^']*)',$", source, re.M) if key in known}
    assert len(labels) > 25
    table = tmp_path / "labels.csv"
    table.write_text(";".join(labels.values()) + "\n" + ";" * (len(labels) - 1) + "\n")
    done = takt("convert", table, "--to", "yaml", code=None)
    unknown = [line for line in done.err.splitlines() if "unknown column" in line]
    assert not unknown, unknown
