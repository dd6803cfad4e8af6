import assert from 'node:assert/strict';
import { test } from 'node:test';
import { tailFrom } from '../src/views/traffic/tail';

test('three late responses of 10,000 are a tail with a scale of its own', () => {
  const bars: [number, number][] = [
    [10_000, 4000],
    [11_000, 5900],
    [12_000, 97],
    [300_000, 2],
    [500_000, 1],
  ];
  assert.equal(tailFrom(bars, 11_500), 3);
  // The percentile of the bars themselves: what follows is readable, or there is nothing.
  assert.equal(tailFrom(bars.slice(0, 2), 10_900), 2);
  assert.equal(
    tailFrom(
      [
        [10_000, 50],
        [11_000, 40],
        [12_000, 10],
      ],
      10_500,
    ),
    3,
  );
  assert.equal(tailFrom(bars, null), 5);
  assert.equal(tailFrom(bars, 900_000), 5);
});
