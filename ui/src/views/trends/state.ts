// What is drawn: pens, range, cursors. The address keeps pens and range, so a link opens the same view.
import { computed, effect, signal } from '@preact/signals';
import { get } from '../../api/client';
import type { History, HistoryDamage, HistoryMark, HistorySeries } from '../../api/types';
import { query, setQuery, view } from '../../shell/route';
import { clockKnown, programNow } from '../../store/clock';
import { values } from '../../store/live';
import { firstPens } from './data';

export interface Range {
  from: number;
  to: number;
}

export const SPANS = { m1: 60, m10: 600, h1: 3600, h8: 28_800, d1: 86_400, d7: 604_800 } as const;
const MOST_PENS = 6;
const USED = 'takt.pens';
const REFRESH_MS = 1000;
const LEAST_SPAN_MS = 100;

export const pens = signal<string[]>([]);
/** Length of the live window in seconds. */
export const span = signal<number>(SPANS.m10);
/** null: live. */
export const frozen = signal<Range | null>(null);
export const cursors = signal<{ a: number | null; b: number | null }>({ a: null, b: null });
export const series = signal<HistorySeries[]>([]);
export const picture = signal<History | null>(null);
const listDamage = signal<HistoryDamage[]>([]);
/** What is damaged, as far as the picture, or else the list of the variables, has met it. */
export const damage = computed(() => picture.value?.damage ?? listDamage.value);
/** Messages and commands within the range, in order of time. */
export const marks = signal<HistoryMark[]>([]);
export const problem = signal('');
export const width = signal(1000);

const earlier = signal<(Range | null)[]>([]);
export const canGoBack = computed(() => earlier.value.length > 0);

export const range = (): Range =>
  frozen.peek() ?? { from: programNow() - span.peek() * 1000, to: programNow() };

// ---- the address

let reading = false;
effect(() => {
  if (view.value !== 'trends') return;
  const its = query.value;
  reading = true;
  const names = its
    .getAll('pens')
    .flatMap((text) => text.split('\u001f'))
    .filter(Boolean);
  if (names.length > 0 && names.join() !== pens.peek().join()) pens.value = names.slice(0, MOST_PENS);
  const from = Number(its.get('from'));
  const to = Number(its.get('to'));
  if (from > 0 && to > from) frozen.value = { from, to };
  const seconds = Number(its.get('span'));
  if (seconds > 0) span.value = seconds;
  reading = false;
});
effect(() => {
  const its: Record<string, string> = { span: String(span.value) };
  if (pens.value.length > 0) its.pens = pens.value.join('\u001f');
  if (frozen.value)
    Object.assign(its, {
      from: String(Math.round(frozen.value.from)),
      to: String(Math.round(frozen.value.to)),
    });
  if (reading || view.peek() !== 'trends') return;
  setQuery(its);
  if (its.pens) localStorage.setItem(USED, its.pens);
});

// ---- the data

let running: AbortController | null = null;

export async function refresh(): Promise<void> {
  if (pens.peek().length === 0) {
    picture.value = null;
    return;
  }
  running?.abort();
  const mine = new AbortController();
  running = mine;
  const { from, to } = range();
  const parameters = new URLSearchParams();
  for (const name of pens.peek()) parameters.append('variable', name);
  void refreshMarks(from, to, mine.signal);
  try {
    const answer = await get<History>(
      `history?${parameters}`,
      {
        from: new Date(from).toISOString(),
        to: new Date(to).toISOString(),
        pixels: Math.min(4000, width.peek()),
      },
      mine.signal,
    );
    picture.value = answer;
    problem.value = '';
  } catch (failure) {
    if (mine.signal.aborted) return;
    problem.value = failure instanceof Error ? failure.message : String(failure);
  }
}

/** Marks are beside the picture: without them it is complete, so a failure is not reported. */
async function refreshMarks(from: number, to: number, signal: AbortSignal): Promise<void> {
  try {
    const query = { from: Math.floor(from), to: Math.ceil(to) };
    const { events } = await get<{ events: HistoryMark[] }>('events', query, signal);
    const before = marks.peek();
    const same =
      events.length === before.length &&
      events.every((its, i) => its.time === before[i]!.time && its.text === before[i]!.text);
    if (!same) marks.value = events;
  } catch {
    if (!signal.aborted) marks.value = [];
  }
}

export async function loadSeries(): Promise<void> {
  try {
    const its = await get<{ variables: HistorySeries[]; damage: HistoryDamage[] }>('history/series');
    series.value = its.variables;
    listDamage.value = its.damage;
    problem.value = '';
  } catch (failure) {
    problem.value = failure instanceof Error ? failure.message : String(failure);
  }
}

/** Without pens in the address: the last used ones, or else the first numbers that there are. */
async function begin(): Promise<void> {
  await loadSeries();
  if (!beginning || pens.peek().length > 0) return;
  const used = (localStorage.getItem(USED) ?? '').split('\u001f');
  const all = values.peek().map((its) => its.peek());
  pens.value = firstPens(series.peek(), used, all).slice(0, MOST_PENS);
}
/** No pen was drawn yet since the view was opened. */
let beginning = false;

/** Refreshes while the view is open. @returns a function that ends it */
export function follow(): () => void {
  beginning = true;
  void begin();
  const stop = effect(() => {
    if (pens.value.length > 0) beginning = false;
    void [pens.value, frozen.value, span.value, width.value, clockKnown.value];
    void refresh();
  });
  const timer = setInterval(() => {
    if (beginning) void begin();
    else if (!frozen.peek() && !document.hidden) void refresh();
  }, REFRESH_MS);
  return () => {
    stop();
    clearInterval(timer);
    running?.abort();
  };
}

// ---- what people do

export function addPen(name: string): void {
  if (!pens.peek().includes(name)) pens.value = [...pens.peek(), name].slice(-MOST_PENS);
}
export function removePen(name: string): void {
  pens.value = pens.peek().filter((its) => its !== name);
}
export function zoomTo(next: Range): void {
  if (next.to - next.from < LEAST_SPAN_MS) return;
  earlier.value = [...earlier.peek(), frozen.peek()].slice(-50);
  frozen.value = next;
}
export function back(): void {
  const before = earlier.peek().at(-1);
  if (before === undefined) return;
  earlier.value = earlier.peek().slice(0, -1);
  frozen.value = before;
}
export function goLive(seconds = span.peek()): void {
  earlier.value = [];
  frozen.value = null;
  span.value = seconds;
}
export function zoomBy(factor: number): void {
  const { from, to } = range();
  const middle = (from + to) / 2;
  const half = ((to - from) * factor) / 2;
  zoomTo({ from: middle - half, to: Math.min(programNow(), middle + half) });
}
export function shiftBy(part: number): void {
  const { from, to } = range();
  const by = Math.min((to - from) * part, programNow() - to);
  zoomTo({ from: from + by, to: to + by });
}
