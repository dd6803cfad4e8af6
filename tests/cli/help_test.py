"""--help in three languages: every command and option is described in each of them."""
import re

import pytest

from program import ROOT, takt

COMMANDS = [[], ["demo"], ["run"], ["ctl"], ["serve"], ["check"], ["plan"], ["convert"], ["table"],
            ["table", "build"], ["table", "show"], ["history"], ["latency"], ["capture"], ["listen"],
            ["replay"], ["schema"], ["selftest"], ["read"], ["write"], ["raw"], ["scan"], ["probe"]]
HEADINGS = {
    "en": ("Usage:", "Options:"),
    "ru": ("Использование:", "Параметры:"),
    "uk": ("Використання:", "Параметри:")
}


@pytest.mark.parametrize("language", HEADINGS)
@pytest.mark.parametrize("command", COMMANDS, ids=lambda c: "-".join(c) or "takt")
def test_help(command, language):
    text = takt("--lang", language, *command, "--help").out
    assert all(heading in text for heading in HEADINGS[language])
    assert "help." not in text, "a code without a text"
    assert not any(ord(c) < 32 and c != "\n" for c in text)
    described = re.findall(r"(?m)^  (-\S.*?)(?:  +|\n +)(\S.*)$", text)
    assert described
    if language != "en":
        translated = [words for _, words in described if re.search("[а-яіїє]", words)]
        assert len(translated) >= 0.7 * len(described), described


@pytest.mark.parametrize("command", COMMANDS, ids=lambda c: "-".join(c) or "takt")
def test_help_is_free_of_the_parser(command):
    """Types, checks and dependencies as CLI11 writes them are not shown."""
    text = takt(*command, "--help").out
    assert not re.search(r"TEXT=|INT\b|FLOAT|\{|Excludes:|Needs:|\(\d+x\)|\n\n\n", text), text
    assert all(len(line.split("  ")[0]) < 60 for line in text.splitlines() if line.startswith("  -"))


def test_every_command_is_listed():
    text = takt("--help").out
    for command in COMMANDS[1:]:
        assert re.search(rf"(?m)^  {command[0]} +\S", text), command


def test_the_version_is_that_of_the_build():
    """It is stated once, by project() in CMakeLists.txt; the changelog begins with it."""
    build = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    version = re.search(r"\bproject\(\s*takt\s+VERSION\s+([\d.]+)", build)[1]
    assert takt("--version").out == f"takt {version}\n"
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.search(r"(?m)^## \[([\d.]+)\]", changes)[1] == version
