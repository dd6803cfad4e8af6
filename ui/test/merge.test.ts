import assert from 'node:assert/strict';
import test from 'node:test';
import type { Mapping } from '../src/api/types';
import { asInFile } from './merge_helpers';
import { merged, rebased } from '../src/store/merge';

const device = (name: string, parts: Mapping = {}): Mapping => ({
  name,
  address: '1',
  poll_period: '1s',
  ...parts,
});
const file = (...devices: Mapping[]): Mapping => asInFile({ takt: '1', devices });
const devicesOf = (document: Mapping) => document.devices as Mapping[];
const names = (document: Mapping) => devicesOf(document).map((its) => its.name);

test('changes of different fields are both kept', () => {
  const base = file(device('A'), device('B'));
  const mine = file(device('A', { poll_period: '2s' }), device('B'));
  const theirs = file(device('A', { address: '7' }), device('B', { address: '8' }));
  const { document, conflicts } = merged(base, mine, theirs);
  assert.deepEqual(devicesOf(document)[0], { name: 'A', address: '7', poll_period: '2s', $from: 0 });
  assert.equal(devicesOf(document)[1]!.address, '8');
  assert.deepEqual(conflicts, []);
});

test('a value that both changed is that of this page, and is reported', () => {
  const base = file(device('A'));
  const mine = file(device('A', { poll_period: '2s' }));
  const theirs = file(device('A', { poll_period: '3s', address: '2' }));
  const { document, conflicts } = merged(base, mine, theirs);
  assert.equal(devicesOf(document)[0]!.poll_period, '2s');
  assert.equal(devicesOf(document)[0]!.address, '2');
  assert.deepEqual(conflicts, ['devices[0].poll_period']);
});

test('items keep the places that they have in the new file', () => {
  const base = file(device('A'), device('B'));
  const mine = file(device('A'), device('B', { poll_period: '2s' }));
  const theirs = file(device('New'), device('A'), device('B'));
  const { document } = merged(base, mine, theirs);
  assert.deepEqual(names(document), ['New', 'A', 'B']);
  assert.deepEqual(
    devicesOf(document).map((its) => its.$from),
    [0, 1, 2],
  );
  assert.equal(devicesOf(document)[2]!.poll_period, '2s');
});

test('items that are new on either side are both there', () => {
  const base = file(device('A'));
  const mine: Mapping = { ...base, devices: [...devicesOf(base), device('Mine')] };
  const theirs = file(device('A'), device('Theirs'));
  const { document } = merged(base, mine, theirs);
  assert.deepEqual(names(document), ['A', 'Theirs', 'Mine']);
  assert.equal(devicesOf(document)[2]!.$from, undefined);
});

test('an item that was removed there stays only if it was changed here', () => {
  const base = file(device('A'), device('B'), device('C'));
  const mine: Mapping = {
    ...base,
    devices: [{ ...devicesOf(base)[0]!, poll_period: '2s' }, devicesOf(base)[1]!, devicesOf(base)[2]!],
  };
  const { document } = merged(base, mine, file(device('C', { address: '9' })));
  assert.deepEqual(names(document), ['A', 'C']);
  assert.equal(devicesOf(document)[0]!.$from, undefined);
  assert.equal(devicesOf(document)[1]!.$from, 0);
});

test('an item that was removed here stays removed', () => {
  const base = file(device('A'), device('B'));
  const mine: Mapping = { ...base, devices: [devicesOf(base)[1]!] };
  const theirs = file(device('A', { address: '5' }), device('B', { address: '6' }));
  assert.deepEqual(names(merged(base, mine, theirs).document), ['B']);
});

test('an item that was renamed there is the same item', () => {
  const base = file(device('A'), device('B'));
  const mine = file(device('A'), device('B', { poll_period: '2s' }));
  const { document } = merged(base, mine, file(device('A'), device('Pump')));
  assert.deepEqual(devicesOf(document)[1], { name: 'Pump', address: '1', poll_period: '2s', $from: 1 });
});

test('new keys, removed keys and lists of values are merged', () => {
  const base = asInFile({ takt: '1', outputs: [{ name: 'o', tags: ['a'], period: '1s' }] });
  const mine = asInFile({ takt: '1', outputs: [{ name: 'o', tags: ['a', 'b'] }] });
  const theirs = asInFile({ takt: '1', outputs: [{ name: 'o', tags: ['a'], period: '1s', topic: 'x' }] });
  const { document } = merged(base, mine, theirs);
  assert.deepEqual(document.outputs, [{ name: 'o', tags: ['a', 'b'], topic: 'x', $from: 0 }]);
});

test('a step of before a save has the places of the saved file', () => {
  const before = file(device('A'), device('B'), device('C'));
  const saved = file(device('New'), device('A', { poll_period: '2s' }), device('C'));
  const items = devicesOf(rebased(before, saved));
  assert.deepEqual(
    items.map((its) => [its.name, its.poll_period, its.$from]),
    [
      ['A', '1s', 1],
      ['B', '1s', undefined],
      ['C', '1s', 2],
    ],
  );
});
