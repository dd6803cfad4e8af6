// The search for devices as the program reports it.
import { signal } from '@preact/signals';
import { post } from '../../api/client';
import type { Search } from '../../api/types';
import { t } from '../../i18n';
import { errorText } from '../../shell/toasts';

export const search = signal<Search | null>(null);
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

export const probe = (target: string, unit: number): void =>
  void ask(post<Search>('search/probe', { target, unit }));
