"""What all tests share: what a machine lacks, projects, serial ports and blank devices.

A missing program or module fails its tests by name, and the end of the run states the command that installs
it. A test is skipped for what no package provides (a right, IPv6, packages from npm). Where TAKT_SKIPS names
a file, each skipped case appends a line "FILE::TEST: REASON" to it; `./dev test` prints and counts them.
"""
import os
import pathlib
import re
import shutil
import signal
import tempfile

import pytest

import overheard
import endpoints
import program

NOTHING_RAN = 5  # ctest reports the entry as skipped (tests/CMakeLists.txt)
MISSING = re.compile(r"(?:No module named|No such file or directory:) '([\w.-]+)'")
_missing = set()

# A run in the background ignores SIGINT, and so would all programs that it starts.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser):
    parser.addoption("--every", type=int, default=1, metavar="N", help="run the first of each N cases only")


def pytest_collection_modifyitems(config, items):
    items[:] = items[::config.getoption("--every")]


def pytest_runtest_logreport(report):
    note(report)


def pytest_collectreport(report):
    note(report)


def note(report):
    """Keeps the reason of a skip, or the name of what is missing."""
    if report.failed:
        _missing.update(MISSING.findall(report.longreprtext))
    if not report.skipped or hasattr(report, "wasxfail") or "TAKT_SKIPS" not in os.environ:
        return
    reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    line = f"{report.nodeid}: {' '.join(reason.removeprefix('Skipped: ').split())}\n"
    file = os.open(os.environ["TAKT_SKIPS"], os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o644)
    os.write(file, line.encode())  # at once: entries of ctest run beside each other
    os.close(file)


def pytest_terminal_summary(terminalreporter):
    if _missing:
        terminalreporter.write_line(f"missing: {', '.join(sorted(_missing))}. Install with: tools/setup test")


def pytest_sessionfinish(session, exitstatus):
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if exitstatus == 0 and reporter.stats.get("skipped") and not reporter.stats.get("passed"):
        session.exitstatus = NOTHING_RAN


@pytest.fixture
def open_folder():
    """A folder that all users may read. pytest closes the parents of tmp_path to others with each start."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="takt-open-"))
    folder.chmod(0o755)
    yield folder
    shutil.rmtree(folder)


@pytest.fixture
def project(tmp_path):
    """Writes a project's text to a file and gives its path."""

    def write(text, name="project.yaml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def pair(tmp_path):
    """A pair of serial ports."""
    with endpoints.serial_pair(tmp_path) as both:
        yield both


@pytest.fixture(scope="session", autouse=True)
def what_was_overheard(tmp_path_factory):
    """Has tshark judge what the tests kept for it."""
    yield
    overheard.judge_what_was_kept(tmp_path_factory.mktemp("overheard"))


@pytest.fixture
def blank_device():
    """`takt serve` as a blank device on TCP; call it with a fill, get the port."""
    yield from blank_devices()


@pytest.fixture(scope="module")
def shared_device():
    """The same for all tests of a file: call it with a fill, get the port of the device with that fill. For
    tests that write no register of it."""
    ports, devices = {}, blank_devices()
    serve = next(devices)

    def port(fill="zero"):
        if fill not in ports:
            ports[fill] = serve(fill)
        return ports[fill]

    yield port
    next(devices, None)


def blank_devices():
    running = []

    def serve(fill="zero", unit=1):
        port = endpoints.free_port()
        device = program.start("serve", "--listen", f"127.0.0.1:{port}", "--unit", unit, "--fill", fill)
        running.append(device)
        endpoints.wait_listening(port, device)
        return port

    yield serve
    for device in running:
        with device:
            if device.process.poll() is None:
                device.interrupt()
