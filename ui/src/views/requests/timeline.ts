// The view of a line's course: what of it is drawn at which scale. Pure.
import type { Course } from '../../api/types';

export interface Block {
  request: number;
  start: number; // ms
  end: number;
  late: boolean;
}

export const blocksOf = (course: Course): Block[] =>
  course.bars.map(([request, start, end, late]) => ({ request, start: start / 1000, end: end / 1000, late }));

export interface Window {
  from: number;
  to: number;
}

/** Zooms around a point; within 0 and the length. */
export function zoomed(window: Window, factor: number, center: number, length: number): Window {
  const least = Math.min(length, 1);
  const span = Math.min(length, Math.max(least, (window.to - window.from) * factor));
  const share = (center - window.from) / Math.max(window.to - window.from, 1e-9);
  return shifted({ from: center - span * share, to: center - span * share + span }, 0, length);
}
export function shifted(window: Window, by: number, length: number): Window {
  const span = Math.min(length, window.to - window.from);
  const from = Math.min(length - span, Math.max(0, window.from + by));
  return { from, to: from + span };
}

/** The blocks of a window, at most one for each pixel and request's device: the rest cannot be seen. */
export function visible(
  blocks: Block[],
  window: Window,
  pixels: number,
  lane: (request: number) => number,
): Block[] {
  const scale = pixels / Math.max(window.to - window.from, 1e-9);
  const last = new Map<number, number>();
  return blocks.filter((block) => {
    if (block.end < window.from || block.start > window.to) return false;
    const pixel = Math.floor((block.start - window.from) * scale);
    if ((block.end - block.start) * scale < 1 && last.get(lane(block.request)) === pixel) return false;
    last.set(lane(block.request), pixel);
    return true;
  });
}

/** Ticks at 1, 2 or 5 times a power of ten, at most about so many. */
export function ticks(window: Window, most: number): number[] {
  const least = (window.to - window.from) / Math.max(1, most);
  const power = 10 ** Math.floor(Math.log10(Math.max(least, 1e-6)));
  const step = [1, 2, 5, 10].map((its) => its * power).find((its) => its >= least - 1e-12) ?? 10 * power;
  const list: number[] = [];
  for (let at = Math.ceil(window.from / step - 1e-9) * step; at <= window.to + step * 1e-9; at += step)
    list.push(Number(at.toPrecision(12)));
  return list;
}
