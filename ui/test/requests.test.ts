import assert from 'node:assert/strict';
import test from 'node:test';
import type { PlannedLine, PlannedRequest } from '../src/api/types';
import { agesOf, bytesOf, gapsOf, lineStrategy, unmeasured } from '../src/views/requests/figures';
import { blocksOf, shifted, ticks, visible, zoomed } from '../src/views/requests/timeline';

const request = (parts: Partial<PlannedRequest>): PlannedRequest => ({
  device: 'D',
  unit: 16,
  function: 3,
  write_function: null,
  start: 0,
  quantity: 2,
  variables: ['V'],
  period_ms: 100,
  phase_ms: 0,
  read_trigger: null,
  write_trigger: null,
  write_on_change: false,
  bus_time_us: 10_000,
  share: 0.1,
  c_us: 10_000,
  response_us: 20_000,
  deadline_us: 100_000,
  age_us: 120_000,
  ages_us: [120_000],
  why: '',
  ...parts,
});

test('bytes are those of request and response', () => {
  assert.equal(bytesOf('rtu', request({ quantity: 10 })), 8 + 25);
  assert.equal(bytesOf('rtu', request({ function: null, write_function: 16 })), 13 + 8);
  assert.equal(bytesOf('rtu', request({ function: 1, quantity: 2 })), 8 + 6);
  assert.equal(bytesOf('ascii', request({ quantity: 61 })), 17 + 255);
  assert.equal(bytesOf('tcp', request({ quantity: 2 })), 12 + 13);
});

test('gaps are the items that no variable needs', () => {
  const variables = new Map([['V', { type: 'float' }]]);
  assert.equal(gapsOf(request({ quantity: 5, bridged: 'yes' }), variables), 3);
  assert.equal(gapsOf(request({ quantity: 2 }), variables), 0);
});

test('an age holds while its request is answered before the deadline', () => {
  const line = {
    requests: [
      request({}),
      request({ variables: ['W'], response_us: null, age_us: null, ages_us: [null] }),
      request({ variables: ['X'], response_us: 150_000, age_us: 250_000, ages_us: [250_000] }),
      request({ variables: ['V'], function: null, write_function: 16, period_ms: null }),
    ],
  } as PlannedLine;
  assert.deepEqual(
    agesOf(line).map((its) => [its.variable, its.age_us, its.limit_us, its.holds]),
    [
      ['W', null, 200_000, false],
      ['X', 250_000, 200_000, false],
      ['V', 120_000, 200_000, true],
    ],
  );
});

test('without a turnaround no age is late: it is not computed yet', () => {
  const late = request({ response_us: 900_000, ages_us: [1_000_000] });
  const device = { name: 'D', unit: 16, share: 0.1, turnaround_us: null };
  const line = { requests: [late], devices: [device], verdict: 'response_unknown' } as PlannedLine;
  assert.deepEqual(unmeasured(line), ['D']);
  const [age] = agesOf(line);
  assert.deepEqual([age?.age_us, age?.holds, age?.unknown], [null, true, true]);
  const known = { ...line, devices: [{ ...device, turnaround_us: 5000 }] };
  assert.deepEqual(unmeasured(known), []);
  assert.equal(agesOf(known)[0]?.holds, false);
  assert.deepEqual(unmeasured({ ...line, verdict: 'holds' }), []);
});

test('the strategy of a line is that of all its devices', () => {
  assert.equal(lineStrategy({ devices: [{}, {}] }, 'generic'), 'optimal');
  assert.equal(lineStrategy({ devices: [{}, { group_requests: 'true' }] }, 'owen-kc1'), null);
  assert.equal(
    lineStrategy({ devices: [{ strategy: 'classic', group_requests: 'false' }] }, 'generic'),
    'single',
  );
});

test('the course of the program is drawn in milliseconds', () => {
  const course = { length_ms: 100, bars: [[1, 0, 10_000, false] as [number, number, number, boolean]] };
  assert.deepEqual(blocksOf(course), [{ request: 1, start: 0, end: 10, late: false }]);
});

test('zoom keeps the point under the pointer and stays inside', () => {
  assert.deepEqual(zoomed({ from: 0, to: 100 }, 0.5, 50, 100), { from: 25, to: 75 });
  assert.deepEqual(zoomed({ from: 25, to: 75 }, 4, 50, 100), { from: 0, to: 100 });
  assert.deepEqual(shifted({ from: 0, to: 50 }, 80, 100), { from: 50, to: 100 });
});

test('ticks have round distances', () => {
  assert.deepEqual(ticks({ from: 0, to: 100 }, 5), [0, 20, 40, 60, 80, 100]);
  assert.deepEqual(ticks({ from: 12, to: 14 }, 4), [12, 12.5, 13, 13.5, 14]);
});

test('blocks that share a pixel are drawn once', () => {
  const blocks = Array.from({ length: 1000 }, (_, i) => ({
    request: 0,
    start: i,
    end: i + 0.1,
    late: false,
  }));
  assert.ok(visible(blocks, { from: 0, to: 1000 }, 100, () => 0).length <= 101);
  assert.equal(visible(blocks, { from: 0, to: 10 }, 1000, () => 0).length, 11);
});
