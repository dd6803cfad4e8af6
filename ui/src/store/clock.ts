// The program's clock, and the ticks of everything on the page that grows older: ages, sparklines.
import { effect, signal } from '@preact/signals';
import { get } from '../api/client';
import type { Info } from '../api/types';
import { ClockEstimate } from './clock_estimate';
import { connected } from './info';

const TICK_MS = 200;
/** The first exchanges follow each other quickly: one of them has a short round trip. */
const FIRST_EXCHANGES = 5;
const FIRST_PAUSE_MS = 250;
const PAUSE_MS = 10_000;
/** performance.now() stands still while some computers sleep, and Date.now() is set by people. */
const CLOCKS_PART_MS = 500;
/** A message beyond the estimate begins a new one, but not each of ten messages a second. */
const LEAST_ANEW_MS = 1000;

const estimate = new ClockEstimate();
const differenceOfClocks = () => Date.now() - performance.now();

/** The program's time; until it is known that of this browser. */
export const programNow = () => estimate.now(performance.now()) ?? Date.now();

/** The latest time that the program can have, five times a second; null: unknown. No ticks while hidden. */
export const tick = signal<number | null>(null);
export const second = signal(Math.floor(programNow() / 1000));
export const clockKnown = signal(false);

function refresh(): void {
  tick.value = estimate.latest(performance.now());
  second.value = Math.floor(programNow() / 1000);
  clockKnown.value = tick.peek() !== null;
}

let difference = differenceOfClocks();
const clocksParted = (before: number) => Math.abs(differenceOfClocks() - before) > CLOCKS_PART_MS;
setInterval(() => {
  if (clocksParted(difference)) measureAnew();
  difference = differenceOfClocks();
  if (!document.hidden) refresh();
}, TICK_MS);

/** @returns the program's time at an instant between the call and its end; milliseconds since 1970 */
export async function exchangeTime(): Promise<number> {
  const before = differenceOfClocks();
  const sent = performance.now();
  const program = Date.parse((await get<Info>('info')).now);
  // A sleep in between made the round trip look shorter than it was.
  if (!clocksParted(before)) estimate.add(sent, program, performance.now());
  refresh();
  return program;
}

let timer = 0;
let left = 0;

async function exchange(): Promise<void> {
  window.clearTimeout(timer);
  try {
    await exchangeTime();
  } catch {
    // The stream reports that the program does not answer.
  }
  window.clearTimeout(timer);
  if (left > 0) --left;
  if (connected.peek() && !document.hidden)
    timer = window.setTimeout(() => void exchange(), left > 0 ? FIRST_PAUSE_MS : PAUSE_MS);
}

function exchangeOften(): void {
  left = FIRST_EXCHANGES;
  if (connected.peek() && !document.hidden) void exchange();
}

let anewAt = Number.NEGATIVE_INFINITY;

function measureAnew(): void {
  anewAt = performance.now();
  estimate.forget();
  refresh();
  exchangeOften();
}

/** Each message of a stream has a time of the program, which has passed. */
export function checkClock(program: number): void {
  const local = performance.now();
  if (local - anewAt > LEAST_ANEW_MS && estimate.contradicts(local, program)) measureAnew();
}

// A hidden page measures nothing, and the drift of hours makes the estimate useless.
document.addEventListener('visibilitychange', () => {
  if (!document.hidden) exchangeOften();
});
effect(() => {
  if (connected.value) exchangeOften();
});
