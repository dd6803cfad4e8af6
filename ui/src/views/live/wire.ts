// Registers as they were on the wire, for the cells that show them.
import { effect, signal } from '@preact/signals';
import { get } from '../../api/client';
import type { WireItems } from '../../api/types';
import { view } from '../../shell/route';

const AGAIN_MS = 1000;
const MOST = 200;

/** Names of the variables whose registers are shown. */
export const wanted = signal<string[]>([]);
export const wireItems = signal<Map<string, WireItems>>(new Map());

let timer = 0;

async function ask(): Promise<void> {
  window.clearTimeout(timer);
  const names = wanted.peek().slice(0, MOST);
  if (names.length === 0 || view.peek() !== 'live') return;
  if (!document.hidden)
    try {
      const answer = await get<{ registers: WireItems[] }>('registers', { variable: names });
      wireItems.value = new Map(answer.registers.map((its) => [its.variable, its]));
    } catch {
      // The next answer has them: the project may just have changed.
    }
  window.clearTimeout(timer);
  timer = window.setTimeout(() => void ask(), AGAIN_MS);
}

effect(() => {
  void wanted.value;
  void view.value;
  void ask();
});

/** "3F80 0000", bits as "1 0". */
export function itemsText(its: WireItems): string {
  return (its.items ?? [])
    .map((item) => (its.bits ? String(item) : item.toString(16).toUpperCase().padStart(4, '0')))
    .join(' ');
}
