import assert from 'node:assert/strict';
import test from 'node:test';
import { milliseconds, nodeText, rawOf } from '../src/views/project/cells';
import type { Mapping } from '../src/api/types';
import * as rows from '../src/views/project/rows';
import { formatTable, isImport, parseTable } from '../src/views/project/tsv';
import { coilsOf, openRows, withChoice } from '../src/views/project/coil_choice';

test('a pasted table has cells with tabs, quotes and line ends', () => {
  assert.deepEqual(parseTable('a\tb\r\n"c\td"\t"e ""f""\ng"\n'), [
    ['a', 'b'],
    ['c\td', 'e "f"\ng'],
  ]);
  assert.deepEqual(parseTable('\tx\n\t'), [
    ['', 'x'],
    ['', ''],
  ]);
  assert.deepEqual(parseTable('"Pump" room\n5" pipe'), [['"Pump" room'], ['5" pipe']]);
  assert.deepEqual(parseTable(''), []);
});

test('what is copied is read back the same', () => {
  const table = [
    ['a\tb', '"', ''],
    ['', 'c\nd', 'e'],
  ];
  assert.deepEqual(parseTable(formatTable(table)), table);
});

test('tables and windows of the IDE are known from their text', () => {
  for (const text of [
    'Имя переменной\tТип переменной\tАдрес регистра\nA\tБулевское\t1',
    'Имя переменной;Тип;Адрес регистра;Комментарий\nA;Булевское;1;',
    'name,type,register\nA,int16,1',
    'Имя;Устройство\nАдрес;16\nПериод опроса, мс;100',
    'Имя\tDevice\r\nАдрес\t16\r\nКол-во попыток\t3\r\n',
    'Имя;Котёл\nАдрес;16',
    'Адрес: 16\nПериод опроса, мс: 100',
    'RS485, Слот 1, Master\nУстройство, 16\nИмя переменной\tТип\tАдрес регистра\nA\tБулевское\t1',
  ])
    assert.ok(isImport(text), text);
  for (const text of [
    'Alarm\tbool\t0x01\tnone\t17',
    'Имя',
    'Имя;Адрес',
    '',
    'a;b\nc;d',
    'Адрес\tint16\t0\nТип\tint16\t1',
    'Адрес\nТип',
  ])
    assert.ok(!isImport(text), text);
});

test('typed texts become those of the file', () => {
  assert.equal(rawOf('type', 'uint32'), 'uint32');
  assert.equal(rawOf('text', ' '), undefined);
  assert.equal(rawOf('duration', '100'), '100ms');
  assert.equal(rawOf('duration', '1.5s'), '1.5s');
  assert.equal(rawOf('number', '0,01'), '0.01');
  assert.deepEqual(rawOf('words', '0=off, 1=on'), { 0: 'off', 1: 'on' });
  assert.deepEqual(rawOf('list', 'energy, daily'), ['energy', 'daily']);
  assert.deepEqual(rawOf('list', '0..99'), ['0..99']);
  assert.equal(rawOf('list', 'true'), 'true');
});

test('durations are milliseconds', () => {
  assert.equal(milliseconds('1s'), 1000);
  assert.equal(milliseconds('500us'), 0.5);
  assert.equal(milliseconds('2min'), 120_000);
  assert.equal(milliseconds('soon'), null);
});

test('nodes are one line of text', () => {
  assert.equal(nodeText(['7', '0..99', ['0', '9']]), '7, 0..99, 0..9');
  assert.equal(nodeText({ 0: 'off', $from: 3 }), '0=off');
});

const NAME = { key: 'name', kind: 'text' } as const;
const REGISTER = { key: 'register', kind: 'number' } as const;
const float = (name: string, register: string) => ({ name, type: 'float', register, read: '0x03' });

test('a new row goes on with name and address', () => {
  const taken = new Set(['Var1', 'Var2']);
  assert.deepEqual(rows.rowAfter(float('Var1', '0'), {}, taken), float('Var3', '2'));
  assert.deepEqual(rows.nextAddress({ type: 'bool', register: '3', bit: '15' }), { register: '4', bit: '0' });
  assert.deepEqual(rows.nextAddress({ type: 'int64', reference: '40001' }), { reference: '40005' });
  assert.deepEqual(rows.nextAddress({ type: 'int16', register: '0x0F' }), { register: '0x10' });
  assert.equal(rows.nextName('Pump', new Set(['Pump'])), 'Pump 2');
  assert.equal(rows.nextName('T09', new Set()), 'T10');
});

test('copies have new names and no place in the file', () => {
  const list = [{ ...float('A1', '0'), $from: 0 }, float('B', '2')];
  const next = rows.duplicated(list, [0], rows.namesIn(list));
  assert.deepEqual(next, [list[0], float('A2', '0'), list[1]]);
});

test('filling down counts names and addresses on', () => {
  const list = [float('V1', '10'), float('x', '0'), { name: 'y', type: 'int16', register: '0' }];
  const next = rows.filledDown(list, [0, 1, 2], [NAME, REGISTER], rows.namesIn(list));
  assert.deepEqual(
    next.map((its) => [its.name, its.register]),
    [
      ['V1', '10'],
      ['V2', '12'],
      ['V3', '14'],
    ],
  );
  const units = rows.filledDown(
    [{ unit: 'V' }, {}, { unit: 'A' }],
    [0, 1, 2],
    [{ key: 'unit', kind: 'text' }],
    new Set(),
  );
  assert.deepEqual(units, [{ unit: 'V' }, { unit: 'V' }, { unit: 'V' }]);
});

test('a pasted table overwrites, adds rows and leaves out the empty choice', () => {
  const list = [float('A', '0'), float('B', '2')];
  const row = (name: string, register: string) => ({
    cells: { name, register },
    columns: [NAME, REGISTER],
  });
  const empty = { cells: null, columns: [NAME, REGISTER] };
  const narrow = { cells: { name: 'W' }, columns: [NAME] };
  const next = rows.pasted(
    list,
    [1, 0],
    [row('X', '7'), empty, row('Y', '9'), row('Z', '11'), narrow],
    0,
    () => ({ type: 'int16', register: '0' }),
  );
  assert.deepEqual(next, [
    float('Y', '9'),
    float('X', '7'),
    { type: 'int16', name: 'Z', register: '11' },
    { type: 'int16', name: 'W', register: '0' },
  ]);
  assert.deepEqual(list, [float('A', '0'), float('B', '2')]);
});

test('rows are filtered and sorted by number', () => {
  const list = [float('B', '10'), float('A', '9'), { name: 'C', register: '100' }];
  const columns = [NAME, REGISTER];
  assert.deepEqual(rows.ordered(list, '', { key: 'register', down: false }, columns), [1, 0, 2]);
  assert.deepEqual(rows.ordered(list, '10', null, columns), [0, 2]);
});

test('pasted bools of coils without a bit leave open which coil they mean', () => {
  const bool = (parts: Mapping): Mapping => ({ type: 'bool', register: '17', read: '0x01', ...parts });
  const open = [
    bool({}),
    bool({ read: '1' }),
    bool({ read: '0x02' }),
    bool({ read: 'none', write: '0x05' }),
    bool({ area: 'coil', read: 'none' }),
    bool({ register: '0x11' }),
  ];
  const settled = [
    bool({ bit: '0' }),
    bool({ register: '0' }),
    bool({ register: 'x' }),
    bool({ read: '0x03' }),
    bool({ area: 'holding_register', read: '0x01' }),
    bool({ type: 'int16' }),
    { type: 'bool', coil: '17', read: '0x01' },
    { type: 'bool', reference: '00018', read: '0x01' },
  ];
  assert.deepEqual(openRows([...settled, ...open], []), open);
  const before = { ...bool({ name: 'A' }), comment: 'old' };
  assert.deepEqual(openRows([{ ...before, comment: 'new' }], [before]), [], 'it was open before');
  const moved = { ...before, register: '18' };
  assert.deepEqual(openRows([moved], [before]), [moved]);
});

test('the choice writes the meaning into the pasted rows alone', () => {
  const row = { name: 'A', type: 'bool', register: '17', read: '0x01' };
  const other = { name: 'B', type: 'bool', register: '18', read: '0x01' };
  assert.deepEqual(coilsOf(row), { coil: 17, bit: 272 });
  assert.deepEqual(withChoice([other, row], [row], 'bit'), [other, { ...row, bit: '0' }]);
  assert.deepEqual(withChoice([other, row], [row], 'coil'), [
    other,
    { name: 'A', type: 'bool', read: '0x01', coil: '17' },
  ]);
});
