"""The pages: options are documented, links and names exist, repeatable transcripts are real output."""
import pathlib
import re
import subprocess

import pytest

from program import ROOT, takt

COMMANDS = {
    "check": [["check"]],
    "plan": [["plan"]],
    "run": [["run"]],
    "demo": [["demo"]],
    "ctl": [["ctl"]],
    "serve": [["serve"]],
    "convert": [["convert"]],
    "table": [["table", "build"], ["table", "show"]],
    "history": [["history"]],
    "latency": [["latency"]],
    "capture": [["capture"]],
    "listen": [["listen"]],
    "replay": [["replay"]],
    "schema": [["schema"]],
    "selftest": [["selftest"]],
    "read": [["read"]],
    "write": [["write"]],
    "raw": [["raw"]],
    "scan": [["scan"]],
    "probe": [["probe"]]
}
PAGES = ROOT / "docs/commands"


def options_of_help(command):
    """Long and short names of the options that `takt COMMAND --help` prints."""
    text = takt(*command, "--help").out
    return {
        name
        for line in re.findall(r"(?m)^  (-\S+)", text) for name in re.findall(r"--?[a-z][a-z-]*", line)
    }


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


# --- the keys of a project

# Object of `takt schema`: the tables of docs/project-file.md with its keys, by section and head of the first
# column.
KEYS = {
    "project": [("Project", "key")],
    "line": [("Lines", "key")],
    "device": [("Devices", "key")],
    "variable": [("Variables", "key")],
    "local": [("Locals", "key")],
    "server": [("Servers", "key")],
    "relay": [("Relay", "key")],
    "unit": [("Units", "key")],
    "bank": [("Units", "key of a bank")],
    "limit": [("Units", "key of a limit")],
    "source": [("Variables of a server", "source")],
    "sink": [("Variables of a server", "destination")],
    "tls": [("Certificates", "key")],
    "access": [("Access rules", "key")],
    "instrument": [("Instruments", "key")],
    "exchange": [("Instruments", "key of an exchange")],
    "answer": [("Instruments", "key of a text answer"), ("Instruments", "key of a binary answer")],
    "start_command": [("Instruments", "key of a start command or a command")],
    "instrument_command": [("Instruments", "key of a start command or a command"),
                           ("Instruments", "further key of a command")],
    "output": [("Outputs", "key")]
}


def tables(page):
    """(section, head of the first column, names in the first column) of each table of a page."""
    section, rows = "", []
    for line in page.read_text(encoding="utf-8").splitlines() + [""]:
        if line.startswith("| "):
            rows.append(line.removeprefix("| ").partition(" |")[0])
        elif rows:
            yield section, rows[0], {name for row in rows[2:] for name in re.findall(r"`([a-z]\w*)", row)}
            rows = []
        section = line.lstrip("# ") if line.startswith("#") else section


def test_keys_of_projects_are_documented():
    objects = takt("schema").json["$defs"]
    page = list(tables(ROOT / "docs/project-file.md"))
    for name, wanted in KEYS.items():
        found = [names for section, head, names in page if (section, head) in wanted]
        assert len(found) >= len(wanted), name
        assert set().union(*found) == set(objects[name]["properties"]), name
    own = set(objects["served_variable"]["properties"]) - set(objects["variable"]["properties"])
    assert own <= next(names for section, _, names in page if section == "Variables of a server")
    mirror = next(names for section, _, names in tables(ROOT / "docs/servers.md")
                  if section == "Mirror all polled values")
    assert mirror == set(objects["mirror"]["properties"])


def test_protected_keys_are_documented():
    tables = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "src/model").rglob("*_fields.hpp"))
    page = (ROOT / "docs/project-file.md").read_text(encoding="utf-8")

    def marked(mark):
        return set(re.findall(r'\.key = "(\w+)"[^{}]*\.' + mark + " = true", tables))

    def stated(title):
        return set(re.findall(r"`(\w+)`", re.search(rf"\*\*{title}\*\*([^.]*)\.", page)[1]))

    assert marked("names_host_resource") == stated("Keys that name commands or files of the host")
    assert marked("secret") | marked("directs_secret") == stated("Keys that decide where a secret goes")


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
    return [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]


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


# --- names and output


def test_names_of_the_code_exist():
    sources = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "src").rglob("*.hpp"))
    missing = []
    for page in pages():
        text = re.sub(r"(?ms)^```.*?^```", "", page.read_text(encoding="utf-8"))
        names = {
            name
            for name in re.findall(r"`(?:takt::)?[a-z_]+::(\w+)", text) if name not in ("h", "wire")
        }
        missing += [f"{page.name}: {name}" for name in names if not re.search(rf"\b{name}\b", sources)]
        paths = set(re.findall(r"`((?:src|tests|tools|examples)/[\w./-]+)`", text))
        missing += [f"{page.name}: {path}" for path in paths if not (ROOT / path).exists()]
    assert not missing


def test_steps_of_the_architecture_are_in_their_files():
    text = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
    steps = re.findall(r"(?m)^\| [^|]* \| (?:[\w ]+ )?`([\w:]+)` \| `(src/[^`]*)` \|$", text)
    assert len(steps) == 60
    missing = []
    for function, path in steps:
        code = (ROOT / path).read_text(encoding="utf-8")
        *owners, name = function.split("::")
        wanted = [rf"\b{name}\("] + [rf"\b{owner}\b" for owner in owners]
        missing += [f"{path}: {function}" for pattern in wanted if not re.search(pattern, code)]
    assert not missing


CITED = [
    path for folder in ("src", "tests", "bench", "firmware", "tools")
    for path in sorted((ROOT / folder).rglob("*"))
    if path.suffix in (".hpp", ".cpp", ".h", ".py", ".cmake") or path.name == "CMakeLists.txt"
]


def comment_text(path):
    """The text of a source with its comments on one line each."""
    text = path.read_text(encoding="utf-8", errors="replace")
    return re.sub(r"\s*\n\s*(?:///?|#)?\s*", " ", text)


def headings(page):
    return re.findall(r"(?m)^#+ (.*)$", re.sub(r"(?ms)^```.*?^```", "", page.read_text(encoding="utf-8")))


def test_headings_that_sources_cite_exist():
    """docs/guarantees.md, "Model"; docs/specification.md, section 4; sections 1 and 2."""
    missing = []
    for path in CITED:
        text = comment_text(path)
        cited = {
            page: headings(ROOT / page) if (ROOT / page).exists() else None
            for page in re.findall(r"\bdocs/[\w/-]+\.md\b", text)
        }
        missing += [f"{path.name}: {page}" for page, known in cited.items() if known is None]
        for page, heading in re.findall(r'\b(docs/[\w/-]+\.md), "([^"]+)"', text):
            if heading not in (cited[page] or [heading]):
                missing.append(f"{path.name}: {page}, {heading}")
        for page, numbers in re.findall(r"\b(docs/[\w/-]+\.md), sections? ((?:\d+(?:, | and )?)+)", text):
            known = [heading.split(".")[0] for heading in cited[page] or []]
            missing += [
                f"{path.name}: {page}, section {number}" for number in re.findall(r"\d+", numbers)
                if number not in known
            ]
    assert not missing


def transcripts(page):
    """(command, output) of each command in the console blocks of a page."""
    for block in re.findall(r"(?ms)^```console\n(.*?)^```", page.read_text(encoding="utf-8")):
        for entry in re.split(r"(?m)^\$ ", block)[1:]:
            command, _, output = entry.partition("\n")
            yield command.removeprefix("build/"), output.split("\n…", 1)[0].rstrip()


REPEATABLE = re.compile(
    r"takt (--help|(plan|check|check --firmware) examples/\S+|convert examples/\S+ --unit 16 --target \S+)$")


@pytest.mark.parametrize("page, command, output",
                         [(page, command, output) for page in pages()
                          for command, output in transcripts(page) if REPEATABLE.match(command)],
                         ids=lambda value: value.name if isinstance(value, pathlib.Path) else None)
def test_transcripts_are_real(page, command, output):
    words = [word.strip("'") for word in command.split()[1:]]
    words = [str(ROOT / word) if word.startswith("examples/") else word for word in words]
    printed = "\n".join(line.rstrip() for line in takt(*words).out.splitlines())
    assert printed.startswith(output)


# --- the index and the decisions


def test_every_page_is_in_an_index():
    """docs/README.md, and the indexes of folders that it names."""
    indexes = [ROOT / "docs" / path for path in ("README.md", "commands/README.md", "decisions/README.md")]
    named = {(index.parent / link.partition("#")[0]).resolve() for index in indexes for link in links(index)}
    assert not [page for page in (ROOT / "docs").rglob("*.md") if page != indexes[0] and page not in named]


def test_decisions_agree_with_their_index():
    """Numbers, sections, the status of each page, and what later pages state about earlier ones."""
    checked = subprocess.run([ROOT / "tools/decisions", ROOT], capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stderr
