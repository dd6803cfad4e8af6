// The view is in the part of the address behind `#`: "#/trends?pens=a,b". A link opens the same view again.
import { computed, signal } from '@preact/signals';

export type View = 'overview' | 'project' | 'live' | 'trends' | 'traffic' | 'devices';
export const VIEWS: View[] = ['overview', 'project', 'live', 'trends', 'traffic', 'devices'];

const hash = signal(location.hash);
addEventListener('hashchange', () => {
  hash.value = location.hash;
});

export const view = computed<View>(() => {
  const name = hash.value.replace(/^#\/?/, '').split('?')[0];
  return VIEWS.find((its) => its === name) ?? 'overview';
});
/** The address names a view. */
export const isViewNamed = () => /^#\/?\w/.test(hash.peek());
export const query = computed(() => new URLSearchParams(hash.value.split('?')[1] ?? ''));

export function go(to: View, parameters: Record<string, string> = {}): void {
  const text = new URLSearchParams(parameters).toString();
  location.hash = `#/${to}${text ? `?${text}` : ''}`;
}

/** Opens a view without a new entry in the browser's history. */
export function show(to: View, parameters: Record<string, string> = {}): void {
  const text = new URLSearchParams(parameters).toString();
  history.replaceState(null, '', `#/${to}${text ? `?${text}` : ''}`);
  hash.value = location.hash;
}
/** Keeps the state of a view in the address. */
export const setQuery = (parameters: Record<string, string>) => show(view.peek(), parameters);
