// Pictures of the history as series for drawing. Pure.
//
// The program gives four points for each column of pixels (M4: first, minimum, maximum, last), so that no
// spike is lost. A polled value holds until the next one: the lines are steps.
import type { History, HistoryPoint, HistorySeries, HistoryVariable, LiveValue } from '../../api/types';

export interface Curve {
  times: number[]; // seconds since 1970
  values: (number | null)[]; // null: nothing is drawn until the next point
}
export interface Change {
  from: number; // the poll before, seconds
  to: number;
  before: number;
  after: number;
}
export type SpanKind = 'restart' | 'replaced' | 'lost' | 'damaged' | 'bad' | 'uncertain';
export interface Span {
  from: number;
  to: number;
  kind: SpanKind;
  text: string;
  /** Of this variable alone, not of the whole history. */
  own: boolean;
}

const seconds = (time: string) => Date.parse(time) / 1000;

function pointsOf(variable: HistoryVariable): HistoryPoint[] {
  const all: HistoryPoint[] = [];
  for (const pixel of variable.points) {
    const four = [pixel.first, pixel.min, pixel.max, pixel.last].filter((its) => its !== undefined);
    four.sort((a, b) => seconds(a.time) - seconds(b.time));
    for (const [i, its] of four.entries()) {
      const before = four[i - 1];
      if (!before || before.time !== its.time || before.value !== its.value) all.push(its);
    }
  }
  return all;
}

const gapKind = (cause: string): SpanKind =>
  cause === 'restart' || cause === 'replaced' || cause === 'damaged' ? cause : 'lost';

/** Times in which nothing is known of a variable: gaps, damage of the file, and values that are not good. */
export function spansOf(history: History, variable: HistoryVariable): Span[] {
  const gaps = history.gaps.map(
    (gap): Span => ({
      from: seconds(gap.from),
      to: seconds(gap.to),
      kind: gapKind(gap.cause),
      text: gap.samples ? `${gap.cause}: ${gap.samples}` : gap.cause,
      own: false,
    }),
  );
  const damaged = (history.damage ?? []).flatMap((its): Span[] =>
    its.from !== null && its.to !== null && (its.variable === null || its.variable === variable.name)
      ? [
          {
            from: seconds(its.from),
            to: seconds(its.to),
            kind: 'damaged',
            text: its.part,
            own: its.variable !== null,
          },
        ]
      : [],
  );
  const bad = variable.bad.map(
    (its): Span => ({
      from: seconds(its.from),
      to: seconds(its.to),
      kind: its.quality === 'uncertain' ? 'uncertain' : 'bad',
      text: its.reason ?? its.quality,
      own: true,
    }),
  );
  return [...gaps, ...damaged, ...bad].sort((a, b) => a.from - b.from);
}

export function curveOf(history: History, variable: HistoryVariable): Curve {
  const begin = seconds(history.from);
  const end = Math.min(seconds(history.to), seconds(variable.known_until));
  const curve: Curve = { times: [], values: [] };
  const put = (time: number, value: number | null) => {
    curve.times.push(time);
    curve.values.push(value);
  };
  const holes = spansOf(history, variable).filter((its) => its.kind !== 'uncertain' && its.to > begin);
  let hole = 0;
  let held: number | null = null;
  const passHoles = (until: number) => {
    for (; hole < holes.length && holes[hole]!.from < until; ++hole) {
      const from = Math.max(begin, holes[hole]!.from);
      if (held !== null) put(from, held);
      put(from, null);
      held = null;
    }
  };
  if (variable.held) {
    held = variable.held.value;
    put(begin, held);
  }
  for (const point of pointsOf(variable)) {
    const time = seconds(point.time);
    passHoles(time);
    put(time, point.value);
    held = point.value;
  }
  passHoles(end);
  if (held !== null && curve.times.length > 0 && end > curve.times.at(-1)!) put(end, held);
  return curve;
}

/** The changes whose previous poll is known: each happened between the two polls. */
export function changesOf(variable: HistoryVariable): Change[] {
  const changes: Change[] = [];
  let before: number | null = variable.held?.value ?? null;
  for (const point of pointsOf(variable)) {
    if (point.previous_poll && before !== null && before !== point.value)
      changes.push({
        from: seconds(point.previous_poll),
        to: seconds(point.time),
        before,
        after: point.value,
      });
    before = point.value;
  }
  return changes;
}

/** The value of a curve at a time: steps hold. */
export function valueAt(curve: Curve, time: number): number | null {
  let low = 0;
  let high = curve.times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (curve.times[middle]! <= time) low = middle + 1;
    else high = middle;
  }
  return low === 0 ? null : curve.values[low - 1]!;
}

const LATE_COMMIT = 5; // seconds

/** The good share of what can be known: a running program commits its last second later. */
export function goodShare(history: History, { good_share, known_until }: HistoryVariable): number {
  const to = seconds(history.to);
  const open = to - seconds(known_until);
  if (open <= 0 || open > LATE_COMMIT) return good_share;
  const all = to - seconds(history.from);
  return Math.min(1, (good_share * all) / (all - open));
}

/** Least, greatest and mean (weighted with time) of a curve between two times. */
export function statisticsOf(curve: Curve, from: number, to: number) {
  let min = Number.POSITIVE_INFINITY;
  let max = Number.NEGATIVE_INFINITY;
  let area = 0;
  let known = 0;
  const take = (value: number | null, begin: number, end: number) => {
    if (value === null || end < begin) return;
    min = Math.min(min, value);
    max = Math.max(max, value);
    area += value * (end - begin);
    known += end - begin;
  };
  let before = valueAt(curve, from);
  let since = from;
  for (const [i, time] of curve.times.entries()) {
    if (time <= from) continue;
    if (time >= to) break;
    take(before, since, time);
    before = curve.values[i]!;
    since = time;
  }
  take(before, since, to);
  if (min > max) return null;
  return { min, max, mean: known > 0 ? area / known : min };
}

const MOST_FIRST = 3;

/**
 * The pens of a view that names none.
 * @param used  names of the last time
 * @returns those of `used` that the history has, else the first numbers of the first device with values
 */
export function firstPens(
  series: Pick<HistorySeries, 'name' | 'type'>[],
  used: string[],
  values: Pick<LiveValue, 'name' | 'type' | 'device' | 'quality'>[],
): string[] {
  const known = new Map(series.map((its) => [its.name, its.type]));
  const again = used.filter((name) => known.has(name));
  if (again.length > 0) return again;
  const numbers = values.filter(
    ({ name, type, quality }) =>
      quality === 'good' && known.has(name) && type !== 'bool' && type !== 'string',
  );
  return numbers
    .filter((its) => its.device === numbers[0]!.device)
    .slice(0, MOST_FIRST)
    .map((its) => its.name);
}
