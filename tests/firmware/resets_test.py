"""Retained registers of a board that is reset at random times."""
import os
import struct

from board import PATIENCE, run

FEW = 200


def test_no_reset_loses_a_stored_value(tmp_path):
    resets = int(os.environ.get("TAKT_BOARD_RESETS", FEW))
    (tmp_path / "script").write_bytes(struct.pack("<II", 1, resets))
    numbers, _ = run("microbit", "test_resets", tmp_path, patience=PATIENCE * max(1, resets // FEW))
    assert "lost_after" not in numbers
    assert numbers["stores"] > 2 * resets and numbers["cut"] > resets / 2
