// The frames that the page keeps: the last ones, while the view is open.
import { computed, signal } from '@preact/signals';
import { openStream, type Stream } from '../../api/stream';
import type { Frame } from '../../api/types';
import { frameWords } from './words';

const MOST_FRAMES = 2000;

export interface NumberedFrame extends Frame {
  number: number;
}

export const frames = signal<NumberedFrame[]>([]);
export const missed = signal(0);
export const paused = signal(false);
export const device = signal('');
export const functionCode = signal('');
export const errorsOnly = signal(false);
export const text = signal('');

let last = 0;
let waiting: NumberedFrame[] = [];
let timer = 0;

function show(): void {
  timer = 0;
  if (paused.peek()) return;
  frames.value = [...frames.peek(), ...waiting].slice(-MOST_FRAMES);
  waiting = [];
}

const NAMES_THE_FRAME_BEFORE = ['late_response', 'surplus_response'];

/** The frame that a late or surplus response is: the program names it behind the frame. */
function isNamed(frame: Frame, incident: Frame): boolean {
  return (
    NAMES_THE_FRAME_BEFORE.includes(incident.incident ?? '') &&
    frame.direction === 'rx' &&
    frame.incident === undefined &&
    frame.line === incident.line &&
    frame.unit === incident.unit &&
    frame.t === incident.t
  );
}

/** Adds a row; a late or surplus response is one row. */
export function put(rows: NumberedFrame[], frame: Frame): void {
  const before = rows.at(-1);
  if (before && isNamed(before, frame)) rows[rows.length - 1] = { ...before, ...frame };
  else rows.push({ ...frame, number: ++last });
}

/** The table follows five times a second; a paused one keeps what it shows, and the newest frames. */
export function openFrames(): Stream {
  return openStream(
    'traffic',
    {
      frames: (its: Frame[]) => {
        for (const frame of its) put(waiting, frame);
        waiting = waiting.slice(-MOST_FRAMES);
        if (!timer) timer = window.setTimeout(show, 200);
      },
      missed: (its: { count: number }) => {
        missed.value += its.count;
      },
    },
    () => {},
  );
}

export function togglePause(): void {
  paused.value = !paused.peek();
  if (!paused.peek()) show();
}
export function clearFrames(): void {
  frames.value = [];
  waiting = [];
  missed.value = 0;
}

/** An exception response has the highest bit of its function set. */
export const isError = (frame: Frame) =>
  frame.fault !== undefined ||
  (frame.function ?? 0) >= 0x80 ||
  (frame.incident !== undefined && frame.incident !== 'connected');

/** What happens on a line, as dropped bytes, concerns each of its devices. */
const isOfDevice = (frame: Frame, lines: Set<string>) =>
  frame.device === device.value ||
  (frame.device === undefined && (frame.fault ?? frame.incident) !== undefined && lines.has(frame.line));

export const shownFrames = computed(() => {
  const wanted = text.value.trim().toLowerCase();
  const lines = new Set(frames.value.filter((its) => its.device === device.value).map((its) => its.line));
  return frames.value
    .filter(
      (frame) =>
        (device.value === '' || isOfDevice(frame, lines)) &&
        (functionCode.value === '' || ((frame.function ?? -1) & 0x7f) === Number(functionCode.value)) &&
        (!errorsOnly.value || isError(frame)) &&
        (wanted === '' || `${frameWords(frame)} ${frame.raw ?? ''}`.toLowerCase().includes(wanted)),
    )
    .reverse();
});
export const devices = computed(() =>
  [...new Set(frames.value.map((frame) => frame.device).filter((its) => its !== undefined))].sort(),
);
export const functionCodes = computed(() =>
  [
    ...new Set(
      frames.value.flatMap((frame) => (frame.function === undefined ? [] : [frame.function & 0x7f])),
    ),
  ].sort((a, b) => a - b),
);
