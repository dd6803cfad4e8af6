// What the program is and may do, and its state each second.
import { computed, signal } from '@preact/signals';
import { get } from '../api/client';
import type { Info, Status } from '../api/types';

export const info = signal<Info | null>(null);
export const status = signal<Status | null>(null);
export const connected = signal(false);
export const mayWrite = computed(() => info.value?.allow_write ?? false);
export const mayEdit = computed(() => info.value?.editable ?? false);

export async function loadInfo(): Promise<void> {
  info.value = await get<Info>('info');
}
