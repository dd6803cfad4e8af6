// The chart: uPlot draws axes and steps; hooks draw what belongs to the history only: hatches where nothing
// is known, the age of each change, lanes of booleans, marks, cursors.
import { useEffect, useRef } from 'preact/hooks';
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import type { History } from '../../api/types';
import { formatNumber, language, t } from '../../i18n';
import { theme } from '../../shell/theme';
import { color, drawMarks, marksNear } from './chart_marks';
import { changesOf, curveOf, spansOf } from './data';
import { cursors, frozen, goLive, marks, pens, range, width, zoomTo } from './state';
import { type Drawn, drawBands, drawHatches, hasAxis, hasTrack, isLane, penCanvasColor } from './tracks';

/** The change of a value happened somewhere between two polls: a band from the poll before to this one. */
function drawAges(u: uPlot, history: History, drawn: Drawn[]): void {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.globalAlpha = 0.22;
  for (const its of drawn) {
    if (!hasAxis(its)) continue;
    const variable = history.variables.find((one) => one.name === its.name);
    if (!variable) continue;
    ctx.fillStyle = penCanvasColor(its.pen);
    for (const change of changesOf(variable)) {
      const left = u.valToPos(change.from, 'x', true);
      const right = u.valToPos(change.to, 'x', true);
      const [a, b] = [u.valToPos(change.before, its.name, true), u.valToPos(change.after, its.name, true)];
      if (right - left >= 1) ctx.fillRect(left, Math.min(a, b), right - left, Math.max(1, Math.abs(a - b)));
    }
  }
  ctx.restore();
}

const AXIS = 64; // pixels, or more where a label is long
const MOST_OF_WIDTH = 0.4; // for the axes
const DAY = 86_400;

/** Times in the language of the page; the day below the first one and where it changes. */
function timeLabels(_: uPlot, times: number[], _axis: number, _space: number, step: number): string[] {
  const day = (time: number) =>
    new Date(time * 1000).toLocaleDateString(language.peek(), { day: 'numeric', month: 'short' });
  if (step >= DAY) return times.map(day);
  return times.map((time, i) => {
    const clock = new Date(time * 1000).toLocaleTimeString(language.peek(), {
      hour: '2-digit',
      minute: '2-digit',
      ...(step < 60 && { second: '2-digit' }),
      ...(step < 1 && { fractionalSecondDigits: 3 as const }),
      hour12: false,
    });
    const its = day(time);
    return i === 0 || its !== day(times[i - 1]!) ? `${clock}\n${its}` : clock;
  });
}

function options(history: History, drawn: Drawn[], size: { width: number; height: number }): uPlot.Options {
  const line = color('--hairline');
  const text = color('--muted');
  const numbers = drawn.filter(hasAxis);
  const lanes = drawn.filter(isLane).length;
  const tracks = drawn.filter((its) => hasTrack(its, drawn)).length;
  // The axes of the first pens; a narrow chart has space for few.
  const axes = Math.max(1, Math.floor((size.width * MOST_OF_WIDTH) / AXIS));
  return {
    ...size,
    cursor: { drag: { x: true, y: false, setScale: false } },
    legend: { show: false },
    scales: {
      x: { time: true, range: () => [Date.parse(history.from) / 1000, Date.parse(history.to) / 1000] },
      ...Object.fromEntries(
        numbers.map((its) => [
          its.name,
          {
            // Bands of booleans are at the bottom, those of outages at the top.
            range: (_: uPlot, min: number | null, max: number | null): [number, number] => {
              if (min === null || max === null) return [0, 1];
              const span = max - min || Math.abs(max) || 1;
              return [min - span * (0.06 + lanes * 0.09), max + span * (0.08 + tracks * 0.05)];
            },
          },
        ]),
      ),
    },
    axes: [
      {
        stroke: text,
        space: 76,
        grid: { stroke: line, width: 1 },
        ticks: { stroke: line },
        values: timeLabels,
      },
      ...numbers.slice(0, axes).map(
        (its, i): uPlot.Axis => ({
          scale: its.name,
          side: i % 2 === 0 ? 3 : 1,
          stroke: penCanvasColor(its.pen),
          size: (_, labels) =>
            Math.max(AXIS, 24 + 7.5 * Math.max(0, ...(labels ?? []).map((one) => one.length))),
          grid: { show: i === 0, stroke: line, width: 1 },
          ticks: { stroke: line },
          values: (_, splits) => splits.map((value) => formatNumber(value, 9)),
        }),
      ),
    ],
    series: [
      {},
      ...numbers.map(
        (its): uPlot.Series => ({
          scale: its.name,
          stroke: penCanvasColor(its.pen),
          width: 1.5,
          paths: uPlot.paths.stepped!({ align: 1 }),
          points: { show: false },
          spanGaps: false,
        }),
      ),
    ],
    hooks: {
      drawAxes: [(u) => drawHatches(u, drawn)],
      draw: [
        (u) => {
          drawAges(u, history, drawn);
          drawBands(u, drawn);
          drawMarks(u);
        },
      ],
      setSelect: [
        (u) => {
          if (u.select.width < 4) return;
          zoomTo({
            from: u.posToVal(u.select.left, 'x') * 1000,
            to: u.posToVal(u.select.left + u.select.width, 'x') * 1000,
          });
          u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        },
      ],
    },
  };
}

export function drawnOf(history: History): Drawn[] {
  return pens.value.flatMap((name, pen) => {
    const variable = history.variables.find((its) => its.name === name);
    if (!variable) return [];
    return [
      {
        name,
        pen,
        type: variable.type,
        curve: curveOf(history, variable),
        spans: spansOf(history, variable),
      },
    ];
  });
}

const HEIGHT = 420;

export function Chart({ history }: { history: History }) {
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const observer = new ResizeObserver(() => {
      width.value = Math.max(200, Math.floor(box.current?.clientWidth ?? 1000));
    });
    observer.observe(box.current!);
    return () => observer.disconnect();
  }, []);

  // uPlot keeps its options: another picture is another chart.
  useEffect(() => {
    const drawn = drawnOf(history);
    const numbers = drawn.filter(hasAxis);
    const tables = numbers.map((its): uPlot.AlignedData => [its.curve.times, its.curve.values]);
    const data: uPlot.AlignedData = tables.length > 0 ? uPlot.join(tables) : [[]];
    const height = Math.max(HEIGHT, Math.min(900, window.innerHeight - 380));
    const chart = new uPlot(options(history, drawn, { width: width.peek(), height }), data, box.current!);
    const click = (event: MouseEvent) => {
      const time = chart.posToVal(event.offsetX, 'x') * 1000;
      cursors.value = event.shiftKey ? { ...cursors.peek(), b: time } : { ...cursors.peek(), a: time };
    };
    chart.over.addEventListener('click', click);
    chart.over.addEventListener('mousemove', (event) => {
      chart.over.title = marksNear(chart, event.offsetX);
    });
    const redraw = [cursors.subscribe(() => chart.redraw(false)), marks.subscribe(() => chart.redraw(false))];
    return () => {
      for (const stop of redraw) stop();
      chart.destroy();
    };
  }, [history, theme.value, language.value, width.value, pens.value]);

  const move = (event: KeyboardEvent) => {
    const { from, to } = range();
    const step = (to - from) / 100;
    const key = event.shiftKey ? 'b' : 'a';
    const now = cursors.peek()[key] ?? (from + to) / 2;
    if (event.key === 'ArrowLeft') cursors.value = { ...cursors.peek(), [key]: now - step };
    else if (event.key === 'ArrowRight') cursors.value = { ...cursors.peek(), [key]: now + step };
    else if (event.key === 'Escape') cursors.value = { a: null, b: null };
    else if (event.key === 'l' && frozen.peek()) goLive();
    else return;
    event.preventDefault();
  };
  return (
    <div
      class="chart"
      ref={box}
      role="application"
      tabIndex={0}
      aria-label={t.value.trends.chart(pens.value.join(', '))}
      onKeyDown={move}
    />
  );
}
