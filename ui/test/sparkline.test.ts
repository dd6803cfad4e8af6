import assert from 'node:assert/strict';
import test from 'node:test';
import { sparkline } from '../src/views/live/format';

test('a sparkline has steps up to now', () => {
  assert.equal(
    sparkline(
      [
        [40, 1],
        [70, 2],
      ],
      60,
      20,
      100,
    ),
    'M0.0 18.5H30.0V1.5H60',
  );
});

test('a sparkline ends where the value is lost, and begins again', () => {
  assert.equal(
    sparkline(
      [
        [40, 1],
        [60, Number.NaN],
        [80, 2],
      ],
      60,
      20,
      100,
    ),
    'M0.0 18.5H20.0M40.0 1.5H60',
  );
  assert.equal(
    sparkline(
      [
        [40, 1],
        [60, Number.NaN],
      ],
      60,
      20,
      100,
    ),
    'M0.0 10.0H20.0',
  );
});
