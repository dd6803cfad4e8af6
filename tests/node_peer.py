"""The peers of tests/peers/node: programs that speak JSON lines with the test (talk.js), and slaves."""
import json

import pytest

from program import ROOT, Running, until

FOLDER = ROOT / "tests/peers/node"


def node(program, *arguments):
    """That program of tests/peers/node in the background, once it has reported that it is ready."""
    if not (FOLDER / "node_modules" / ".package-lock.json").is_file():
        pytest.skip("the peers from npm are not installed (tests/peers/node); "
                    "run tools/setup test where npm can be reached")
    peer = Running(["node", FOLDER / f"{program}.js", *arguments])
    try:
        peer.wait_line(lambda line: line == "ready", "ready")
    except AssertionError:
        peer.__exit__()
        raise
    return peer


class Client:
    """A master of a library, connected to `endpoint`. `ask()` calls one of its methods and gives {"result":
    …} or {"error": …}."""

    def __init__(self, library, transport, endpoint, unit=1, timeout_ms=60000):
        self._peer = node(f"{library}_client", transport, endpoint, unit, timeout_ms)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._peer.__exit__()

    def ask(self, method, *arguments):
        before = len(self._peer.out)
        self._peer.send(json.dumps([method, *arguments]))
        until(lambda: len(self._peer.out) > before or self._peer.process.poll() is not None,
              f"an answer of {method}{arguments}")
        assert len(self._peer.out) > before, f"ended at {method}{arguments}\n{self._peer!r}"
        return json.loads(self._peer.out[before])
