"""A plant whose program is killed again and again: one project, one broker, one subscriber."""
import csv
import io
import json
import os
import pathlib
import random
import signal
import subprocess
import time
from collections import Counter

from journal_files import JournalFolder, newest_slot
from judge import Delivery, check_history
from ledger import SEGMENT_BYTES, Ledger, Violation, require, text_of
from project import QUOTA_MB, VALUES, Broker, project_text
from wire import Wire

KINDS = ("plain", "broker", "link", "history", "broker", "link", "plain", "quota")
CALLS = ("append", "append", "sync", "sync", "slot", "slot_sync", "create", "remove", "send", "receive")
KILLS_BETWEEN_ENDS = 12
NOT_STORED = 7  # an exit code: samples are lost or only in memory
LIMIT = 300.0  # only detects programs that hang


def wait_for(condition, what, seconds=LIMIT):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise Violation(f"within {seconds:g} s not seen: {what}")
        time.sleep(0.002)


class Plant:
    """`seed` decides everything but the moments at which the operating system runs the program."""

    values = VALUES  # of the history: how `takt history --csv` prints a value

    def __init__(self, takt, kill_points, folder, seed, kind=None):
        self.takt, self.kill_points = takt, kill_points
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True)
        self.random = random.Random(seed)
        self.kind = kind or KINDS[seed % len(KINDS)]
        self.cut = self.kind != "quota" and self.random.random() < 0.4
        self.counts = Counter()
        self.broker = Broker(self.folder)
        self.wire = Wire(self.broker.port)
        self.project = self.folder / "plant.yaml"
        self._write_project()
        self.journal = self._journal_of("cloud")
        self.ledger = Ledger(QUOTA_MB << 20 if self.kind == "quota" else None, self.retention != "0s")
        self.delivery = Delivery(self.ledger)
        self.judged = [(self.journal, self.ledger, self.delivery)]
        # The database keeps what the journal removes.
        self.history = Ledger(keeps=False) if self.kind in ("history", "everything") else None
        if self.history:
            self.judged.append((self._journal_of("hist"), self.history, None))
        self.synced, self._log_read = {}, 0  # by path: the size of a segment, the content of a cursor
        self.replayed = False
        self.broker_back = 0.0

    def _journal_of(self, output):
        return JournalFolder(self.folder / "plant.journal" / output, output)

    def _write_project(self):
        # What is removed cannot be replayed for a broker that lost it.
        self.retention = "0s" if self.kind in ("plain", "link") and self.random.random() < 0.5 else "7d"
        large = self.kind == "quota"
        message = "device" if large else self.random.choice(("variable", "device"))
        self.project.write_text(
            project_text(self.wire.port, message, large, self.retention, self.kind == "history"))

    def run(self, kills, progress=lambda: None):
        """Kills the program so often. @returns the counts; raises Violation."""
        try:
            self.broker.start()
            self.wire.start()
            wait_for(lambda: self.wire.subscribed, "the subscription")
            if self.kind == "quota":
                self._fill()
            for kill in range(1, kills + 1):
                self._kill_once(self._delay())
                progress()
                if kill % KILLS_BETWEEN_ENDS == 0 and kill != kills:
                    self._end_in_order()
            self._end_in_order()
            self._check_end()
            return self._summary()
        finally:
            self.broker.kill()
            self.wire.ended = True
            if self.wire.ident:
                self.wire.join()

    def _delay(self):
        """How long the program runs. A cursor is written a second after an acknowledgement."""
        share = self.random.random()
        if share < 0.15:
            return self.random.uniform(0, 0.04)
        if share < 0.8:
            return self.random.uniform(0.02, 0.4)
        return self.random.uniform(0.4, 1.0) if share < 0.9 else self.random.uniform(1.05, 1.9)

    def _start(self, command, **popen):
        self.wire.begin_run()
        environment = os.environ | {
            "LD_PRELOAD": str(self.kill_points),
            "TAKT_SYNC_LOG": str(self.folder / "sync.log"),
            "LC_ALL": "C.UTF-8",
            "ASAN_OPTIONS": "verify_asan_link_order=0"
        }
        return subprocess.Popen([self.takt, *command], env=environment | popen.pop("env", {}), **popen)

    def _kill_once(self, delay):
        point = {}
        if self.random.random() < 0.4:
            call = self.random.choice(CALLS)
            count = self.random.randint(1, 2 if call in ("slot", "slot_sync", "create", "remove") else 9)
            point = {"TAKT_KILL_AT": f"{call}:{count}:{self.random.choice(('before', 'after', 'torn'))}"}
            if call.startswith("slot") and count > 1:
                delay = max(delay, 1.4)
        if self.kind == "link" and self.random.random() < 0.2:
            delay = max(delay, self.random.uniform(1.3,
                                                   1.6))  # a cursor is written while nothing is acknowledged
        begin = time.time_ns()
        code = self._live(delay, signal.SIGKILL, point)
        self.counts["at a call" if time.time_ns() - begin < delay * 1e9 else "at a time"] += 1
        require(code == -signal.SIGKILL, "the program ended by itself", code, self._errors())
        self._judge(begin, killed=True)

    def _live(self, delay, end, environment):
        """A run with its troubles, ended by a signal after the delay. @returns the exit code"""
        actions = sorted(self._actions(delay), key=lambda action: action[0])
        with open(self.folder / "stderr.txt", "wb") as errors:
            program = self._start(["run", str(self.project), "--quiet"], env=environment,
                                  stdout=subprocess.DEVNULL, stderr=errors)
            try:
                self._act(program, [*actions, (delay, lambda: program.send_signal(end))])
                code = program.wait(LIMIT)
            finally:
                program.kill()
                program.wait()
        self.wire.cut_after = None
        if self.wire.mode != "away":
            self.wire.mode = "pass"
        return code

    def _act(self, program, actions):
        self.program, started = program, time.monotonic()
        for at, action in actions:
            try:
                program.wait(max(0.0, started + at - time.monotonic()))
                return
            except subprocess.TimeoutExpired:
                action()

    def _actions(self, delay):
        """(time, call) of the troubles during a run."""
        if self.broker.process is None and time.monotonic() > self.broker_back:
            yield self.random.uniform(0, delay), self.broker.start
        elif self.kind == "broker" and self.broker.process and self.random.random() < 0.35:
            at = self.random.uniform(0, delay)
            yield at, self._kill_broker
            if self.random.random() < 0.6:
                yield self.random.uniform(at, delay), self.broker.start
        if self.kind == "quota":
            self.wire.mode = "away" if self.random.random() < 0.4 else "pass"
        if self.kind == "link" and self.random.random() < 0.6:
            at = self.random.uniform(0.2, 1) if delay > 1.3 else self.random.uniform(0, delay)
            mode = self.random.choice(("hold_up", "hold_down", "cut"))
            yield at, lambda: self._trouble(mode)
            if self.random.random() < 0.5:
                yield self.random.uniform(at, delay), lambda: self._trouble("pass")

    def _kill_broker(self):
        self.wire.subscriber_away = self.random.choice((0, self.random.uniform(0, 0.6)))
        self.broker.kill()
        self.counts["broker kills"] += 1
        self.broker_back = time.monotonic() + self.random.uniform(0, 0.5)

    def _trouble(self, mode):
        if mode == "cut":
            self.wire.cut_after = self.random.randint(0, 3000)
        else:
            self.wire.mode = mode

    def _judge(self, begin, killed=False):
        """After the end of a program that was started at `begin`."""
        window = self._window(begin)
        wait_for(self.wire.idle, "the end of the connection")
        self._read_log()
        power_cut = killed and self.cut and self.random.random() < 0.6
        for journal, ledger, delivery in self.judged:
            ledger.starts.append(window)
            if not journal.folder.is_dir():
                continue
            self._judge_ledger(journal, ledger, delivery, killed and self.cut)
            if power_cut:
                self._cut_segments(journal)
                self._cut_cursor(journal)
                ledger.add(journal.read(self._durable_size), True)

    def _window(self, begin):
        """The times of the program's clock since then."""
        return begin, time.time_ns()

    def _judge_ledger(self, journal, ledger, delivery, synced_only):
        known = ledger.newest.sequence if ledger.newest else 0
        ledger.add_removed(journal.removed(self._durable_size))
        ledger.add(journal.read(self._durable_size if synced_only else None), self.cut)
        if delivery:
            delivery.epoch_of_run = ledger.epoch_after(known)
            delivery.check(self.wire)
        durable, on_disk = newest_slot(self.synced.get(str(journal.cursor_path), b"")), journal.cursor()
        require(not durable or on_disk and on_disk.counter >= durable.counter, "a durable cursor is gone",
                durable, on_disk)
        cursor = durable if synced_only else on_disk
        ledger.set_cursor(cursor, delivery.acknowledged_to if delivery else None)
        ledger.check_removed(journal.bytes())

    def _durable_size(self, path):
        return self.synced.get(str(path), 0)

    def _cut_segments(self, journal):
        """A power cut: of the bytes that were not synchronised, any may be gone. The others are durable."""
        for path in list(journal.segments):
            synced, size = self.synced.get(str(path), 0), path.stat().st_size
            if size == synced:
                continue
            self.counts["cut bytes"] += size - synced
            journal.forget(path)
            fate = self.random.choice(("none", "some", "zeros", "all"))
            if fate in ("none", "some"):
                os.truncate(path, synced if fate == "none" else self.random.randint(synced, size))
            elif fate == "zeros":
                begin, end = sorted((self.random.randint(synced, size), self.random.randint(synced, size)))
                overwrite(path, begin, bytes(end - begin))
            self.synced[str(path)] = path.stat().st_size

    def _cut_cursor(self, journal):
        path = journal.cursor_path
        now, synced = path.read_bytes() if path.exists() else b"", self.synced.get(str(path), b"")
        if now == synced:
            return
        self.counts["cut cursors"] += 1
        synced = synced.ljust(len(now), b"\0")
        fate = self.random.choice(("none", "some", "all"))
        at = {"none": 0, "some": self.random.randint(0, len(now)), "all": len(now)}[fate]
        overwrite(path, 0, now[:at] + synced[at:])
        self.synced[str(path)] = path.read_bytes()

    def _read_log(self):
        """The sizes up to which files were synchronised. A file may have been removed since."""
        log = self.folder / "sync.log"
        if not log.exists():
            return
        with open(log, "rb") as file:
            file.seek(self._log_read)
            data = file.read()
        whole = data.rfind(b"\n") + 1
        self._log_read += whole
        for line in data[:whole].decode().splitlines():
            path, size, content = line.rsplit(" ", 2)
            self.synced[path] = int(size) if content == "-" else bytes.fromhex(content)

    def _errors(self):
        return (self.folder / "stderr.txt").read_text()[-2000:]

    def _fill(self):
        """The journal grows while the broker is away, so that each start from now on drops a segment."""
        self.wire.mode = "away"
        while self.journal.bytes() < SEGMENT_BYTES + (1 << 20):
            self._kill_once(2.5)

    def _end_in_order(self):
        """A run that ends by SIGINT, with nothing in its way. @returns its outputs by name"""
        self.wire.subscriber_away = 0.0
        self.broker.start()
        self.wire.mode, self.wire.cut_after = "pass", None
        wait_for(lambda: self.wire.subscribed, "the subscription")
        begin = time.time_ns()
        with open(self.folder / "stdout.txt", "wb") as out, open(self.folder / "stderr.txt", "wb") as errors:
            program = self._start(["run", str(self.project), "--json"], stdout=out, stderr=errors)
            try:
                wait_for(lambda: self.wire.acknowledged_to >= max(1, self.ledger.end()),
                         "the delivery of what waits")
                time.sleep(self.random.uniform(0, 0.2))
                program.send_signal(signal.SIGINT)
                code = program.wait(LIMIT)
            finally:
                program.kill()
                program.wait()
        require(code == 0, "the program ended with a failure", code, self._errors())
        self._judge(begin)
        summary = json.loads((self.folder / "stdout.txt").read_bytes().splitlines()[-1])
        outputs = {output["name"]: output for output in summary["outputs"]}
        self.delivery.check_counters(outputs["cloud"], exact=not self.replayed)
        if self.history:
            kept = outputs["hist"]
            owed = sum(1 for _ in self.history.numbers())
            require(
                kept["sampled"] == self.history.end() and kept["waiting"] == 0 and kept["delivered"] == owed
                and kept["dropped"] == kept["sampled"] - owed, "the counters of the history", kept, owed)
        self.counts["ends"] += 1
        return outputs

    def _deliver_all(self):
        """An end delivers for 0.7 s, which may not suffice on a busy machine."""
        end = time.monotonic() + LIMIT
        while time.monotonic() < end:
            waiting = self._end_in_order()["cloud"]["waiting"]
            if waiting == 0:
                return
        raise Violation(f"{waiting} samples wait although the broker takes them")

    def _check_end(self):
        """Everything owed has arrived, or a replay brings it."""
        self._deliver_all()
        if self.kind in ("broker", "everything"):
            self._await_arrival(seconds=1, required=False)
            lost = self.delivery.missing()
            not_acknowledged = [number for number in lost if number not in self.delivery.acknowledged]
            require(not not_acknowledged, "samples did not arrive that no broker had acknowledged",
                    not_acknowledged[:5])
            self.counts["lost by the broker"] += len(lost)
            self._replay()
            self._deliver_all()
        self._await_arrival()
        if self.history:
            self._check_history()

    def _await_arrival(self, seconds=LIMIT, required=True):
        end = time.monotonic() + seconds
        while True:
            self.delivery.check(self.wire)
            missing, gaps = self.delivery.missing(), self.delivery.missing_gaps()
            if not missing and not gaps:
                return
            if time.monotonic() > end:
                break
            time.sleep(0.02)
        require(not required, "samples or gaps did not arrive", missing[:5], len(missing), gaps[:2])

    def _first_time(self):
        """Before each sample, by the program's clock."""
        return text_of(min(begin for begin, _ in self.ledger.starts) - 60_000_000_000)

    def _last_time(self):
        return text_of(max(end for _, end in self.ledger.starts) + 60_000_000_000)

    def _replay(self):
        begin = self._first_time()
        command = ["replay", str(self.project), "--output", "cloud", "--from", begin, "--json"]
        self.replayed = True
        killed = self.random.randint(0, 2)
        for _ in range(killed):
            started = time.time_ns()
            program = self._start(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            try:
                time.sleep(self.random.uniform(0, 0.02))
            finally:
                program.kill()
                program.wait()
            self.ledger.go_back()
            self._judge(started, killed=True)
        expected = self.ledger.cursor.samples - self.ledger.records[self.ledger.first_on_disk].before
        started = time.time_ns()
        program = self._start(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        out, errors = program.communicate(timeout=LIMIT)
        if not killed or program.returncode != 1:
            require(program.returncode == 0, "takt replay", program.returncode, errors)
            require(json.loads(out)["samples"] == expected, "takt replay counts", out, expected)
        self.ledger.go_back()
        self._judge(started)

    def _check_history(self):
        ledger = self.history
        command = [
            self.takt, "history", str(self.project), *self.values, "--from",
            self._first_time(), "--to",
            self._last_time()
        ]
        table = subprocess.run([*command, "--csv"], capture_output=True, text=True, timeout=LIMIT,
                               check=False)
        # A power cut may have cost samples, which every reader reports.
        codes = (0, NOT_STORED) if self.cut else (0, )
        require(table.returncode in codes, "takt history", table.stderr)
        rows = [(row["variable"], row["time_utc"], self.values[row["variable"]](row["value"]), row["quality"])
                for row in csv.DictReader(io.StringIO(table.stdout))]
        picture = subprocess.run([*command, "--json"], capture_output=True, text=True, timeout=LIMIT,
                                 check=False)
        require(picture.returncode in codes, "takt history", picture.stderr)
        shown = json.loads(picture.stdout)
        check_history(ledger, rows,
                      [(gap["from"], gap["to"]) for gap in shown["gaps"] if gap["cause"] == "restart"])
        count = sum(variable["samples"] for variable in shown["variables"])
        require(count == len(rows), "takt history --json counts", count, len(rows))
        self.counts["in the history"] += len(rows)

    def _summary(self):
        self.counts["samples"] += self.ledger.end()
        self.counts["starts"] += len(self.ledger.restarts())
        return self.counts + self.delivery.counts


def overwrite(path, offset, data):
    with open(path, "r+b") as file:
        file.seek(offset)
        file.write(data)
