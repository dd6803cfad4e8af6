// The search for devices as the program reports it.
import { signal } from '@preact/signals';
import { post } from '../../api/client';
import type { Search } from '../../api/types';
import { t } from '../../i18n';
import { errorText } from '../../shell/toasts';

export const search = signal<Search | null>(null);
/** A search through a line of the project keeps to the time that no polled request needs. */
export const spare = signal(false);
/** Why the last call failed. */
export const problem = signal('');

export async function ask(call: Promise<Search>): Promise<void> {
  try {
    search.value = await call;
    problem.value = '';
  } catch (failure) {
    problem.value = errorText(failure);
  }
}

/** "Line rs485-1" for "line:rs485-1"; other targets as they are. */
export const placeText = (target: string): string =>
  target.startsWith('line:') ? t.value.devices.line(target.slice('line:'.length)) : target;

/** What a search of a line of the project sends beside its target. */
export const throughLine = (target: string): { spare?: boolean } =>
  target.startsWith('line:') && spare.peek() ? { spare: true } : {};

export const probe = (target: string, unit: number): void =>
  void ask(post<Search>('search/probe', { target, unit, ...throughLine(target) }));
