"""The pages of docs/: every option is documented in the page of its command, and every relative link has a target."""
import pathlib
import re

import pytest

from program import ROOT, takt

COMMANDS = {"check": [["check"]], "plan": [["plan"]], "run": [["run"]], "demo": [["demo"]], "ctl": [["ctl"]], "serve": [["serve"]],
            "convert": [["convert"]], "table": [["table", "build"], ["table", "show"]], "read": [["read"]], "write": [["write"]],
            "raw": [["raw"]], "scan": [["scan"]], "probe": [["probe"]]}
PAGES = ROOT / "docs/commands"


def options_of_help(command):
    """Long and short names of the options that `takt COMMAND --help` prints."""
    text = takt(*command, "--help").out
    return {name for line in re.findall(r"(?m)^  (-\S+)", text) for name in re.findall(r"--?[a-z][a-z-]*", line)}


def options_of_page(page):
    """The options in the first column of the tables of a page."""
    text = page.read_text(encoding="utf-8")
    cells = re.findall(r"(?m)^\| ((?:`-[^`|]*`(?:, )?)+) \|", text)
    return {name for cell in cells for name in re.findall(r"`(-[^`]*)`", cell)}


def test_each_command_has_a_page():
    listed = set(re.findall(r"(?m)^  ([a-z]+)  ", takt("--help").out.split("Commands:")[1]))
    assert listed == set(COMMANDS) == {page.stem for page in PAGES.glob("*.md")} - {"README"}


@pytest.mark.parametrize("name", COMMANDS)
def test_options_are_documented(name):
    common = options_of_page(PAGES / "README.md")
    printed = set().union(*map(options_of_help, COMMANDS[name])) - common
    assert options_of_page(PAGES / f"{name}.md") == printed


def test_common_options_are_documented():
    assert options_of_page(PAGES / "README.md") == options_of_help([])


# --- links

def anchors(page):
    """The anchors of the headings of a page, as GitHub makes them."""
    text = re.sub(r"(?ms)^```.*?^```", "", page.read_text(encoding="utf-8"))
    headings = re.findall(r"(?m)^#+ (.*)$", text)
    plain = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower() for heading in headings]
    return {re.sub(r"[^\w\- ]", "", heading).replace(" ", "-") for heading in plain}


def links(page):
    text = re.sub(r"(?ms)^```.*?^```", "", page.read_text(encoding="utf-8"))
    text = re.sub(r"`[^`\n]*`", "", text)
    return re.findall(r"\]\(([^)\s]+)\)", text)


def pages():
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_relative_links_have_a_target(page):
    broken = []
    for link in links(page):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        if not target.exists() or anchor and target.suffix == ".md" and anchor not in anchors(target):
            broken.append(link)
    assert not broken


def test_every_page_is_in_the_index():
    index = ROOT / "docs/README.md"
    named = {(index.parent / link.partition("#")[0]).resolve() for link in links(index)}
    missing = [page for page in (ROOT / "docs").rglob("*.md") if page.resolve() not in named and page != index]
    decisions = pathlib.Path("docs/decisions")
    assert not [page for page in missing if not page.relative_to(ROOT).is_relative_to(decisions)]


def test_decisions_are_numbered_without_holes():
    numbers = sorted(int(page.name[:4]) for page in (ROOT / "docs/decisions").glob("*.md"))
    assert numbers == list(range(1, len(numbers) + 1))
    for page in (ROOT / "docs/decisions").glob("*.md"):
        text = page.read_text(encoding="utf-8")
        assert text.startswith(f"# {int(page.name[:4])}. ") and re.search(r"(?m)^Status: \w+, \d{4}-\d\d-\d\d$", text), page.name
        assert re.findall(r"(?m)^## (.*)$", text) == ["Context", "Decision", "Consequences"], page.name
