// The rows of the overview that compare ages with their proof.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { LiveValue } from '../src/api/types';
import { deviceAges } from '../src/views/overview/ages';

const value = (name: string, rest: Partial<LiveValue>): LiveValue => ({
  name,
  line: 'L',
  device: 'D',
  type: 'int16',
  unit: '',
  value: 1,
  text: '1',
  quality: 'good',
  reason: '',
  sampled_at: 1000,
  writable: false,
  trigger: false,
  local: false,
  proved_age_ms: 300,
  deadline_ms: 200,
  ...rest,
});
const names = (list: LiveValue[], now = 1100) => deviceAges(list, now).map((its) => its.variable);

test('each device has one row: the value whose proof leaves the least time', () => {
  const list = [
    value('roomy', { proved_age_ms: 210 }),
    value('tight', { proved_age_ms: 390 }),
    value('other', { device: 'E', proved_age_ms: 250 }),
  ];
  assert.deepEqual(names(list), ['tight', 'other']);
  // Reads do not change the order.
  assert.deepEqual(names([...list.map((its) => ({ ...its, sampled_at: 1090 }))]), ['tight', 'other']);
});

test('values that are older than proved come first, the most overdue one before the others', () => {
  const late = { quality: 'bad' as const, reason: 'not_answering' };
  const list = [
    value('tight', { proved_age_ms: 390 }),
    value('late', { device: 'E', ...late }),
    value('later', { device: 'F', sampled_at: 200, ...late }),
  ];
  const rows = deviceAges(list, 1400);
  assert.deepEqual(
    rows.map((its) => [its.variable, its.late]),
    [
      ['later', true],
      ['late', true],
      ['tight', false],
    ],
  );
});

test('the program judges: a good value is not older than proved', () => {
  const [row] = deviceAges([value('V', {})], 1400);
  assert.deepEqual([row!.age_ms, row!.late], [300, false]);
});

test('values without an age or a proof, locals and devices that are switched off have no row', () => {
  const list = [
    value('unread', { sampled_at: null }),
    value('unproved', { device: 'E', proved_age_ms: null }),
    value('local', { device: undefined, local: true }),
    value('off', { device: 'F', quality: 'uncertain', reason: 'switched_off' }),
  ];
  assert.deepEqual(names(list), []);
});
