// The course of a line in time: when its polled requests occupy it, without failures. Pure.
import type { PlannedRequest } from '../../api/types';

export interface Block {
  request: number;
  start: number; // ms
  end: number;
  late: boolean;
}
export interface Course {
  blocks: Block[];
  length: number; // ms
}

const MOST_BLOCKS = 4000;
const LONGEST_MS = 60_000;

interface Task {
  request: number;
  period: number;
  deadline: number;
  cost: number;
  release: number;
}

/**
 * Non-preemptive polling, as the master does it: first what has waited for longer than its deadline, then the
 * shortest deadline; or rounds in the order of addresses. Requests with the period 0 fill the rest, in turn.
 */
export function courseOf(requests: PlannedRequest[], order: string): Course {
  const tasks: Task[] = [];
  const fillers: Task[] = [];
  for (const [index, its] of requests.entries()) {
    if (its.period_ms === null || its.function === null) continue;
    const task = {
      request: index,
      period: its.period_ms,
      deadline: its.deadline_us === null ? its.period_ms : its.deadline_us / 1000,
      cost: its.bus_time_us / 1000,
      release: its.phase_ms ?? 0,
    };
    (its.period_ms > 0 ? tasks : fillers).push(task);
  }
  if (order === 'address')
    tasks.sort((a, b) => requests[a.request]!.unit - requests[b.request]!.unit || a.request - b.request);
  const busy = [...tasks, ...fillers].reduce((sum, its) => sum + its.cost, 0);
  const longest = tasks.reduce((most, its) => Math.max(most, its.period), 0);
  const length = Math.min(LONGEST_MS, Math.max(longest, busy));
  return { blocks: run(tasks, fillers, length, order === 'address'), length };
}

function mostUrgent(tasks: Task[], now: number, rounds: boolean, cursor: number): number {
  let best = -1;
  let bestClass = 2;
  let bestTime = 0;
  for (let i = 0; i < tasks.length; ++i) {
    const its = tasks[(cursor + i) % tasks.length]!;
    if (its.release > now + 1e-9) continue;
    if (rounds) return (cursor + i) % tasks.length;
    const overdue = now - its.release > its.deadline;
    const own = overdue ? 0 : 1;
    const time = overdue ? its.release + its.deadline : its.deadline;
    if (own > bestClass || (own === bestClass && time >= bestTime)) continue;
    best = i;
    bestClass = own;
    bestTime = time;
  }
  return best;
}

function run(tasks: Task[], fillers: Task[], length: number, rounds: boolean): Block[] {
  const blocks: Block[] = [];
  let [now, turn, cursor] = [0, 0, 0];
  const occupy = (task: Task, late: boolean) => {
    blocks.push({ request: task.request, start: now, end: now + task.cost, late });
    now += Math.max(task.cost, 1e-3);
  };
  while (now < length && blocks.length < MOST_BLOCKS) {
    const index = mostUrgent(tasks, now, rounds, cursor);
    const due = tasks[index];
    if (due) {
      if (rounds) cursor = (index + 1) % tasks.length;
      const start = now;
      occupy(due, start + due.cost > due.release + due.deadline + 1e-6);
      // Releases that passed while it waited are skipped.
      do due.release += due.period;
      while (due.release <= start);
      continue;
    }
    const next = tasks.reduce((least, its) => Math.min(least, its.release), Number.POSITIVE_INFINITY);
    const filler = fillers[turn % Math.max(1, fillers.length)];
    if (filler) {
      ++turn;
      occupy(filler, false);
    } else if (next < length) now = next;
    else break;
  }
  return blocks;
}

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
