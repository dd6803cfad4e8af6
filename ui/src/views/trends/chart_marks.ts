// Lines of the chart at one time: marks of messages and commands, and the cursors.
import type uPlot from 'uplot';
import type { HistoryMark } from '../../api/types';
import { formatClock } from '../../i18n';
import { cursors, marks } from './state';

/** The value of a design token. */
export const color = (name: string) =>
  getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function vertical(u: uPlot, time: number, stroke: string, label: string): void {
  const { ctx, bbox } = u;
  const x = u.valToPos(time, 'x', true);
  if (x < bbox.left || x > bbox.left + bbox.width) return;
  ctx.save();
  ctx.strokeStyle = stroke;
  ctx.fillStyle = stroke;
  ctx.lineWidth = devicePixelRatio;
  ctx.setLineDash(label ? [] : [2 * devicePixelRatio, 3 * devicePixelRatio]);
  ctx.beginPath();
  ctx.moveTo(x, bbox.top);
  ctx.lineTo(x, bbox.top + bbox.height);
  ctx.stroke();
  if (label) {
    ctx.font = `${12 * devicePixelRatio}px sans-serif`;
    ctx.fillText(label, x + 3 * devicePixelRatio, bbox.top + 12 * devicePixelRatio);
  }
  ctx.restore();
}

const MARK_COLORS = { info: '--idle', warning: '--warn', error: '--bad' } as const;
const markColor = (its: HistoryMark) =>
  its.kind === 'command' && its.severity === 'info' ? '--accent' : MARK_COLORS[its.severity];

/** A flag at the top of a command's line. */
function flag(u: uPlot, time: number, fill: string): void {
  const { ctx, bbox } = u;
  const x = u.valToPos(time, 'x', true);
  if (x < bbox.left || x > bbox.left + bbox.width) return;
  const size = 5 * devicePixelRatio;
  ctx.save();
  ctx.fillStyle = fill;
  ctx.beginPath();
  ctx.moveTo(x - size, bbox.top);
  ctx.lineTo(x + size, bbox.top);
  ctx.lineTo(x, bbox.top + 1.6 * size);
  ctx.fill();
  ctx.restore();
}

const MARK_DISTANCE = 5; // pixels

/** The texts of the marks at a place of the chart. */
export function marksNear(u: uPlot, left: number): string {
  return marks
    .peek()
    .filter((its) => Math.abs(u.valToPos(its.time / 1000, 'x') - left) <= MARK_DISTANCE)
    .map((its) => `${formatClock(its.time, true)} ${its.text}`)
    .join('\n');
}

export function drawMarks(u: uPlot): void {
  for (const its of marks.peek()) {
    vertical(u, its.time / 1000, color(markColor(its)), '');
    if (its.kind === 'command') flag(u, its.time / 1000, color(markColor(its)));
  }
  const { a, b } = cursors.peek();
  if (a !== null) vertical(u, a / 1000, color('--text'), 'A');
  if (b !== null) vertical(u, b / 1000, color('--text'), 'B');
}
