"""A bool of a table has a register and often no bit: `--type bool` asks which coil is meant."""
import os
import pty
import subprocess

import pytest

from fake_slave import TcpSlave
from program import DEADLINE, TAKT, environment, takt

REMEDIES = "can be coil 17, or bit 0 of register 17, which is coil 272"


def answer(adu):
    """One bit that is on; a write is repeated."""
    pdu = adu[7:]
    reply = pdu if pdu[0] == 5 else bytes([pdu[0], 1, 1])
    return adu[:4] + (len(reply) + 1).to_bytes(2, "big") + adu[6:7] + reply


@pytest.mark.parametrize("command", [["read", "coils", "17"], ["read", "discrete", "17"],
                                     ["read", "coils", "17", "--watch"], ["write", "coils", "17", "1"]],
                         ids=" ".join)
def test_without_a_terminal_both_meanings_are_named(command):
    result = takt(command[0], "tcp://127.0.0.1:1", *command[1:], "--type", "bool", code=2)
    area = command[1]
    assert f"{area} 17 as a bool {REMEDIES}" in result.err and f"`{area} 272`" in result.err, result
    assert result.out == ""


@pytest.mark.parametrize("lang, word", [("ru", "то есть сигнал 272"), ("uk", "тобто сигнал 272")])
def test_in_other_languages(lang, word):
    arguments = ["read", "tcp://127.0.0.1:1", "coils", 17, "--type", "bool", "--lang", lang]
    assert word in takt(*arguments, code=2).err


def test_registers_have_no_bools():
    result = takt("read", "tcp://127.0.0.1:1", "holding", 17, "--type", "bool", code=2)
    assert "leave --type out" in result.err


@pytest.mark.parametrize("command, typed, coil", [
    (["read", "coils", "17"], "1\n", 17),
    (["read", "coils", "17"], "x\n2\n", 272),
    (["write", "coils", "17", "1"], "2\n", 272),
    (["read", "coils", "0"], "", 0),
    (["read", "coils", "5000"], "", 5000),
], ids=lambda x: " ".join(x).strip() if isinstance(x, list) else repr(x))
def test_on_a_terminal_it_asks(command, typed, coil):
    terminal, inner = pty.openpty()
    seen = []

    def answers(adu):
        seen.append(adu)
        return answer(adu)

    try:
        with TcpSlave(answers) as slave:
            os.write(terminal, typed.encode())
            done = subprocess.run(
                [TAKT, command[0], f"tcp://127.0.0.1:{slave.port}", *command[1:], "--type", "bool"],
                stdin=inner, stdout=subprocess.PIPE, stderr=inner, env=environment(), timeout=DEADLINE,
                check=False)
    finally:
        os.close(inner)
        os.close(terminal)
    assert done.returncode == 0
    assert [int.from_bytes(adu[8:10], "big") for adu in seen] == [coil]
