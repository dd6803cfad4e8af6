"""The program under test: run to its end with a deadline, or in the background with its output at hand."""
import json
import os
import pathlib
import signal
import subprocess
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
TAKT = os.environ.get("TAKT", str(ROOT / "build/dev/bin/takt"))
PEERS = pathlib.Path(os.environ.get("TAKT_PEERS", str(ROOT / "build/dev/bin")))

# Limits that only detect hanging programs, never a measure of speed: a busy machine is ten times slower.
DEADLINE = 100.0
# For an end that must not wait for a time-out of a minute.
WITHOUT_WAITING = 30.0
CRASHES = ("AddressSanitizer", "LeakSanitizer", "runtime error:", "terminate called", "Assertion",
           "ThreadSanitizer")


def until(condition, what, deadline=DEADLINE):
    """Polls `condition` until it gives something true and returns that; fails after `deadline` seconds."""
    end = time.monotonic() + deadline
    while True:
        found = condition()
        if found:
            return found
        if time.monotonic() > end:
            raise AssertionError(f"within {deadline:g} s not seen: {what}")
        time.sleep(0.01)


class Result:
    """The result of a run: exit code, standard output, standard error (both as text)."""

    def __init__(self, arguments, code, out, err):
        self.arguments, self.code, self.out, self.err = arguments, code, out, err

    @property
    def json(self):
        return json.loads(self.out)

    @property
    def lines(self):
        return self.out.splitlines()

    def __repr__(self):
        return (f"takt {' '.join(self.arguments)}\nexit code {self.code}\n--- stdout\n{self.out}\n"
                f"--- stderr\n{self.err}")


def environment(**changes):
    """The tests' environment: English wherever a test does not ask for another language."""
    clean = {k: v for k, v in os.environ.items() if k not in ("LC_ALL", "LC_MESSAGES", "LANG", "LANGUAGE")}
    return clean | {"LC_ALL": "C.UTF-8"} | changes


def refuse_crash(result):
    for sign in CRASHES:
        assert sign not in result.err, repr(result)
    assert result.code >= 0, f"ended by signal {-result.code}\n{result!r}"
    return result


def takt(*arguments, code=0, stdin="", deadline=DEADLINE, cwd=None, **env):
    """Runs `takt arguments…` to its end. `code`: the exit code it must have (None: any)."""
    arguments = [str(a) for a in arguments]
    try:
        done = subprocess.run([TAKT, *arguments], input=stdin.encode(), capture_output=True, timeout=deadline,
                              env=environment(**env), cwd=cwd, check=False)
    except subprocess.TimeoutExpired as late:
        raise AssertionError(f"takt {' '.join(arguments)}: still running after {deadline:g} s\n"
                             f"{late.stdout}\n{late.stderr}") from None
    result = refuse_crash(Result(arguments, done.returncode, done.stdout.decode(), done.stderr.decode()))
    assert code is None or result.code == code, f"expected exit code {code}\n{result!r}"
    return result


def has_signal(pid, field, number):
    """Whether a set of signals of a process, a field of /proc/PID/status, holds that one."""
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    numbers = int(next(line for line in status.splitlines() if line.startswith(field)).split()[1], 16)
    return numbers >> (number - 1) & 1


class Running:
    """A program in the background; its output is collected by line while it runs. Use as a context: it is
    killed at the end."""

    def __init__(self, command, env=None, **popen):
        self.command = [str(c) for c in command]
        self.process = subprocess.Popen(self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, env=environment(**(env or {})), **popen)
        self.out, self.err = [], []
        self.readers = [
            threading.Thread(target=self._collect, args=pair, daemon=True)
            for pair in ((self.process.stdout, self.out), (self.process.stderr, self.err))
        ]
        for reader in self.readers:
            reader.start()

    @staticmethod
    def _collect(stream, lines):
        for line in stream:
            lines.append(line.decode(errors="replace").rstrip("\n"))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        for reader in self.readers:
            reader.join()
        self.process.stdout.close()
        self.process.stderr.close()

    def __repr__(self):
        return f"{' '.join(self.command)}\n--- stdout\n" + "\n".join(self.out) + "\n--- stderr\n" + "\n".join(
            self.err)

    def send(self, line):
        """Writes one line to its standard input."""
        self.process.stdin.write(line.encode() + b"\n")
        self.process.stdin.flush()

    def catches(self, number):
        """Whether it has a handler of its own for that signal by now."""
        return has_signal(self.process.pid, "SigCgt:", number)

    def holds(self, number):
        """Whether its first thread blocks that signal."""
        return has_signal(self.process.pid, "SigBlk:", number)

    def events(self):
        """The lines of `--json` so far."""
        return [json.loads(line) for line in list(self.out)]

    def wait_line(self, wanted, what, after=0, deadline=DEADLINE):
        """The first line of stdout from number `after` on for which `wanted(line)` holds."""
        return self._wait(lambda: next((x for x in self.out[after:] if wanted(x)), None), what, deadline)

    def wait_event(self, wanted, what, after=0, deadline=DEADLINE):
        """The first event from number `after` on for which `wanted(event)` holds."""
        return self._wait(lambda: next((x for x in self.events()[after:] if wanted(x)), None), what, deadline)

    def _wait(self, condition, what, deadline):

        def seen():
            found = condition()
            assert found or self.process.poll() is None or any(r.is_alive() for r in self.readers), \
                f"ended before {what}\n{self!r}"
            return found

        try:
            return until(seen, what, deadline)
        except AssertionError as missing:
            raise AssertionError(f"{missing}\n{self!r}") from None

    def finish(self, code=0, deadline=DEADLINE):
        """Waits for its end and returns the Result, whose exit code must be `code` (None: any)."""
        try:
            self.process.wait(deadline)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"still running after {deadline:g} s\n{self!r}") from None
        for reader in self.readers:
            reader.join(DEADLINE)
        result = refuse_crash(
            Result(self.command[1:], self.process.returncode, "\n".join(self.out), "\n".join(self.err)))
        assert code is None or result.code == code, f"expected exit code {code}\n{result!r}"
        return result

    def interrupt(self, with_signal=signal.SIGINT, code=0, deadline=DEADLINE):
        """Sends Ctrl-C and waits for the end."""
        self.process.send_signal(with_signal)
        return self.finish(code, deadline)


def start(*arguments, **popen):
    """`takt arguments…` in the background."""
    return Running([TAKT, *arguments], **popen)
