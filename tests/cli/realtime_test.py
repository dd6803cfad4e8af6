"""The real-time mode of run and serve with and without rights, and the host budget of takt selftest."""
import json
import os
import re
import shutil
import subprocess

import pytest

from endpoints import free_port, wait_listening
from program import DEADLINE, TAKT, Running, environment, start, takt, until

PROJECT = """takt: 1
{host}
lines:
  - name: field
    transport: simulated
    devices: [{{name: Pump, address: 1, poll_period: 50ms, turnaround: 2ms, variables: [
      {{name: level, type: int, register: 0, read: 0x03}}]}}]
"""
STEPS = [
    "lock the memory", "keep stack and heap in memory", "avoid slow idle states of the processors",
    "run on processor 0", "end the timer slack", "schedule with priority 49 (SCHED_FIFO)",
    "poll for 50us before sleeping"
]
NEEDED = {"lock the memory": "CAP_IPC_LOCK", "schedule with priority 49 (SCHED_FIFO)": "CAP_SYS_NICE"}


@pytest.fixture
def plant(open_folder):
    path = open_folder / "plant.yaml"
    path.write_text(PROJECT.format(host=""))
    return path


@pytest.fixture
def without_rights(open_folder):
    """The command of takt as nobody without capabilities and without limits that replace them."""
    copy = open_folder / "takt"
    shutil.copy(TAKT, copy)
    copy.chmod(0o755)

    def command(*arguments, processes=None):
        if processes and os.geteuid() != 0:
            pytest.skip("needs a user without other processes")
        limits = [
            "prlimit", "--memlock=65536", "--rtprio=0", *([f"--nproc={processes}"] if processes else [])
        ]
        rights = ["setpriv", "--reuid", "65534", "--clear-groups", "--inh-caps=-all"
                  ] if os.geteuid() == 0 else []
        return [*limits, *rights, str(copy), *map(str, arguments)]

    return command


def steps_of(text):
    """Each step with the reason why it was not done; empty: done. A reason is followed by an advice."""
    lines = text.splitlines()
    begin = lines.index("Real-time mode:")
    steps = {}
    for number, line in enumerate(lines[begin + 1:], begin + 1):
        found = re.fullmatch(r"  (\S.*): (?:done|not done \((.+)\))", line)
        if not found:
            if line.startswith("    "):
                continue
            break
        steps[found[1]] = found[2] or ""
        if found[2]:
            assert lines[number + 1].startswith("    "), "an advice"
    return steps


def answering(run):
    """The result of a run that is interrupted when its device answers."""
    run.wait_line(lambda line: "Pump: answering" in line, "an answer")
    return run.interrupt()


def test_every_step_is_reported(plant):
    option = ["--realtime", "--cpu", "0", "--spin", "50us"]
    with start("run", plant, "--quiet", *option) as run:
        assert list(steps_of(answering(run).err)) == STEPS
    port = free_port()
    with start("serve", "--listen", f"127.0.0.1:{port}", *option) as serve:
        wait_listening(port, serve)
        assert list(steps_of(serve.interrupt().err)) == STEPS


def test_without_rights_it_goes_on_and_names_them(plant, without_rights):
    with Running(without_rights("run", plant, "--quiet", "--realtime", "--cpu", 0, "--spin", "50us")) as run:
        result = answering(run)
    steps = steps_of(result.err)
    assert list(steps) == STEPS
    assert steps["schedule with priority 49 (SCHED_FIFO)"]
    for step, right in NEEDED.items():  # a program with sanitizers ignores mlockall()
        assert not steps[step] or right in result.err
    assert steps["run on processor 0"] == steps["end the timer slack"] == steps[
        "poll for 50us before sleeping"] == ""


def test_a_processor_that_does_not_exist(plant):
    with start("run", plant, "--quiet", "--cpu", 1023) as run:
        assert steps_of(answering(run).err)["run on processor 1023"]


def test_the_steps_as_json(plant):
    result = takt("run", plant, "--for", "200ms", "--quiet", "--json", "--realtime", "--spin", "1us")
    steps = json.loads(next(line for line in result.lines if '"realtime"' in line))["steps"]
    assert [s["step"] for s in steps
            ] == ["lock_memory", "keep_memory", "idle_states", "timer_slack", "scheduling", "spin"]
    assert all(s["done"] == ("error" not in s) for s in steps)


@pytest.mark.parametrize("option, allowed", [("--realtime=0", "1..99"), ("--realtime=100", "1..99"),
                                             ("--realtime=x", "1..99"), ("--cpu=-1", "0..1023"),
                                             ("--cpu=1024", "0..1023"), ("--spin=101ms", "0s..100ms"),
                                             ("--spin=-1us", "0s..100ms"), ("--spin=5", "unit")])
def test_wrong_values(plant, option, allowed):
    for command in (["run", plant, "--for", "10ms"], ["serve", "--listen", "127.0.0.1:0", "--for",
                                                      "10ms"], ["selftest", "--for", "1ms"]):
        result = takt(*command, option, code=2)
        assert option.split("=")[0] in result.err and allowed in result.err, result


def test_the_host_line_is_one_of_a_project_and_the_guarantee_uses_it(plant):
    lines = ()
    for seconds in ("100ms", "1s", "10s"):  # as long as each measurement needs for a sample
        result = takt("selftest", "--for", seconds)
        lines = re.findall(r"^  (host: \{jitter: (\d+)us, overhead: (\d+)us\})", result.out, re.MULTILINE)
        if lines:
            break
    assert len(lines) == 2, result
    before = takt("plan", plant, "--json").json["lines"][0]["requests"][0]
    plant.write_text(PROJECT.format(host="host: {jitter: 700us, overhead: 4900us}"))
    after = takt("plan", plant, "--json").json["lines"][0]["requests"][0]
    assert after["c_us"] - before["c_us"] == 4900 - 200, "the overhead is a part of C"
    later = after["response_us"] - before["response_us"]
    assert later == 4900 - 200 + 700 - 1000, "the jitter is a part of R"
    for line, _, _ in lines:
        plant.write_text(PROJECT.format(host=line))
        takt("check", plant)


def test_without_samples_there_is_no_host_line():
    result = takt("selftest", "--for", "1ms", "--json").json
    for run in (result["idle"], result["loaded"]):
        samples = [run[subject]["samples"] for subject in ("wake_up", "loopback", "pty")]
        assert ("host" in run) == all(samples), samples


# The threads: the main one, that of all measurements, that of one measurement and its echo; under load one
# for each processor too.
@pytest.mark.parametrize("threads", [2, 3, 4, 5])
def test_a_thread_that_cannot_be_made_is_reported(without_rights, threads):
    result = subprocess.run(without_rights("selftest", "--for", "20ms", processes=threads),
                            capture_output=True, text=True, timeout=DEADLINE, check=False, env=environment())
    assert result.returncode == 3 and result.stderr.startswith("takt: thread: "), result


def test_the_selftest_ends_with_ctrl_c_and_what_it_has():
    with start("selftest", "--for", "30s") as selftest:
        until(lambda: selftest.catches(2), "the handler of signals")
        result = selftest.interrupt()
    assert "No `host:` line" in result.out, result
