"""The journal of an output on a small disk, and with files that another program changed between two runs."""
import os
import subprocess

import pytest

from mqtt_plant import PLANT, Broker, Subscriber, end, gaps, run, samples, wait_until
from program import start, until


@pytest.fixture
def plant(tmp_path):
    broker = Broker(tmp_path)
    project = tmp_path / "plant.yaml"
    project.write_text(PLANT.format(port=broker.port))
    yield tmp_path, broker, project
    if broker.process and broker.process.poll() is None:
        broker.kill()


def journal_of(folder):
    return folder / "plant.journal/cloud"


def deliver(folder, broker, project):
    """Delivers what waits, and ends. Returns the summary, the numbers of the samples, and the gaps."""
    broker.start()
    subscriber = Subscriber(broker, folder / "sub")
    program = run(project)
    seen = len(samples(folder / "sub"))
    wait_until(lambda: len(samples(folder / "sub")) > seen + 20)
    output = end(program)
    subscriber.catch_up()
    subscriber.stop()
    return output, {sample["seq"] for sample in samples(folder / "sub")}, gaps(folder / "sub")


def truncate(path):
    os.truncate(path, 0)


def replace_by_folder(path):
    path.unlink()
    path.mkdir()


@pytest.mark.parametrize("damage", [truncate, replace_by_folder])
def test_samples_of_the_last_file_are_counted(plant, damage):
    folder, broker, project = plant
    program = run(project)
    wait_until(lambda: sum(file.stat().st_size for file in journal_of(folder).glob("segment-*")) > 1000)
    first = end(program)
    damage(max(journal_of(folder).glob("segment-*")))
    output, seen, found = deliver(folder, broker, project)
    damaged = sum(gap["samples"] for gap in found if gap["cause"] == "damaged")
    assert damaged == first["sampled"] > 0
    assert output["sampled"] == output["delivered"] + output["dropped"] + output["waiting"]
    assert len(seen) + sum(gap["samples"] for gap in found) == output["sampled"]
    aside = output["journal"]["set_aside"]
    if damage is replace_by_folder:
        assert aside.startswith(str(journal_of(folder) / "segment-")) and os.path.lexists(aside)
    else:
        assert aside is None


@pytest.fixture
def disk(tmp_path):
    folder = tmp_path / "disk"
    folder.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "none", folder], capture_output=True)
    if mounted.returncode:
        pytest.skip("no file system can be mounted here: the simulated disk has the same")
    yield folder
    subprocess.run(["umount", folder], check=True)


def fill(disk):
    """Writes a file until nothing more fits. Returns it."""
    for segment in (disk / "cloud").glob("segment-*"):
        os.truncate(segment, segment.stat().st_size)  # frees what is reserved behind its end
    ballast = disk / "ballast"
    with open(ballast, "wb", buffering=0) as file:
        try:
            while file.write(bytes(4096)) == 4096:
                pass
        except OSError:
            pass
    return ballast


def test_a_full_disk_is_used_to_its_end_and_loses_no_count(plant, disk):
    folder, broker, project = plant
    project.write_text(project.read_text() + f"    directory: {disk}\n")
    program = run(project)  # a disk that is smaller than a segment
    wait_until(lambda: sum(file.stat().st_size for file in (disk / "cloud").glob("segment-*")) > 200)
    first = end(program)
    assert first["journal"]["failure"] is None and first["journal"]["buffer_samples"] == 0
    ballast = fill(disk)
    with start("run", project, "--json") as running:
        until(lambda: sum(e["event"] == "value" for e in running.events()) > 10, "values")
        running.interrupt(code=None)
        second = running.events()[-1]["outputs"][0]
    assert second["journal"]["failure"] and second["journal"]["buffer_samples"] > 0
    assert second["waiting"] == second["sampled"]
    ballast.unlink()
    output, seen, found = deliver(folder, broker, project)
    full = [gap["samples"] for gap in found if gap["cause"] == "disk_full"]
    assert full == [second["journal"]["buffer_samples"]]
    assert len(seen) + sum(gap["samples"] for gap in found) == output["sampled"]
