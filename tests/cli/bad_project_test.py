"""Files that are no project: exit code 2, a clear message with the file's name, and never a crash or a
hang."""
import os
import random

import pytest

from program import takt
from projects import at, serial

GOOD = serial(at([0, 2, 4], "type: float, read: 0x03"))


def nested(opening, closing, depth):
    return ("takt: 1\nlines: " + opening * depth + closing * depth + "\n").encode()


def billion_laughs():
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [" + ", ".join([f"*a{i - 1}"] * 9) + "]" for i in range(1, 12)]
    return ("\n".join(lines) + "\n").encode()


CONTENTS = {
    "empty": b"",
    "only spaces": b"   \n\n  \n",
    "binary": random.Random(7).randbytes(20000),
    "zeros": bytes(100000),
    "an executable": b"\x7fELF\x02\x01\x01" + bytes(200),
    "a lone byte 0xFF": b"takt: 1\nlines: \xff\n",
    "UTF-16": "takt: 1\nlines: []\n".encode("utf-16"),
    "deep sequences": nested("[", "]", 20000),
    "deep mappings": nested("{a: ", "}", 20000),
    "deep and never closed": nested("[", "", 100000),
    "deep by indentation": "".join(" " * i + "a:\n" for i in range(1500)).encode(),
    "recursive alias": b"takt: 1\nlines: &a\n  - *a\n",
    "an alias": b"takt: 1\nlines: &a []\nlocals: *a\n",
    "billion laughs": billion_laughs(),
    "two documents": GOOD.encode() + b"---\n" + GOOD.encode(),
    "a key twice": GOOD.replace("    baud: 115200\n", "    baud: 115200\n    baud: 9600\n").encode(),
    "a list": b"- takt: 1\n",
    "a word": b"hello\n",
    "truncated": GOOD.encode()[:-12],
    "tabs": b"takt: 1\nlines:\n\t- name: x\n",
    "huge": b"takt: 1\n" + b"# comment comment comment comment comment comment comment comment\n" * 500000,
    "one huge line": b"takt: 1\nprofile: " + b"x" * 40_000_000 + b"\n",
    "many keys": b"takt: 1\n" + b"".join(b"key%d: 1\n" % i for i in range(1000000)),
}
# A document that can be read as YAML may also give findings (1), each with its location.
FINDINGS_WILL_DO = {
    "a key twice", "an alias", "recursive alias", "billion laughs", "a list", "a word", "empty",
    "only spaces", "two documents"
}


@pytest.mark.parametrize("content", CONTENTS, ids=lambda c: c.replace(" ", "-"))
def test_content(tmp_path, content):
    path = tmp_path / "bad.yaml"
    path.write_bytes(CONTENTS[content])
    result = takt("check", path, code=None)
    assert result.code in ((1, 2) if content in FINDINGS_WILL_DO else (2, )), repr(result)[:2000]
    seen = result.out + result.err
    assert "bad.yaml" in seen, seen[:2000]
    assert len(seen) < 100_000, "the output is bounded too"


@pytest.mark.parametrize("content", ["recursive alias", "binary", "truncated", "deep sequences"])
@pytest.mark.parametrize("command",
                         [["plan"], ["run", "--for", "1s"], ["serve", "--for", "1s"], ["check", "--json"]],
                         ids=lambda c: c[0])
def test_every_command_that_reads_a_project(tmp_path, command, content):
    path = tmp_path / "bad.yaml"
    path.write_bytes(CONTENTS[content])
    result = takt(command[0], path, *command[1:], code=None)
    assert result.code in (1, 2)
    if command[0] == "check":
        assert result.code == 1 or "bad.yaml" in result.out + result.err
        return
    assert "bad.yaml" in result.err


def test_a_file_that_is_not_there(tmp_path):
    result = takt("check", tmp_path / "nowhere.yaml", code=2)
    assert "nowhere.yaml" in result.err


def test_a_folder(tmp_path):
    result = takt("check", tmp_path, code=2)
    assert str(tmp_path) in result.err


def test_a_pipe_without_writer(tmp_path):
    path = tmp_path / "pipe.yaml"
    os.mkfifo(path)
    assert "pipe.yaml" in takt("check", path, code=2).err


@pytest.mark.parametrize("device", ["/dev/zero", "/dev/urandom", "/dev/null"])
def test_a_device(device):
    assert device in takt("check", device, code=2).err


def test_a_broken_link(tmp_path):
    path = tmp_path / "link.yaml"
    path.symlink_to(tmp_path / "nowhere")
    assert "link.yaml" in takt("check", path, code=2).err


def test_a_variable_table_that_cannot_be_read(project):
    text = GOOD[:GOOD.index("        variables:")]
    for table in ("nowhere.csv", "."):
        result = takt("check", project(text + f"        variables: {table}\n"), code=None)
        assert result.code in (1, 2)
        assert table in result.out + result.err


@pytest.mark.parametrize("cut", range(len(GOOD) - 160, len(GOOD), 7))
def test_cut_anywhere(tmp_path, cut):
    """Some cuts leave a smaller project, most leave none: whichever, there is an answer and no crash."""
    path = tmp_path / "cut.yaml"
    path.write_text(GOOD[:cut])
    assert takt("check", path, code=None).code in (0, 1, 2)
