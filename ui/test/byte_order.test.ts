import assert from 'node:assert/strict';
import test from 'node:test';
import * as bytes from '../src/views/project/byte_order';

test('the permutation numbers the bytes from the least significant one', () => {
  assert.deepEqual(
    bytes.ORDERS.map((its) => bytes.permutation(its)),
    ['2143', '4321', '1234', '3412'],
  );
  assert.equal(bytes.permutation(bytes.DEFAULT_ORDER, 4), '21436587');
  assert.equal(bytes.spaced('2143'), '2 1 4 3');
});

test('orders are read in all their notations', () => {
  for (const text of ['2143', '2 1 4 3', 'Float: 2 1 4 3', 'CDAB', '21436587'])
    assert.deepEqual(bytes.orderOf(text), bytes.DEFAULT_ORDER, text);
  assert.equal(bytes.orderOf('1324'), undefined);
});

test('the order of an object overrides that of its device', () => {
  const inherited = { highByteFirst: false, highRegisterFirst: true };
  assert.deepEqual(bytes.effectiveOrder({}, inherited), inherited);
  assert.deepEqual(bytes.effectiveOrder({ high_byte_first: 'true' }, inherited), {
    highByteFirst: true,
    highRegisterFirst: true,
  });
  assert.deepEqual(bytes.effectiveOrder({ byte_order: '4321' }, inherited), {
    highByteFirst: true,
    highRegisterFirst: true,
  });
});

test('four bytes are decoded in every order', () => {
  const wire = bytes.parseBytes('00 00 3F 80');
  assert.deepEqual(wire, [0, 0, 0x3f, 0x80]);
  const decoded = new Map(bytes.decodeAll(wire!).map((its) => [its.digits, its]));
  assert.equal(decoded.get('2143')!.float, 1);
  assert.equal(decoded.get('4321')!.uint32, 0x3f80);
  assert.equal(decoded.get('1234')!.uint32, 0x803f0000);
  assert.equal(decoded.get('3412')!.uint32, 0x803f);
  assert.equal(bytes.parseBytes('00 3F'), undefined);
});
