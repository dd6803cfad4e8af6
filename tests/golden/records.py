"""Stored texts of a group of cases, compressed: DATA/GROUP.json.xz holds {case: text}."""
import difflib
import json
import lzma
import pathlib

DATA = pathlib.Path(__file__).resolve().parent / "data"
# Of a difference: cases that are shown, and lines of each.
SHOWN_CASES, SHOWN_LINES = 8, 60


def file_of(group):
    return DATA / f"{group}.json.xz"


def stored(group):
    """The texts of a group; none where it was never accepted."""
    if not file_of(group).exists():
        return {}
    return json.loads(lzma.decompress(file_of(group).read_bytes()))


def accept(group, texts):
    """Replaces the stored texts; the bytes of the file depend on the texts only."""
    DATA.mkdir(exist_ok=True)
    text = json.dumps(texts, ensure_ascii=False, indent=0, sort_keys=True)
    file_of(group).write_bytes(lzma.compress(text.encode(), format=lzma.FORMAT_XZ, preset=9))


def difference(expected, actual):
    """What a reader needs to see: cases that came and went, then lines of the changed ones; "" if equal."""
    said = [f"{name}: not stored yet" for name in actual if name not in expected]
    said += [f"{name}: stored, but not made now" for name in expected if name not in actual]
    changed = [name for name in expected if name in actual and expected[name] != actual[name]]
    for name in changed[:SHOWN_CASES]:
        lines = list(
            difflib.unified_diff(expected[name].splitlines(),
                                 actual[name].splitlines(),
                                 f"{name} (stored)",
                                 f"{name} (now)",
                                 n=2,
                                 lineterm=""))
        said += lines[:SHOWN_LINES]
        if len(lines) > SHOWN_LINES:
            said.append(f"… {len(lines) - SHOWN_LINES} more lines")
    if len(changed) > SHOWN_CASES:
        said.append(f"also changed: {', '.join(changed[SHOWN_CASES:])}")
    return "\n".join(said)
