import assert from 'node:assert/strict';
import test from 'node:test';
import type { LiveValue } from '../src/api/types';
import { withoutDefault } from '../src/views/live/format';
import { changeText, doubtOf, parsedValue, proofOf, readAfter, valueText } from '../src/views/live/writing';

const words = { on: 'on', off: 'off' };
const variable = (parts: Partial<LiveValue>) => ({ type: 'float', value: 90, trigger: false, ...parts });

test('a comma is a decimal comma', () => {
  const cases: [string, unknown][] = [
    ['12,5', 12.5],
    [' 12.5 ', 12.5],
    ['-0,25', -0.25],
    ['5', 5],
    ['0x10', 16],
    ['1e3', 1000],
  ];
  for (const [text, wanted] of cases) assert.equal(parsedValue('float', text), wanted, text);
});

test('text that is no number is left to the program, which refuses it', () => {
  for (const text of ['', 'abc', '1,234.5', '1.234,5', '1,234,5', '12,5 °C'])
    assert.equal(parsedValue('float', text), text);
});

test('numbers of 64 bits keep all digits', () => {
  assert.equal(parsedValue('uint64', '18446744073709551615'), '18446744073709551615');
  assert.equal(parsedValue('int64', '9007199254740991'), 9007199254740991);
  assert.equal(valueText(18446744073709552000, words, '18446744073709551615'), '18446744073709551615');
});

test('bools and strings are not parsed as numbers', () => {
  assert.equal(parsedValue('bool', 'true'), true);
  assert.equal(parsedValue('bool', 'false'), false);
  assert.equal(parsedValue('string', ' 12,5'), ' 12,5');
});

test('the change has the old value, the new one and the unit', () => {
  assert.equal(changeText(valueText(90, words), valueText(5, words), ''), '90 → 5');
  assert.equal(changeText(valueText(null, words), valueText(12.5, words), '°C'), '– → 12.5 °C');
  assert.equal(changeText(valueText(false, words), valueText(true, words), ''), 'off → on');
});

test('without a range, ten times the old value is doubtful', () => {
  assert.equal(doubtOf(variable({}), 899), null);
  assert.equal(doubtOf(variable({}), 900), 'many_times');
  assert.equal(doubtOf(variable({}), -905), 'many_times');
  assert.equal(doubtOf(variable({ value: -90 }), 905), 'many_times');
  assert.equal(doubtOf(variable({}), 5), null);
  assert.equal(doubtOf(variable({ value: 0 }), 65535), null);
  assert.equal(doubtOf(variable({ value: null }), 65535), null);
});

test('with a range, only a value outside is doubtful', () => {
  const its = variable({ value: 1, write_range: { least: -10, greatest: 100 } });
  assert.equal(doubtOf(its, 100), null);
  assert.equal(doubtOf(its, 100.5), 'range');
  assert.equal(doubtOf(its, -11), 'range');
  assert.equal(doubtOf(variable({ write_range: { greatest: 100 } }), -5000), null);
  assert.equal(doubtOf(variable({ write_range: { least: 0 } }), -1), 'range');
});

test('bools, words, triggers and strings are never doubtful', () => {
  assert.equal(doubtOf(variable({ type: 'bool', value: true }), false), null);
  assert.equal(doubtOf(variable({ type: 'int16', value: 1, enumeration: true }), 100), null);
  assert.equal(doubtOf(variable({ value: 1, trigger: true }), 100), null);
  assert.equal(doubtOf(variable({ type: 'string', value: '1' }), '100'), null);
});

test('the outcome names what was proved', () => {
  assert.equal(proofOf({ local: true }), 'set');
  assert.equal(proofOf({ local: false }), 'acknowledged');
  assert.equal(proofOf({ local: false, verify: true }), 'verified');
  assert.equal(proofOf({ local: false, broadcast: true }), 'broadcast');
});

test('a write is compared with the first read that began after it', () => {
  const write = { written: 95.5, after: 1000 };
  assert.equal(readAfter(write, { value: 80, sampled_at: null }), null);
  assert.equal(readAfter(write, { value: 80, sampled_at: 999 }), null);
  assert.equal(readAfter(write, { value: 90, sampled_at: 1000 }), 90);
});

test('a variable that was never read has no value, and keeps the last one that was', () => {
  const its = (parts: Partial<LiveValue>) =>
    withoutDefault({
      value: -1,
      text: '-1',
      local: false,
      quality: 'bad',
      sampled_at: null,
      ...parts,
    } as LiveValue);
  assert.deepEqual([its({}).value, its({}).text], [null, '']);
  assert.equal(its({ quality: 'never_read' }).value, null);
  assert.equal(its({ sampled_at: 1000 }).value, -1);
  assert.equal(its({ local: true, quality: 'never_read' }).value, -1);
  // A retained value of the run before.
  assert.equal(its({ quality: 'uncertain' }).value, -1);
});
