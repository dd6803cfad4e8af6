import assert from 'node:assert/strict';
import test from 'node:test';
import type { History, HistoryVariable } from '../src/api/types';
import { decimalsOf, shortest } from '../src/views/live/format';
import {
  changesOf,
  curveOf,
  firstPens,
  goodShare,
  spansOf,
  statisticsOf,
  valueAt,
} from '../src/views/trends/data';

const at = (second: number) => new Date(1_790_000_000_000 + second * 1000).toISOString();
const seconds = (second: number) => 1_790_000_000 + second;

const variable = (parts: Partial<HistoryVariable>): HistoryVariable => ({
  name: 'Level',
  device: 'Tank',
  type: 'float',
  unit: 'm',
  samples: 0,
  min: null,
  max: null,
  mean: null,
  good_share: 1,
  known_until: at(100),
  held: null,
  points: [],
  bad: [],
  ...parts,
});
const history = (its: HistoryVariable): History => ({ from: at(0), to: at(100), variables: [its], gaps: [] });
const point = (second: number, value: number) => {
  const its = { time: at(second), value, previous_poll: at(second - 2) };
  return { index: second, samples: 1, first: its, min: its, max: its, last: its };
};

test('the value from before the range is drawn from the left edge on', () => {
  const its = variable({ held: { time: at(-50), value: 4 }, points: [point(60, 7)] });
  const curve = curveOf(history(its), its);
  assert.deepEqual(curve.times, [seconds(0), seconds(60), seconds(100)]);
  assert.deepEqual(curve.values, [4, 7, 7]);
  assert.equal(valueAt(curve, seconds(10)), 4);
  assert.deepEqual(statisticsOf(curve, seconds(0), seconds(100)), { min: 4, max: 7, mean: 5.2 });
  assert.deepEqual(changesOf(its), [{ from: seconds(58), to: seconds(60), before: 4, after: 7 }]);
});

test('a range without a sample shows the value that holds', () => {
  const its = variable({ held: { time: at(-50), value: 4 } });
  assert.deepEqual(curveOf(history(its), its).values, [4, 4]);
});

test('without a value before the range the curve begins with the first sample', () => {
  const its = variable({ points: [point(60, 7)] });
  assert.deepEqual(curveOf(history(its), its).times, [seconds(60), seconds(100)]);
});

test('a gap ends the curve until the next sample', () => {
  const its = variable({ held: { time: at(-50), value: 4 }, points: [point(60, 7)] });
  const gaps = [{ from: at(20), to: at(40), cause: 'restart', samples: null }];
  const curve = curveOf({ ...history(its), gaps }, its);
  assert.equal(valueAt(curve, seconds(19)), 4);
  assert.equal(valueAt(curve, seconds(30)), null);
});

test('damage of the file is a gap of its variable, or of all', () => {
  const its = variable({ held: { time: at(-50), value: 4 }, points: [point(60, 7)] });
  const damaged = (from: number, to: number, name: string | null) => ({
    part: 'chunk' as const,
    row: 1,
    variable: name,
    from: at(from),
    to: at(to),
    samples: null,
  });
  const damage = [
    damaged(20, 30, 'Level'),
    damaged(25, 35, 'Pressure'),
    damaged(70, 80, null),
    { ...damaged(0, 0, 'Level'), part: 'series' as const, from: null, to: null },
  ];
  const gaps = [{ from: at(40), to: at(41), cause: 'damaged', samples: 3 }];
  const all = { ...history(its), damage, gaps };
  assert.deepEqual(
    spansOf(all, its).map(({ from, to, kind, text, own }) => [from, to, kind, text, own]),
    [
      [seconds(20), seconds(30), 'damaged', 'chunk', true],
      [seconds(40), seconds(41), 'damaged', 'damaged: 3', false],
      [seconds(70), seconds(80), 'damaged', 'chunk', false],
    ],
  );
  const curve = curveOf(all, its);
  assert.equal(valueAt(curve, seconds(19)), 4);
  assert.equal(valueAt(curve, seconds(25)), null);
  assert.equal(valueAt(curve, seconds(65)), 7);
  assert.equal(valueAt(curve, seconds(75)), null);
});

test('a view without pens begins with the last ones, or the first numbers of a device with values', () => {
  const value = (name: string, device: string, type = 'float', quality: 'good' | 'bad' = 'good') => ({
    name,
    device,
    type,
    quality,
  });
  const values = [
    value('Dead', 'Pump', 'float', 'bad'),
    value('On', 'Fan', 'bool'),
    value('Level', 'Tank'),
    value('Kept nowhere', 'Tank'),
    value('Flow', 'Tank', 'int16'),
    value('Speed', 'Fan'),
  ];
  const series = values.filter((its) => its.name !== 'Kept nowhere');
  assert.deepEqual(firstPens(series, [''], values), ['Level', 'Flow']);
  assert.deepEqual(firstPens(series, ['Gone', 'On'], values), ['On']);
  assert.deepEqual(firstPens(series, ['Gone'], []), []);
});

test('numbers have the shortest digits of their type', () => {
  const float = (value: number) => shortest(Math.fround(value), 'float');
  assert.deepEqual([65.4, 1.79, -0.1, 16777216, 0].map(float), ['65.4', '1.79', '-0.1', '16777216', '0']);
  assert.equal(shortest(Math.fround(65.4), 'double'), '65.4000015258789');
  assert.equal(shortest(1065353216, 'uint32'), '1065353216');
  assert.deepEqual(
    [65.4, 2, 1e-7].map((its) => decimalsOf(its, 'double')),
    [1, 0, 7],
  );
});

test('what a running program has not committed yet is not called bad', () => {
  const share = (good_share: number, known: number) => {
    const its = variable({ good_share, known_until: at(known) });
    return goodShare(history(its), its);
  };
  assert.equal(share(0.98, 98), 1);
  assert.equal(share(0.49, 98), 0.5);
  assert.equal(share(0.5, 50), 0.5); // it was not running
  assert.equal(share(0.5, 200), 0.5);
});
