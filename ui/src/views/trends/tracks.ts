// What is known of no value: hatches. Those of the whole history cross the chart; those of one pen are in its
// own track, so that the others stay readable. Booleans are lanes at the bottom.
import type uPlot from 'uplot';
import { color } from './chart_marks';
import type { Curve, Span, SpanKind } from './data';

const LANE = 16;

export interface Drawn {
  name: string;
  pen: number;
  type: string;
  curve: Curve;
  spans: Span[];
}

export const isLane = (its: Drawn) => its.type === 'bool';
export const hasValues = (its: Drawn) => its.curve.values.some((value) => value !== null);
/** A pen with an axis: numbers that there are. */
export const hasAxis = (its: Drawn) => !isLane(its) && hasValues(its);
/** With one pen its outage is that of the chart. */
const inTrack = (span: Span, drawn: Drawn[]) => span.own && drawn.length > 1;
export const hasTrack = (its: Drawn, drawn: Drawn[]) =>
  !isLane(its) && its.spans.some((span) => inTrack(span, drawn));

export const penColor = (index: number) => `var(--pen-${(index % 6) + 1})`;
export const penCanvasColor = (index: number) => color(`--pen-${(index % 6) + 1}`);

const HATCHES: Record<SpanKind, { color: string; step: number; rising: boolean }> = {
  restart: { color: '--idle', step: 9, rising: true },
  replaced: { color: '--idle', step: 14, rising: false },
  lost: { color: '--warn', step: 6, rising: true },
  damaged: { color: '--bad', step: 4, rising: true },
  bad: { color: '--bad', step: 7, rising: false },
  uncertain: { color: '--warn', step: 12, rising: false },
};

interface Band {
  top: number;
  height: number;
}

function hatch(u: uPlot, span: Span, { top, height }: Band, stroke: string): void {
  const { ctx, bbox } = u;
  const left = Math.max(bbox.left, u.valToPos(span.from, 'x', true));
  const right = Math.min(bbox.left + bbox.width, u.valToPos(span.to, 'x', true));
  if (right <= bbox.left || left >= bbox.left + bbox.width) return;
  const style = HATCHES[span.kind];
  const step = style.step * devicePixelRatio;
  ctx.save();
  ctx.beginPath();
  ctx.rect(left, top, Math.max(1, right - left), height);
  ctx.clip();
  ctx.strokeStyle = stroke;
  ctx.globalAlpha = 0.55;
  ctx.lineWidth = devicePixelRatio;
  ctx.beginPath();
  for (let x = left - height; x < right + height; x += step) {
    const [x0, x1] = style.rising ? [x, x + height] : [x + height, x];
    ctx.moveTo(x0, top + height);
    ctx.lineTo(x1, top);
  }
  ctx.stroke();
  ctx.restore();
}

/** The name of a pen in its band, with an edge around it: it is read above a filled one too. */
function label(u: uPlot, name: string, { top, height }: Band): void {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.font = `${11 * devicePixelRatio}px sans-serif`;
  ctx.textAlign = 'left';
  ctx.textBaseline = 'middle';
  ctx.fillStyle = color('--text');
  ctx.strokeStyle = color('--surface');
  ctx.lineWidth = 3 * devicePixelRatio;
  const [x, y] = [bbox.left + 4 * devicePixelRatio, top + height / 2];
  ctx.strokeText(name, x, y);
  ctx.fillText(name, x, y);
  ctx.restore();
}

/** The band of each pen that has one: booleans from the bottom, outages of other pens from the top. */
function bandsOf(u: uPlot, drawn: Drawn[]): Map<Drawn, Band> {
  const height = LANE * devicePixelRatio;
  const bands = new Map<Drawn, Band>();
  let [top, bottom] = [u.bbox.top, u.bbox.top + u.bbox.height];
  for (const its of drawn) {
    if (isLane(its)) {
      bottom -= height;
      bands.set(its, { top: bottom, height });
    } else if (hasTrack(its, drawn)) {
      bands.set(its, { top, height });
      top += height;
    }
  }
  return bands;
}

/** Below the curves: hatches of the whole chart, each once, and of the pens. */
export function drawHatches(u: uPlot, drawn: Drawn[]): void {
  const bands = bandsOf(u, drawn);
  const seen = new Set<string>();
  for (const its of drawn)
    for (const span of its.spans) {
      const band = bands.get(its);
      if (band && inTrack(span, drawn)) {
        hatch(u, span, band, penCanvasColor(its.pen));
        continue;
      }
      const key = `${span.from}/${span.to}/${span.kind}`;
      if (!seen.has(key)) hatch(u, span, u.bbox, color(HATCHES[span.kind].color));
      seen.add(key);
    }
}

/** Above the curves: booleans, filled where the value is true, and the names of the bands. */
export function drawBands(u: uPlot, drawn: Drawn[]): void {
  const { ctx, bbox } = u;
  const margin = 3 * devicePixelRatio;
  for (const [its, band] of bandsOf(u, drawn)) {
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, band.top, bbox.width, band.height);
    ctx.clip();
    ctx.fillStyle = penCanvasColor(its.pen);
    for (const [i, time] of isLane(its) ? its.curve.times.entries() : []) {
      if (!its.curve.values[i]) continue;
      const left = u.valToPos(time, 'x', true);
      const right = u.valToPos(its.curve.times[i + 1] ?? time, 'x', true);
      ctx.fillRect(left, band.top + margin, Math.max(1, right - left), band.height - 2 * margin);
    }
    ctx.restore();
    label(u, its.name, band);
  }
}
