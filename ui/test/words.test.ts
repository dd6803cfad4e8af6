import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import test from 'node:test';
import type { Frame, PlannedRequest } from '../src/api/types';

// What the texts need of a browser.
const browser = globalThis as unknown as Record<string, unknown>;
browser.location = { href: 'http://127.0.0.1/?lang=ru' };
browser.localStorage = { getItem: () => null, setItem: () => {} };
browser.document = { documentElement: {} };

const frame = (words: string, fault?: string): Frame => ({
  t: 0,
  line: 'bus',
  unit: 1,
  direction: 'rx',
  words,
  raw: '',
  ...(fault && { fault }),
});

test('a frame has its words without the unit, which is a column', async () => {
  const { frameWords } = await import('../src/views/traffic/words');
  const words = 'чтение дискретных выходов 0..1 → 2 значения: 0 1';
  assert.equal(frameWords(frame(`адрес 16 ${words}`)), words);
  assert.equal(frameWords(frame('неверная контрольная сумма', 'checksum')), 'неверная контрольная сумма');
});

test('the phase of a request has its unit', async () => {
  const { whenWords } = await import('../src/views/requests/words');
  const turn = { period_ms: 1100, phase_ms: 600.125 } as PlannedRequest;
  assert.equal(whenWords(turn), '1100 мс +600.125 мс');
});

for (const [name, table, least] of [
  ['durations', 'durations.inc', 20],
  ['proved bounds, which are rounded up,', 'bounds.inc', 15],
] as const)
  test(`${name} are those of the program in each language`, async () => {
    const { formatBound, formatDuration, setLanguage } = await import('../src/i18n');
    const format = table === 'bounds.inc' ? formatBound : formatDuration;
    const rows = readFileSync(join(process.cwd(), '../src/text/test', table), 'utf8').split('\n');
    const cells = rows.map((row) => row.split(' | ')).filter((row) => /^-?\d+$/.test(row[0]!));
    assert.ok(cells.length > least);
    for (const [i, language] of (['en', 'ru', 'uk'] as const).entries()) {
      setLanguage(language);
      for (const row of cells) assert.equal(format(Number(row[0]) / 1e6), row[i + 1]);
    }
    setLanguage('ru');
  });

test('a late or surplus response is one row with its bytes', async () => {
  const { put } = await import('../src/views/traffic/frames');
  const { frameWords } = await import('../src/views/traffic/words');
  const rows: Parameters<typeof put>[0] = [];
  const incident = (which: NonNullable<Frame['incident']>): Frame => ({
    t: 0,
    line: 'bus',
    unit: 1,
    words: 'лишний ответ',
    incident: which,
  });
  put(rows, frame('first'));
  put(rows, incident('late_response'));
  put(rows, { ...frame('second'), raw: '01 03' });
  put(rows, incident('surplus_response'));
  put(rows, { ...incident('surplus_response'), unit: 2 });
  put(rows, incident('no_response'));
  assert.deepEqual(
    rows.map((its) => [its.incident, its.direction]),
    [
      ['late_response', 'rx'],
      ['surplus_response', 'rx'],
      ['surplus_response', undefined],
      ['no_response', undefined],
    ],
  );
  assert.equal(rows[1]?.raw, '01 03');
  assert.equal(rows[0] ? frameWords(rows[0]) : '', 'Лишний ответ');
});

test('the filter of a device keeps what happens on its line', async () => {
  const traffic = await import('../src/views/traffic/frames');
  const { device: _, ...dropped } = { ...frame('', 'checksum'), device: '', unit: 0 };
  const rows = [
    { ...frame('request'), device: 'Pump' },
    dropped,
    { ...dropped, line: 'other' },
    { ...frame('', 'exception'), device: 'Fan' },
  ];
  traffic.frames.value = rows.map((its, number) => ({ ...its, number }));
  traffic.errorsOnly.value = true;
  traffic.device.value = 'Pump';
  assert.deepEqual(
    traffic.shownFrames.value.map((its) => its.number),
    [1],
  );
});
