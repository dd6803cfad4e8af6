// One clock for everything on the page that grows older: ages, sparklines.
import { signal } from '@preact/signals';
import { programNow } from './info';

const TICK_MS = 200;

/** The program's time, five times a second. A hidden page has no ticks. */
export const tick = signal(programNow());
export const second = signal(Math.floor(programNow() / 1000));

setInterval(() => {
  if (document.hidden) return;
  tick.value = programNow();
  second.value = Math.floor(tick.peek() / 1000);
}, TICK_MS);
