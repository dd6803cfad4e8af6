import pytest

import overheard
import endpoints
import program

NOTHING_RAN = 5  # ctest reports the entry as skipped (tests/CMakeLists.txt)


def pytest_sessionfinish(session, exitstatus):
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if exitstatus == 0 and reporter.stats.get("skipped") and not reporter.stats.get("passed"):
        session.exitstatus = NOTHING_RAN


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
