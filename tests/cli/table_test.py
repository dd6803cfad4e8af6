"""takt table: build, inspect and refuse request tables."""
import os
import struct
import zlib

import pytest

from program import takt
from projects import at, scenario_1, scenario_3, serial


@pytest.fixture
def table(project, tmp_path):
    """Builds the table of a project's text and gives its path."""

    def build(text, *options, name="table.bin"):
        path = tmp_path / name
        takt("table", "build", project(text), "-o", path, *options)
        return path

    return build


def seal(image):
    """The image with its length and checksum put right."""
    image = bytearray(image)
    image[12:16] = struct.pack("<I", len(image))
    image[16:20] = bytes(4)
    image[16:20] = struct.pack("<I", zlib.crc32(image))
    return bytes(image)


def test_the_checksum_is_the_crc_everybody_has(table):
    for path in (table(scenario_3()), table(scenario_3(), "--profile", "owen-kc1", name="owen.bin")):
        image = path.read_bytes()
        assert seal(image) == image


def test_show_prints_the_same_as_plan(project, table):
    text = scenario_3()
    planned = takt("plan", project(text), "--json").json["lines"][0]["requests"]
    shown = takt("table", "show", table(text), "--json").json
    entries = shown["lines"][0]["devices"][0]["entries"]
    assert len(entries) == len(planned) == 2
    for entry, request in zip(entries, planned):
        for key in ("function", "write_function", "start", "quantity", "variables", "period_ms",
                    "read_trigger", "write_trigger", "write_on_change"):
            assert entry[key] == request[key], key
    assert [i["name"] for i in shown["items"]] == ["T512", "T600", "First", "Second", "Third"]
    text = takt("table", "show", table(scenario_3())).out
    assert "0x03 500..501" in text and "First" in text


def test_owen_entries(table):
    shown = takt("table", "show", table(scenario_3(), "--profile", "owen-kc1"), "--json").json
    assert shown["format"] == "owen-kc1" and shown["places"] == 5
    device, = shown["lines"][0]["devices"]
    assert device["unit"] == 16
    pair, third = device["entries"]
    assert (pair["type"], pair["function"], pair["flags"], pair["quantity"], pair["start"], pair["data"],
            pair["read_trigger"], pair["own_period"]) == ("word", 3, 1, 2, 500, 3, 1, False)
    assert (third["function"], third["start"], third["data"], third["read_trigger"], third["period_ms"],
            third["own_period"]) == (4, 506, 5, 2, 50, True)


def test_owen_refuses_all_by_name_and_writes_nothing(project, tmp_path):
    path = tmp_path / "table.bin"
    path.write_bytes(b"old")
    text = serial([
        "name: Wide, type: double, register: 0, read: 0x03",
        "name: Scaled, type: int, register: 10, read: 0x03, scale: 0.1",
        "name: Fine, type: int, register: 20, read: 0x03",
        "name: Text, type: string, length: 4, register: 30, read: 0x03"
    ])
    refused = takt("table", "build", project(text), "-o", path, "--profile", "owen-kc1", code=1)
    for name in ("Wide", "Scaled", "Text"):
        assert f"error: {name}: " in refused.err
    assert "Fine" not in refused.err
    assert path.read_bytes() == b"old"
    takt("table", "build", project(text), "-o", path)
    assert path.read_bytes().startswith(b"TAKTTABL")


def test_variables_that_no_entry_writes_are_named(project, tmp_path):
    rows = [f"name: V{i}, type: int, register: {i}, read: 0x03, write: 0x10" for i in range(3)]
    rows.append("name: W, type: int, register: 3, read: 0x03, write: 0x10, write_on_change: true")
    path = tmp_path / "table.bin"

    def build(group):
        described = project(serial(rows, profile="owen-kc1", group_requests=group, strategy="classic"))
        return takt("table", "build", described, "-o", path, "--profile", "owen-kc1").err

    warned = build("true")
    assert "warning: V0: no entry of the table writes 3 variables of the device Node1" in warned
    assert "no entry" not in build("false").replace("group_requests: false", "")
    rows[3] = rows[0].replace("V0", "W").replace("register: 0", "register: 3")
    assert "writes 4 variables" in build("true")


def test_the_limits_of_the_controller_are_those_of_its_profile(project, tmp_path):
    fast = serial(at([0], "type: int, read: 0x03")).replace("115200", "230400")
    assert "115200" in takt("table", "build", project(fast), "-o", tmp_path / "t", "--profile", "owen-kc1",
                            code=1).err
    many = serial([f"name: V{i}, type: int, register: {i}, read: 0x03" for i in range(1030)])
    built = takt("table", "build", project(many), "-o", tmp_path / "t", "--profile", "owen-kc1")
    assert "warning" in built.err
    shown = takt("table", "show", tmp_path / "t", "--json").json
    assert shown["places"] == 1024
    assert shown["lines"][0]["request_gap_us"] == 12000


def refusal(path, tmp_path, image):
    broken = tmp_path / "broken.bin"
    broken.write_bytes(image)
    return takt("table", "show", broken, code=2).err


@pytest.mark.parametrize("options", [(), ("--profile", "owen-kc1")], ids=["own", "owen-kc1"])
def test_broken_tables_are_refused_with_the_reason(table, tmp_path, options):
    path = table(scenario_1(), *options)
    image = path.read_bytes()
    assert "cut off" in refusal(path, tmp_path, image[:-1])
    assert "cut off" in refusal(path, tmp_path, image[:9])
    assert "after the table" in refusal(path, tmp_path, image + b"x")
    assert "checksum" in refusal(path, tmp_path, image[:-1] + bytes([image[-1] ^ 1]))
    newer = bytearray(image)
    newer[8] = 7
    assert "version 7" in refusal(path, tmp_path, seal(newer))
    assert "not a request table" in refusal(path, tmp_path, b"takt: 1\n" + image)
    assert "inconsistent" in refusal(path, tmp_path, seal(image[:10] + b"\0\0" + image[12:]))


def test_invalid_files_and_projects(project, tmp_path):
    assert "cannot be opened" in takt("table", "show", tmp_path / "none", code=2).err
    takt("table", "build", tmp_path / "none.yaml", "-o", tmp_path / "t", code=2)
    assert not (tmp_path / "t").exists()
    takt("table", "build", project(scenario_1()), code=2)
    takt("table", code=2)
    takt("table", "build", project(scenario_1()), "-o", tmp_path / "no" / "t", code=3)


def test_the_old_table_stays_whole_until_the_new_one_is(project, tmp_path):
    path = tmp_path / "t"
    takt("table", "build", project(scenario_1()), "-o", path)
    old = path.read_bytes()
    with open(path, "rb") as reader:
        takt("table", "build", project(scenario_3()), "-o", path)
        assert reader.read() == old, "who has it open sees the old one"
    assert path.read_bytes() != old
    assert sorted(os.listdir(tmp_path)) == ["project.yaml", "t"], "nothing temporary is left"
