"""Standard streams that are closed, and outputs on a full disk: the plant goes on."""
import json
import os
import pathlib
import re
import resource
import signal
import subprocess

import pytest

from program import DEADLINE, TAKT, environment, until
from projects import at, tcp

EXAMPLES = pathlib.Path(__file__).parents[2] / "examples"
INT = "type: int16, read: 0x03"


def run_without(stream, arguments, **options):
    """The program with one of its descriptors 0 to 2 closed."""
    return subprocess.run([TAKT, *map(str, arguments)], env=environment(), timeout=DEADLINE, check=False,
                          preexec_fn=lambda: os.close(stream), **options)


@pytest.mark.parametrize("stream", [0, 1, 2])
def test_a_closed_stream_is_no_other_file(project, blank_device, tmp_path, stream):
    path = project(tcp(at([0], INT), blank_device()))
    log, state = tmp_path / "log", tmp_path / "state"
    done = run_without(
        stream,
        ["run", path, "--for", "500ms", "--stdin", "--log", log, "--log-level", "debug", "--state", state],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert done.returncode == 0, done.stderr
    for line in log.read_text().splitlines():
        assert line[:4].isdigit(), f"not a line of the log: {line}"


def writes_of(process):
    """How often it called write(), successful or not."""
    counts = pathlib.Path(f"/proc/{process.pid}/io").read_text()
    return int(re.search(r"syscw: (\d+)", counts)[1])


def test_a_full_disk_ends_no_run(tmp_path):
    """A limit of the file size stands for the full disk. Lines are counted while it lasts, and follow
    afterwards."""
    out, frames, log = (tmp_path / name for name in ("out", "frames", "log"))
    with out.open("wb") as file:
        run = subprocess.Popen([
            TAKT, "--log",
            str(log), "--log-level", "debug", "run",
            str(EXAMPLES / "demo.yaml"), "--state",
            str(tmp_path / "state"), "--json", "--traffic",
            str(frames)
        ], stdout=file, stderr=subprocess.PIPE, env=environment())
    unlimited = resource.prlimit(run.pid, resource.RLIMIT_FSIZE)
    until(lambda: b"\"good\"" in out.read_bytes() and frames.stat().st_size > 0, "values and frames")
    resource.prlimit(run.pid, resource.RLIMIT_FSIZE, (16, unlimited[1]))
    size, tried = out.stat().st_size, writes_of(run)
    until(lambda: writes_of(run) > tried + 100, "more attempts to write")
    assert run.poll() is None and out.stat().st_size == size
    resource.prlimit(run.pid, resource.RLIMIT_FSIZE, unlimited)
    until(lambda: b"\"gap\"" in out.read_bytes() and b"not written" in frames.read_bytes(), "the counts")
    run.send_signal(signal.SIGINT)
    assert run.wait(DEADLINE) == 0, run.stderr.read()
    events = [json.loads(line) for line in out.read_text().splitlines()]
    assert events[-1]["event"] == "summary"
    assert sum(event.get("missed", 0) for event in events if event["event"] == "gap") > 0
    for line in frames.read_text().splitlines():
        assert line.startswith("["), line
