// The live values. Each value has a signal of its own, so that a change draws one row again and not the
// table. Changes are applied once for each frame of the screen.
import { type Signal, signal } from '@preact/signals';
import { openStream, type Stream } from '../api/stream';
import type { LiveValue, Notice, ReadBatch, Snapshot, Status, ValueBatch } from '../api/types';
import { withoutDefault } from '../views/live/format';
import { checkClock } from './clock';
import { connected, loadInfo, status } from './info';
import { refreshProject } from './project';

const MOST_NOTICES = 200;
/** Numbers of the last minute for the sparkline. */
const MOST_POINTS = 60;

/** The points of a sparkline: one for each second, [second, value]; NaN: not good from then on. */
export type Recent = [number, number][];

export const values = signal<Signal<LiveValue>[]>([]);
export const valueTime = signal(0);
export const notices = signal<Notice[]>([]);
export const recent = new Map<string, Recent>();
/** Called after values, or the instants of their reads, have changed. */
export const readObservers = new Set<() => void>();

let byName = new Map<string, Signal<LiveValue>>();
let waiting: ValueBatch[] = [];
let frame = 0;

export const liveValue = (name: string): Signal<LiveValue> | undefined => byName.get(name);

function remember(value: LiveValue, time: number): void {
  const number = typeof value.value === 'boolean' ? Number(value.value) : value.value;
  const lost = value.quality === 'bad' || value.quality === 'never_read';
  if (lost && recent.has(value.name)) note(value.name, Number.NaN, time);
  else if (!lost && typeof number === 'number') note(value.name, number, time);
}

function note(name: string, number: number, time: number): void {
  const second = Math.floor(time / 1000);
  let points = recent.get(name);
  if (!points) {
    points = [];
    recent.set(name, points);
  }
  const last = points[points.length - 1];
  if (last && last[0] === second) last[1] = number;
  else points.push([second, number]);
  if (points.length > MOST_POINTS) points.shift();
}

function onSnapshot(snapshot: Snapshot): void {
  checkClock(snapshot.time);
  waiting = [];
  const made = snapshot.values.map((value) => signal(withoutDefault(value)));
  byName = new Map(made.map((its) => [its.peek().name, its]));
  for (const name of recent.keys()) if (!byName.has(name)) recent.delete(name);
  for (const its of made) remember(its.peek(), snapshot.time);
  values.value = made;
  valueTime.value = snapshot.time;
  notifyObservers();
}

function notifyObservers(): void {
  for (const notify of [...readObservers]) notify();
}

function apply(): void {
  frame = 0;
  const batches = waiting;
  waiting = [];
  for (const batch of batches) {
    for (const [index, value, text, quality, reason, sampled_at, words] of batch.values) {
      const its = values.peek()[index];
      if (!its) continue;
      const { words: _, ...before } = its.peek();
      const next: LiveValue = { ...before, value, text, quality, reason, sampled_at };
      if (words !== undefined) next.words = words;
      its.value = withoutDefault(next);
      remember(its.peek(), batch.time);
    }
    valueTime.value = batch.time;
  }
  notifyObservers();
}

function onValues(batch: ValueBatch): void {
  checkClock(batch.time);
  waiting.push(batch);
  // A hidden page gets no frames: its memory must not grow.
  if (document.hidden) apply();
  else if (!frame) frame = requestAnimationFrame(apply);
}

// The value stays as it is, so nothing is drawn for it: what shows an age looks at it with each tick.
function onReads(batch: ReadBatch): void {
  checkClock(batch.time);
  if (waiting.length > 0) apply();
  for (const [sampled_at, first, last] of batch.reads)
    for (let index = first; index <= last; ++index) {
      const its = values.peek()[index];
      if (its) its.peek().sampled_at = sampled_at;
    }
  valueTime.value = batch.time;
  notifyObservers();
}

export function startLive(): Stream {
  return openStream(
    'stream',
    {
      snapshot: onSnapshot,
      values: onValues,
      reads: onReads,
      status: (its: Status) => {
        status.value = its;
      },
      notice: (its: Notice) => {
        notices.value = [...notices.peek(), its].slice(-MOST_NOTICES);
      },
      configuration: () => {
        void loadInfo().catch(() => {});
        void refreshProject();
      },
    },
    (is) => {
      connected.value = is;
      if (is) void loadInfo().catch(() => {});
    },
  );
}
