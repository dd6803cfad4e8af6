"""Cases of commands that end by themselves: what each prints for examples, test projects, broken projects,
captures and wrong calls. A case is a name and the arguments of `takt`; its text is exit code, standard output
and standard error."""
import concurrent.futures
import os
import pathlib
import re
import shutil

from program import ROOT, takt

HERE = pathlib.Path(__file__).resolve().parent
LANGUAGES = ("en", "ru", "uk")
HEADINGS = ("keys", "en", "ru", "uk", "ide")
COMMANDS = ("demo", "run", "ctl", "serve", "check", "plan", "convert", "table", "table build", "table show",
            "history", "latency", "capture", "listen", "replay", "schema", "selftest", "read", "write", "raw",
            "scan", "probe")
WRONG_CALLS = ("", "chekc x", "check", "check nothing.yaml", "check examples", "plan --svg",
               "plan --jsno x.yaml", "run --for 10 examples/first.yaml", "run --for 5q examples/first.yaml",
               "run --web x examples/first.yaml", "read", "read tpc://h holding 0",
               "read tcp://127.0.0.1:1 holdng 0", "read tcp://127.0.0.1:1 holding 70000",
               "read tcp://127.0.0.1:1 holding 0 --type flaot",
               "read tcp://127.0.0.1:1 holding 0 --order ABDC", "read rtu:///dev/x?buad=9600 holding 0",
               "write tcp://127.0.0.1:1 holding 0 x", "write tcp://127.0.0.1:1 input 0 1",
               "raw tcp://127.0.0.1:1 0", "raw tcp://127.0.0.1:1 zz", "serve --listen 127.0.0.1:99999",
               "serve --fault slience", "scan tcp://10.0.0.1-300",
               "convert examples/meters.csv", "convert nothing.csv --to yaml",
               "table show examples/first.yaml", "history examples/first.yaml x", "replay examples/mqtt.yaml",
               "latency nothing.pcap", "capture", "ctl", "ctl nowhere status", "--lang xx check",
               "--log-level loud run")


def example_projects():
    return sorted(
        p.relative_to(ROOT) for p in (ROOT / "examples").rglob("*.yaml") if "templates" not in p.parts)


def projects():
    """Paths below the folder that `lay` made."""
    return [
        *example_projects(),
        *(pathlib.Path("projects") / p.name for p in sorted((HERE / "projects").iterdir()))
    ]


def lay(folder):
    """Copies what the cases read into `folder`, so that no path of this machine gets into a text."""
    shutil.copytree(ROOT / "examples", folder / "examples")
    shutil.copytree(HERE / "projects", folder / "projects")
    shutil.copytree(ROOT / "tests/fuzz/corpus/capture", folder / "captures")


def project_cases(path):
    """Everything that is made of one project without a bus."""
    for language in LANGUAGES:
        say = ("--lang", language)
        yield f"check {language}", (*say, "check", path)
        yield f"check json {language}", (*say, "check", "--json", path)
        yield f"plan {language}", (*say, "plan", path)
        yield f"plan prove {language}", (*say, "plan", "--prove", "--compare", path)
        yield f"plan svg {language}", (*say, "plan", "--svg", "-", path)
        yield f"map {language}", (*say, "convert", "--map", "--to", "md", path)
    yield "plan json", ("plan", "--json", "--prove", path)
    yield "plan json uk", ("--lang", "uk", "plan", "--json", "--compare", path)
    yield "plan csv", ("plan", "--csv", path)
    yield "plan fix", ("plan", "--fix", path)
    yield "firmware", ("check", "--firmware", path)
    yield "map csv", ("convert", "--map", "--to", "csv", path)
    for headings in HEADINGS:
        yield f"csv {headings}", ("convert", "--to", "csv", "--headings", headings, path)
    for table in ("locals", "server", "list"):
        yield f"csv {table}", ("convert", "--to", "csv", "--table", table, path)


def broken(path, folder):
    """Variants of a project, each broken at one line: without it, with a wrong value, with a misspelt key.
    Every second line is broken, in one of the three ways, and one of three languages is asked."""
    lines = path.read_text(encoding="utf-8").split("\n")
    for number, line in enumerate(lines):
        key, colon, _ = line.partition(":")
        if number % 2 or not line.strip() or line.lstrip().startswith("#"):
            continue
        wrong = ["", f"{key}{colon} oops",
                 f"{key[:-2]}{key[-1:]}{colon}{line.partition(':')[2]}"][number // 2 % 3]
        file = folder / f"{path.stem}-{number + 1}.yaml"
        file.write_text("\n".join([*lines[:number], wrong, *lines[number + 1:]]), encoding="utf-8")
        yield f"{path.stem} line {number + 1}", ("--lang", LANGUAGES[number // 6 % 3], "check", file.name)


def capture_cases(folder):
    for capture in sorted(p.name for p in (folder / "captures").iterdir()):
        for form in ("--json", "--csv", "--svg=-"):
            yield f"latency {capture} {form}", ("latency", f"captures/{capture}", form)
        yield f"latency {capture}", ("--lang", "ru", "latency", f"captures/{capture}")
        yield f"listen {capture}", ("--lang", "uk", "listen", f"captures/{capture}")
        yield f"listen {capture} json", ("listen", "--json", f"captures/{capture}")


def command_cases():
    for language in LANGUAGES:
        for command in COMMANDS:
            yield f"help {command} {language}", ("--lang", language, *command.split(), "--help")
        for call in WRONG_CALLS:
            yield f"takt {call} {language}", ("--lang", language, *call.split())
        yield f"schema {language}", ("--lang", language, "schema")
        yield f"rows {language}", ("--lang", language, "convert", "examples/meters.csv", "--to", "yaml")
        yield f"ide rows {language}", ("--lang", language, "convert", "examples/boiler-ide.csv", "--to",
                                       "yaml")


def text_of(arguments, folder):
    done = takt(*arguments, code=None, cwd=folder)
    err = re.sub(r"^.*\d+ %, .*\n?", "", done.err, flags=re.MULTILINE)  # progress, where it took that long
    return f"exit code {done.code}\n{done.out}--- stderr\n{err}".replace(str(folder), "FOLDER")


def texts(cases, folder):
    """The text of each case; several programs run beside each other."""
    cases = list(cases)
    with concurrent.futures.ThreadPoolExecutor(max_workers=os.cpu_count() or 2) as pool:
        return dict(zip((name for name, _ in cases), pool.map(lambda case: text_of(case[1], folder), cases)))


def table_texts(path, folder):
    """The request table of a project, as `table build` says and `table show` prints it."""
    said = {"table build": text_of(("table", "build", path, "-o", "golden.table"), folder)}
    if (folder / "golden.table").exists():
        for language in LANGUAGES:
            said[f"table {language}"] = text_of(("--lang", language, "table", "show", "golden.table"), folder)
        said["table json"] = text_of(("table", "show", "--json", "golden.table"), folder)
    return said
