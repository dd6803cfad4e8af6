"""Faults of an output that a user must see: a broker that refuses, a wrong password, a journal that is
removed."""
import json
import shutil
import signal
import subprocess

import pytest

from mqtt_plant import PLANT, TAKT, Broker, Subscriber, gaps, samples, stopped, wait_until
from program import DEADLINE

SECRET = "s3cret-word"


class Plant:
    """A run in the background, with its lines of JSON and its log."""

    def __init__(self, folder):
        self.folder = folder
        self.broker = Broker(folder)
        self.project = folder / "plant.yaml"
        self.program = None

    def start(self, keys=""):
        self.write(keys)
        self.out = open(self.folder / "out", "wb")
        self.program = subprocess.Popen(
            [TAKT, "run", self.project, "--json", "--quiet", "--log", self.folder / "log"], stdout=self.out,
            stderr=self.out)

    def write(self, keys):
        self.project.write_text(PLANT.format(port=self.broker.port) + keys)

    def reload(self):
        self.program.send_signal(signal.SIGHUP)

    def outputs(self):
        """The states of the output so far."""
        lines = (self.folder / "out").read_text().splitlines()
        events = [json.loads(line) for line in lines if line.startswith("{") and line.endswith("}")]
        return [event["output"] for event in events if event["event"] == "output"]

    def is_seen(self, **expected):
        return lambda: any(
            all(str(output[key]).startswith(value) for key, value in expected.items())
            for output in self.outputs()[-1:])

    def end(self):
        self.program.send_signal(signal.SIGINT)
        assert self.program.wait(timeout=DEADLINE) == 0
        return json.loads((self.folder / "out").read_text().splitlines()[-1])["outputs"][0]

    def stop(self):
        if self.program and self.program.poll() is None:
            self.program.kill()
            self.program.wait()
        if self.broker.process and self.broker.process.poll() is None:
            self.broker.kill()


@pytest.fixture
def plant(tmp_path):
    plant = Plant(tmp_path)
    yield plant
    plant.stop()


def configure(broker, text):
    broker.config.write_text(broker.config.read_text() + text)


def test_a_broker_that_refuses_messages_is_reported(plant):
    rules = plant.folder / "rules"
    rules.write_text("topic read plant/#\ntopic write takt/#\n")
    configure(plant.broker, f"acl_file {rules}\n")
    # With an unlimited queue mosquitto 2.0.11 closes the connection after a message that it denies.
    plant.broker.config.write_text(plant.broker.config.read_text().replace("max_queued_messages 0\n", ""))
    plant.broker.start()
    plant.start()
    wait_until(plant.is_seen(state="waiting", failure="not_authorized: PUBACK"))
    end = plant.end()
    assert end["delivered"] == 0 and end["waiting"] == end["sampled"]
    assert end["failure"] == "not_authorized: PUBACK"
    assert "not_authorized: PUBACK" in (plant.folder / "log").read_text()


def test_an_error_that_is_over_is_not_shown(plant):
    plant.start()
    wait_until(plant.is_seen(state="waiting", failure="refused"))
    plant.broker.start()
    wait_until(plant.is_seen(state="delivering"))
    assert plant.end()["failure"] is None


def test_a_changed_password_is_in_force_with_the_project(plant):
    passwords = plant.folder / "passwords"
    subprocess.run(["mosquitto_passwd", "-b", "-c", passwords, "plant1", SECRET], check=True)
    configure(plant.broker, f"password_file {passwords}\n")
    configure(plant.broker, "allow_anonymous false\n")
    plant.broker.start()
    secret = plant.folder / "secret"
    plant.start("    user: plant1\n    password_file: secret\n")
    wait_until(plant.is_seen(state="stopped", failure="password_file secret"))
    for password, state in ((SECRET, "delivering"), ("other" + SECRET, "waiting")):
        secret.write_text(password + "\n")
        secret.chmod(0o600)
        plant.reload()
        wait_until(plant.is_seen(state=state))
    assert plant.outputs()[-1]["failure"] == "not_authorized"
    plant.end()
    for file in ("out", "log"):
        assert SECRET not in (plant.folder / file).read_text()


def test_a_removed_journal_continues_with_its_numbers(plant):
    plant.start()
    journal = plant.folder / "plant.journal"
    wait_until(lambda: plant.outputs() and (journal / "cloud/cursor-cloud").exists())
    wait_until(plant.is_seen(state="waiting"))
    shutil.rmtree(journal)
    wait_until(lambda: list(journal.glob("cloud/segment-*")))
    assert any(output["journal"]["failure"] for output in plant.outputs()) or \
        "journal cannot be written" in (plant.folder / "log").read_text()
    with stopped(plant.program):
        plant.broker.start()
        subscriber = Subscriber(plant.broker, plant.folder / "sub")
    wait_until(lambda: len(samples(plant.folder / "sub")) >= 60)
    first = plant.end()
    plant.start()
    wait_until(plant.is_seen(state="delivering"))
    epoch = samples(plant.folder / "sub")[0]["epoch"] + 1
    wait_until(lambda: any(sample["epoch"] == epoch for sample in samples(plant.folder / "sub")))
    end = plant.end()
    subscriber.catch_up()
    subscriber.stop()
    assert first["sampled"] == first["delivered"] + first["waiting"] + first["dropped"]
    # Each number was received, or is in a gap; none was used again.
    seen = samples(plant.folder / "sub")
    missing = sum(gap["samples"] for gap in gaps(plant.folder / "sub"))
    assert len({sample["seq"] for sample in seen}) + missing == end["sampled"]
    assert min(sample["seq"] for sample in seen if sample["epoch"] == epoch) > first["sampled"]
