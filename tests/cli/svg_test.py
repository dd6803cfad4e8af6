"""`takt plan --svg`: a valid picture that shows the plan."""
import xml.etree.ElementTree as xml

import pytest

from program import ROOT, takt
from projects import at, scenario_1, serial

SVG = "{http://www.w3.org/2000/svg}"
ODD_NAMES = """\
takt: 1
lines:
  - name: "<шкаф> & \\"1\\""
    transport: tcp
    host: 192.0.2.1
    devices:
      - name: "Насос <温度> & ²"
        address: 3
        poll_period: 50ms
        variables:
          - {name: "a < b & c > d", type: int16, register: 0, read: 0x03}
          - {name: "тиск \\"P\\"", type: int16, register: 9, read: 0x04, period: 80ms}
  - name: written only
    transport: tcp
    host: 192.0.2.2
    devices:
      - {name: W, address: 1, variables: [
          {name: W1, type: int16, register: 1, write: 0x06, write_on_change: true}]}
"""
EXAMPLES = ["demo", "scenario-1", "scenario-2", "scenario-3", "boiler", "meters"]


def picture(path, *options):
    return xml.fromstring(takt("plan", path, "--svg", "-", *options).out.encode())


def texts(root):
    return ["".join(e.itertext()) for e in root.iter(SVG + "text")]


def strips(root):
    """The bars of each strip in time: (request, start, end, part lengths, (left, right) in pixels)."""
    for strip in root.iter(SVG + "g"):
        if strip.get("class") != "strip":
            continue
        bars = []
        for group in strip.iter(SVG + "g"):
            if group.get("class") not in ("bar", "bar background"):
                continue
            parts = [r for r in group.iter(SVG + "rect") if r.get("data-ns")]
            edges = [(float(r.get("x")), float(r.get("x")) + float(r.get("width"))) for r in parts]
            bars.append((int(group.get("data-request")), int(group.get("data-start-ns")),
                         int(group.get("data-end-ns")), [int(r.get("data-ns"))
                                                         for r in parts], (edges[0][0], edges[-1][1])))
        yield strip.get("data-strip"), sorted(bars, key=lambda bar: bar[1])


@pytest.mark.parametrize("example", EXAMPLES)
def test_bars_are_the_requests_one_after_the_other(example):
    path = ROOT / f"examples/{example}.yaml"
    requests = takt("plan", path, "--json").json["lines"][0]["requests"]
    drawn = list(strips(picture(path)))
    assert drawn[-1][0] == "enlarged" and drawn[-1][1]
    for _, bars in drawn:
        for (_, start, end, parts, _), (_, later, *_) in zip(bars, bars[1:]):
            assert end <= later, "two requests at once on one line"
        for request, start, end, parts, (left, right) in bars:
            bus_time = requests[request]["bus_time_us"] * 1000
            assert bus_time - 1000 < end - start <= bus_time
            assert 200 <= left < right <= 1176.5
        whole = [bar for bar in bars if bar[4][1] < 1175]  # not cut by the edge
        assert all(sum(parts) == end - start for _, start, end, parts, _ in whole)
    polled = {i for i, r in enumerate(requests) if r["period_ms"] is not None}
    assert {bar[0] for _, bars in drawn for bar in bars} <= polled


@pytest.mark.parametrize("language", ["en", "ru", "uk"])
def test_names_of_any_script_are_shown_as_they_are(project, language):
    root = picture(project(ODD_NAMES), "--lang", language)
    shown = " ".join(texts(root))
    assert 'Насос <温度> & ² · 3' in shown and '<шкаф> & "1"' in shown
    titles = " ".join("".join(e.itertext()) for e in root.iter(SVG + "title"))
    assert "a < b & c > d" in titles and 'тиск "P"' in titles


def test_it_stands_alone(project):
    text = takt("plan", project(ODD_NAMES), "--svg", "-").out
    for foreign in ("<script", "href", "url(", "@import", "onload"):
        assert foreign not in text
    assert text.count("http") == 1, "the namespace only"


def test_the_strategies_are_compared(project):
    root = picture(project(scenario_1()))
    bars = {
        style: float(r.get("width"))
        for style in ("single", "classic", "optimal") for r in root.iter(SVG + "rect")
        if r.get("class") == style
    }
    assert bars["single"] > bars["classic"] >= bars["optimal"] > 0
    shown = texts(root)
    assert {"single", "classic", "optimal"} <= set(shown)
    assert any("(-90 %)" in text for text in shown)


def test_thousands_of_requests_stay_bounded(project):
    path = project(
        serial(at(range(0, 7500, 3), "type: int16, read: 0x03"), group_requests="false", strategy="single",
               poll_period="60s"))
    text = takt("plan", path, "--svg", "-").out
    assert len(text) < 2_000_000
    assert any("2000" in t for t in texts(xml.fromstring(text.encode()))), "states that it was cut"


def test_it_is_written_to_a_file_beside_the_plan(project, tmp_path):
    path, svg = project(scenario_1()), tmp_path / "plan.svg"
    assert takt("plan", path, "--svg", svg).out == takt("plan", path).out
    assert xml.parse(svg).getroot().tag == SVG + "svg"
    svg.unlink()
    assert takt("plan", path, "--svg", svg, "--json").json["lines"]
    assert svg.exists()


def test_an_undrawable_plan_is_reported(project, tmp_path):
    result = takt("plan", project(scenario_1()), "--svg", tmp_path / "none" / "plan.svg", code=3)
    assert "none" in result.err
    svg = tmp_path / "broken.svg"
    takt("plan", project(serial(at([70000], "type: int16, read: 0x03"))), "--svg", svg, code=1)
    assert not svg.exists(), "no picture of a plan that does not exist"
