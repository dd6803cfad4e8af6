"""`takt check`: all findings at once, with their locations, in three languages."""
import functools
import json
import os
import pathlib
import tempfile

import pytest

import program
from program import takt

# Each line that ends in a number has that mistake; the rest is right.
TEN_MISTAKES = """\
takt: 1
profile: generic
lines:
  - name: rs485-1
    transport: serial
    port: /dev/ttyUSB0
    framing: rtu
    bauds: 9600                                                             # 1 no such key
    parity: maybe                                                           # 2 not one of the words
    devices:
      - name: Boiler
        address: 300                                                        # 3 out of range
        poll_period: 25h                                                    # 4 out of range
        attempts: 256                                                       # 5 out of range
        group_requests: true
        strategy: classic
        registers_per_request: 126                                          # 6 out of range
        variables:
          - {name: Good, type: float, register: 0, read: 0x03}
          - {name: Far, type: int16, register: 65536, read: 0x03}           # 7 no such register
          - {name: Good, type: int16, register: 10, read: 0x03}             # 8 a name twice
          - {name: Odd, type: int16, register: 11, read: 0x05}              # 9 not a read function
          - {name: Go, type: bool, register: 1, bit: 16, read: 0x01}        # 10 no such bit
locals:
  - {name: go, type: bool}
"""
MISTAKES = {n: text.rsplit("# ", 1)[1] for n, text in enumerate(TEN_MISTAKES.splitlines(), 1) if "# " in text}


def findings(path, *options):
    return takt("check", path, "--json", *options, code=1).json["findings"]


def test_ten_mistakes_ten_findings(project):
    path = project(TEN_MISTAKES)
    found = findings(path)
    assert sorted(f["line"] for f in found) == sorted(MISTAKES)
    for finding in found:
        assert finding["severity"] == "error"
        assert finding["file"] == str(path) or finding["file"] == path.name
        assert finding["column"] > 0
        assert finding["code"] and finding["path"] and finding["message"] and finding["advice"], finding
    assert len({f["code"] for f in found}) >= 5, "different mistakes, different codes"


@pytest.mark.parametrize("mark, value, allowed", [
    ("1 no", "bauds", ["baud"]),
    ("2 not", "maybe", ["none", "even", "odd"]),
    ("3 out", "300", ["1", "247"]),
    ("4 out", "25h", ["24"]),
    ("5 out", "256", ["1", "255"]),
    ("6 out", "126", ["2", "125"]),
    ("7 no", "65536", ["65535"]),
    ("10 no", "16", ["0", "15"]),
])
def test_a_finding_has_value_and_allowed(project, mark, value, allowed):
    line = next(n for n, text in MISTAKES.items() if text.startswith(mark))
    finding = next(f for f in findings(project(TEN_MISTAKES)) if f["line"] == line)
    assert value in f"{finding['value']} {finding['path']} {finding['message']}"
    for word in allowed:
        assert word in f"{finding['allowed']} {finding['message']} {finding['advice']}", finding


def test_as_text_each_finding_has_file_and_line(project):
    path = project(TEN_MISTAKES)
    result = takt("check", path, code=1)
    for line in MISTAKES:
        assert f"{path.name}:{line}" in result.out, f"line {line}\n{result!r}"


def test_three_languages(project):
    path = project(TEN_MISTAKES)
    messages = {
        language: [f["message"] for f in findings(path, "--lang", language)]
        for language in ("en", "ru", "uk")
    }
    assert all(len(one) == 10 for one in messages.values())
    for en, ru, uk in zip(*messages.values()):
        assert en.isascii() and not ru.isascii() and not uk.isascii()
        assert ru != uk
    cyrillic = " ".join(messages["ru"] + messages["uk"])
    assert "і" in " ".join(messages["uk"]) and "і" not in " ".join(
        messages["ru"]), "Ukrainian and Russian are not mixed up"
    assert "{}" not in cyrillic, "every placeholder is filled"


@pytest.mark.parametrize("variable", ["LC_ALL", "LC_MESSAGES", "LANG"])
def test_the_environment_chooses_the_language(project, variable):
    """Whether that locale is installed or not."""
    path = project(TEN_MISTAKES)
    cleared = {"LC_ALL": "", "LC_MESSAGES": "", "LANG": ""}
    plain = takt("check", path, code=1, **cleared | {variable: "uk_UA.UTF-8"}).out
    assert plain == takt("check", path, "--lang", "uk", code=1).out
    assert takt("check", path, "--lang", "en", code=1, **cleared | {variable: "uk_UA.UTF-8"}).out \
        == takt("check", path, code=1, **cleared | {variable: "C"}).out


@pytest.mark.parametrize("line, code, advice", [
    ("{name:N, port: /dev/ttyS0", "key.no_space", "`name: N`"),
    ("{name: N, port: /dev/ttyS0, speed: 9600", "key.unknown", "`baud`"),
    ("{name: N, port: /dev/ttyS0, qqqqqqqqqqqqq: 9600", "key.unlike", "Remove"),
    ("{name: N, transport: tcp, host: 10.0.0.7:1502", "host.with_port", "`tcp_port: 1502`"),
])
def test_slips_of_new_users(project, line, code, advice):
    text = f"takt: 1\nlines:\n- {line}, devices: [{{name: D, address: 1, variables: []}}]}}\n"
    assert [(f["code"], advice in f["advice"]) for f in findings(project(text))] == [(code, True)]


@pytest.mark.parametrize("key, value", [("name", "N"), ("port", "/dev/ttyS0")])
def test_a_missing_space_in_a_list_of_lines(project, key, value):
    """YAML reads the line as a text, and reports the colon of a later line."""
    text = "takt: 1\nlines:\n  - name: N\n    port: /dev/ttyS0\n    baud: 9600\n    devices: []\n"
    path = project(text.replace(f"{key}: {value}", f"{key}:{value}"))
    finding, = takt("check", path, "--json", code=2).json["findings"]
    assert finding["code"] == "file.no_space" and f"`{key}: {value}`" in finding["advice"]
    assert finding["line"] == text[:text.index(f"{key}: {value}")].count("\n") + 1


@pytest.mark.parametrize("heading, code, words", [
    ("Address", "file.csv.two_registers", ["register (3)", "Address (5)", "unit_address"]),
    ("reference", "file.csv.two_addresses", ["register (3)", "reference (5)", "line 2"]),
])
def test_two_columns_for_the_register(project, tmp_path, heading, code, words):
    (tmp_path / "t.csv").write_text(f"name,type,register,read,{heading}\nA,int,1,3,40002\nB,int,2,3,40003\n")
    text = "takt: 1\nlines:\n- {name: N, port: /dev/ttyS0, devices: [\n" \
        "  {name: D, address: 1, variables: t.csv}]}\n"
    finding, = findings(project(text))
    assert finding["code"] == code
    for word in words:
        assert word in finding["message"] + finding["advice"]
    (tmp_path / "t.csv").write_text((tmp_path / "t.csv").read_text().replace(heading, "note"))
    takt("check", project(text), code=0)  # the advice followed


def test_a_key_of_another_tool_beside_its_own(project):
    text = "takt: 1\nlines:\n- {name: N, port: /dev/ttyS0, devices: [\n" \
        "  {name: D, address: 1, slave_id: 1, variables: []}]}\n"
    finding, = findings(project(text))
    assert finding["code"] == "key.twice" and "`address`" in finding["message"]


GOOD = """\
takt: 1
lines:
  - name: N
    transport: serial
    port: /dev/ttyS0
    baud: 9600
    devices:
      - name: D
        address: 1
        turnaround: 20ms
        variables:
          - {name: V, type: int16, register: 0, read: 0x03, scale: 0.1}
"""


@functools.cache
def findings_of_good(text):
    """Several tests begin with the same project."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "project.yaml"
        path.write_text(text, encoding="utf-8")
        return json.dumps(takt("check", path, "--json").json["findings"])


@pytest.mark.parametrize("language", ["en", "ru", "uk"])
@pytest.mark.parametrize("right, wrong", [
    ("address: 1", "slave_id: 1"),
    ("address: 1", "unit_id: 1"),
    ("address: 1", "адрес: 1"),
    ("address: 1", "адреса: 1"),
    ("baud: 9600", "speed: 9600"),
    ("baud: 9600", "скорость: 9600"),
    ("baud: 9600", "швидкість: 9600"),
    ("name: N", "name:N"),
    ("address: 1", "address:1"),
    ("scale: 0.1", 'scale: "0,1"'),
    ("scale: 0.1", "scale: 0,1"),
    ("register: 0", "reg: 0"),
    ("reference: 40001", "register: 400001"),
    ("read: 0x03", "function: 0x03"),
    ("turnaround: 20ms", "turnaround: 20"),
])
def test_the_advice_followed_literally_removes_the_finding(project, language, right, wrong):
    good = GOOD.replace("register: 0", right) if right.startswith("reference") else GOOD
    assert findings_of_good(good) == "[]"
    result = takt("check", project(good.replace(right, wrong)), "--json", "--lang", language, code=None)
    assert result.code in (1, 2)
    finding = result.json["findings"][0]
    key, value = right.split(": ")
    assert finding["severity"] == "error" and (key in finding["advice"]
                                               or value in finding["advice"]), finding


@pytest.mark.parametrize("scale", ["0,1", '"0,1"'])
def test_a_decimal_comma(project, scale):
    text = "takt: 1\nlines:\n- {name: N, port: /dev/ttyS0, devices: [{name: D, address: 1, variables: [\n" \
        f"  {{name: V, type: int16, register: 0, read: 0x03, scale: {scale}}}]}}]}}\n"
    comma = findings(project(text))[0]
    assert (comma["code"], comma["path"]) == ("number.comma", "lines[0].devices[0].variables[0].scale")
    assert "0.1" in comma["advice"] and comma["line"] == 4


@pytest.mark.parametrize("wrong, near", [("regster: 0", "register"),
                                         ("write_on_chnage: true", "write_on_change"),
                                         ("tpye: int16", "type")])
def test_an_unknown_key_names_the_nearest(project, wrong, near):
    good = "name: V, type: int16, register: 0, read: 0x03"
    key = wrong.split(":")[0]
    entry = good.replace(f"{near}: " + good.split(f"{near}: ")[1].split(",")[0], wrong) if near in good \
        else f"{good}, {wrong}"
    text = TEN_MISTAKES[:TEN_MISTAKES.index("    bauds")] + "    devices:\n      - name: D\n" \
        f"        address: 1\n        variables:\n          - {{{entry}}}\n"
    finding = next(f for f in findings(project(text)) if key in f"{f['path']} {f['value']} {f['message']}")
    assert near in f"{finding['allowed']} {finding['message']} {finding['advice']}"


# Settings of docs/specification.md, section 2, by their edges: (setting, good values, bad values).
EDGES = [
    ("registers_per_request", ["2", "125"], ["0", "1", "126", "many", "2.5", "-2"]),
    ("address", ["1", "247", "0x10"], ["0", "255", "-1", "1.5", "one", "010"]),
    ("attempts", ["1", "255"], ["256", "-1", "1.5"]),
    ("poll_period", ["0ms", "65535ms", "24h"], ["86401s", "100", "-1ms", "fast"]),
    ("response_timeout", ["1ms", "65535ms"], ["65536ms", "10", "soon"]),
]


@pytest.mark.parametrize("setting, value, good",
                         [(s, v, True) for s, goods, _ in EDGES
                          for v in goods] + [(s, v, False) for s, _, bads in EDGES for v in bads])
def test_edges_of_device_settings(project, setting, value, good):
    settings = {"name": "D", "address": 1, "group_requests": "true", "strategy": "classic"} | {setting: value}
    text = TEN_MISTAKES[:TEN_MISTAKES.index("    bauds")] + "    devices:\n" \
        + "".join(f"      {'- ' if k == 'name' else '  '}{k}: {v}\n" for k, v in settings.items()) \
        + "        variables:\n          - {name: V, type: int16, register: 0, read: 0x03}\n"
    path = project(text)
    errors = [
        f for f in takt("check", path, "--json", code=0 if good else 1).json["findings"]
        if f["severity"] == "error"
    ]
    at_line = next(n for n, line in enumerate(text.splitlines(), 1)
                   if line.strip(" -").startswith(f"{setting}:"))
    assert [f["line"] for f in errors] == ([] if good else [at_line])


def test_a_csv_table_of_variables_is_judged_in_its_own_lines(project):
    text = TEN_MISTAKES[:TEN_MISTAKES.index("    bauds")] + \
        "    devices:\n      - name: D\n        address: 1\n        variables: table.csv\n"
    project("name,type,register,read\nA,int16,0,0x03\nB,int16,65536,0x03\nC,colour,2,0x03\n", "table.csv")
    assert sorted((f["file"].rsplit("/")[-1], f["line"]) for f in findings(project(text))) \
        == [("table.csv", 3), ("table.csv", 4)]


OUTPUT = """takt: 1
lines:
  - name: L
    transport: simulated
    devices:
      - {name: D, address: 1, variables: [{name: A, type: uint16, register: 1, read: 0x03}]}
outputs:
  - {name: m, transport: mqtt, brokers: ['mqtts://127.0.0.1:18999'], user: u, password_file: secret,
     {key}: {path}}
"""


@pytest.mark.parametrize("key", ["password_file", "key_file", "ca_file", "certificate_file"])
@pytest.mark.parametrize("mode", [0o600, 0o644])
def test_a_file_of_an_output_that_is_a_fifo_is_a_finding_without_chmod(project, tmp_path, key, mode):
    text = OUTPUT.replace("{key}", key).replace("{path}", "link")
    if key == "password_file":
        text = text.replace("password_file: secret,\n    ", "")
    elif key == "key_file":
        text = text.replace("link", "link, certificate_file: secret")
    elif key == "certificate_file":
        text = text.replace("link", "link, key_file: secret")
    path = pathlib.Path(project(text))
    secret, fifo = path.parent / "secret", path.parent / "fifo"
    secret.write_text("x\n")
    secret.chmod(0o600)
    os.mkfifo(fifo, mode)
    fifo.chmod(mode)
    (path.parent / "link").symlink_to("fifo")

    def warned():
        found = takt("check", path, "--json").json["findings"]
        return [f for f in found if f["code"].startswith("output.file_")]

    found = warned()
    assert [(f["code"], f["path"], f["line"])
            for f in found] == [("output.file_irregular", f"outputs[0].{key}", 8)]
    assert found[0]["value"].endswith("/link") and "chmod" not in found[0]["advice"]
    fifo.unlink()
    fifo.write_text("x" * 4194305)
    fifo.chmod(0o600)
    [found] = warned()
    limit = 65536 if key in ("password_file", "key_file") else 4194304
    assert (found["code"], found["allowed"]) == ("output.file_too_long", f"0..{limit}")
    assert f"{limit} bytes" in found["advice"]


EFM32ZG = program.ROOT / "examples" / "firmware" / "efm32zg.yaml"


@pytest.mark.parametrize("language", ["en", "ru", "uk"])
def test_firmware_of_the_example(language):
    checked = takt("--lang", language, "check", "--firmware", EFM32ZG)
    assert "9620.0" in checked.out and "670" in checked.out and "{" not in checked.out
    figures = takt("check", "--firmware", EFM32ZG, "--json").json["firmware"]
    assert figures["holds"] and figures["t3_5"]["ticks"] == 154
    assert figures["current_ua"]["total"] == pytest.approx(
        sum(value for name, value in figures["current_ua"].items() if name != "total"))


def test_firmware_that_does_not_hold_the_line(project):
    good = EFM32ZG.read_text(encoding="utf-8")
    path = project(good.replace("uart_clock_ppm: 100", "uart_clock_ppm: 10000"))
    assert "DOES NOT HOLD" in takt("check", "--firmware", path, code=1).out
    figures = takt("check", "--firmware", path, "--json", code=1).json["firmware"]
    assert not figures["holds"] and not figures["bit_rate"]["holds"] and figures["t3_5"]["holds"]


def test_firmware_with_a_mistake(project):
    path = project(EFM32ZG.read_text(encoding="utf-8").replace("timer_bits: 24", "timer_bits: 7"))
    (finding, ) = findings(path, "--firmware")
    assert (finding["path"], finding["value"], finding["allowed"]) == ("timer_bits", "7", "8..64")
    assert takt("check", "--firmware", path.parent / "none.yaml", code=2).err


@pytest.mark.parametrize("language", ["en", "ru", "uk"])
def test_firmware_of_another_form(project, language):
    """The texts about such a file speak of the microcontroller, not of a project."""
    for text in "", "# nothing\n", "- core_clock: 14000000\n", "core clock\n":
        path = project(text)
        code = 1 if text.startswith(("-", "core")) else None
        shown = takt("--lang", language, "check", "--firmware", path, code=code).out
        assert "active_ua_per_mhz" in shown and "takt: 1" not in shown and "- name" not in shown, shown
    shown = takt("--lang", language, "check", "--firmware", path.parent / "none.yaml", code=2)
    assert not any(word in shown.out for word in ("project", "проект", "проєкт")), shown.out
    unitless = EFM32ZG.read_text(encoding="utf-8").replace("wakeup_time: 2us", "wakeup_time: 4")
    assert "4ms, 4us" in takt("--lang", language, "check", "--firmware", project(unitless), code=1).out
