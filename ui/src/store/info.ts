// What the program is and may do, and its state each second.
import { computed, signal } from '@preact/signals';
import { get } from '../api/client';
import type { Info, Status } from '../api/types';

export const info = signal<Info | null>(null);
export const status = signal<Status | null>(null);
export const connected = signal(false);
export const mayWrite = computed(() => info.value?.allow_write ?? false);
export const mayEdit = computed(() => info.value?.editable ?? false);

/** The clock of the program minus that of this browser, in milliseconds. */
export const clockOffset = signal(0);
export const programNow = () => Date.now() + clockOffset.peek();

export async function loadInfo(): Promise<void> {
  const answer = await get<Info>('info');
  clockOffset.value = Date.parse(answer.now) - Date.now();
  info.value = answer;
}
