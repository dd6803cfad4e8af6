#!/usr/bin/env python3
"""Kills `takt run` with an MQTT output at random instants, and judges what is on the disk and what arrives.

usage: output_kills.py [--kills N] [--plant-kills N] [--seed S] [--jobs J] [--takt PROGRAM] [--kind KIND]
                       [--kept FOLDER] [--everything SECONDS] [--resume FILE]

A plant has 50 kills. With --everything each run lasts for about that long, with devices, clients and faults
of all kinds (life.py); half of the runs end in order.

Plant number i has the seed S + i; the same seed repeats its plan, not the moments at which the operating
system runs the program. Exit status 1: a rule was violated; the folder of the plant is kept.
"""
import argparse
import ctypes
import multiprocessing
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from ledger import Violation  # noqa: E402
from life import LivingPlant  # noqa: E402
from plant import KINDS, Plant  # noqa: E402

KILLS = 50  # of a plant
MOST_VIOLATIONS = 8
PR_SET_PDEATHSIG = 1


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--takt", default=os.environ.get("TAKT",
                                                         str(HERE.parent.parent / "build/release/bin/takt")))
    parser.add_argument("--kind", choices=KINDS)
    parser.add_argument("--plant-kills", type=int, default=KILLS, help="kills of a plant")
    parser.add_argument("--everything", type=float, metavar="SECONDS", help="mean length of a run")
    parser.add_argument("--resume", type=pathlib.Path, metavar="FILE",
                        help="seeds without a violation; they are not run again")
    parser.add_argument("--kept", type=pathlib.Path,
                        help="folder for plants with a violation; it is created if it does not exist")
    return parser.parse_args()


def build_kill_points(folder):
    library = folder / "kill_points.so"
    source = HERE / "kill_points.cpp"
    subprocess.run(["clang++-19", "-std=c++20", "-O1", "-shared", "-fPIC", "-o", library, source], check=True)
    return library


def end_with_parent():
    """SIGTERM, also at the death of the parent, ends the plant and its processes."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


def work(options, library, folder, plants, results, enough):
    """Takes plants from the queue until it is empty. Each result: (seed, kills | counts | a text of a
    failure)."""
    end_with_parent()
    while (task := plants.get()) is not None:
        seed, kills = task
        if enough.is_set():
            continue
        place = folder / f"seed-{seed}"
        try:
            if options.everything:
                plant = LivingPlant(options.takt, library, place, seed, options.everything)
            else:
                plant = Plant(options.takt, library, place, seed, options.kind)
            counts = plant.run(kills, lambda seed=seed: results.put((seed, 1)))
            results.put((seed, counts))
            shutil.rmtree(place)
        except Violation as violation:
            results.put((seed, f"{plant.kind}{', power cuts' if plant.cut else ''}: {violation}"))
        except Exception:  # a mistake of the test is a failure too
            results.put((seed, traceback.format_exc()))
    results.put((None, None))


def main():
    options = arguments()
    if options.kept:
        options.kept = options.kept.resolve()  # the log of synchronised bytes has absolute paths
        options.kept.mkdir(parents=True, exist_ok=True)
    folder = pathlib.Path(tempfile.mkdtemp(prefix="takt-kills-", dir=options.kept))
    library = build_kill_points(folder)
    plants, results = multiprocessing.Queue(), multiprocessing.Queue()
    known = set(options.resume.read_text().split()) if options.resume and options.resume.exists() else set()
    left = options.kills
    count = 0
    while left > 0:
        kills = min(left, options.plant_kills)
        if str(options.seed + count) not in known:
            plants.put((options.seed + count, kills))
        left -= kills
        count += 1
    for _ in range(options.jobs):
        plants.put(None)
    enough = multiprocessing.Event()
    workers = [
        multiprocessing.Process(target=work, args=(options, library, folder, plants, results, enough))
        for _ in range(options.jobs)
    ]
    for worker in workers:
        worker.start()
    try:
        failures, done, total = follow(options, results, enough)
    except KeyboardInterrupt:
        return 130
    report(options, folder, failures, done, total)
    return 1 if failures else 0


def follow(options, results, enough):
    begin, done, running = time.monotonic(), 0, options.jobs
    failures, total = {}, Counter()
    while running:
        seed, result = results.get()
        if seed is None:
            running -= 1
        elif isinstance(result, int):
            done += result
        elif isinstance(result, str):
            failures[seed] = result
            if len(failures) == MOST_VIOLATIONS:
                enough.set()
            print(f"seed {seed}: {result}", flush=True)
        else:
            total += result
            if options.resume:
                with options.resume.open("a") as file:
                    file.write(f"{seed}\n")
        if sys.stderr.isatty():
            spent = time.monotonic() - begin
            print(f"\r{done} of {options.kills} kills, {spent:.0f} s, {len(failures)} violations ", end="",
                  file=sys.stderr)
    total["seconds"] = round(time.monotonic() - begin)
    if sys.stderr.isatty():
        print(file=sys.stderr)
    return failures, done, total


def report(options, folder, failures, done, total):
    for seed, text in failures.items():
        print(f"seed {seed}: {text.splitlines()[0][:100]}")
        print(f"  kept: {folder}/seed-{seed}")
        print(f"  again: {sys.argv[0]} --kills {options.plant_kills} --seed {seed} --jobs 1" +
              (f" --kind {options.kind}" if options.kind else "") +
              (f" --everything {options.everything:g}" if options.everything else ""))
    counts = ", ".join(f"{key} {value}" for key, value in sorted(total.items()))
    runs = "lives" if options.everything else "kills"
    print(f"{done} {runs}, {len(failures)} violations: {counts}")
    if not failures:
        shutil.rmtree(folder)


if __name__ == "__main__":
    sys.exit(main())
