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

test('frames are described in the language of the page', async () => {
  const { frameWords } = await import('../src/views/traffic/words');
  const cases = [
    ['unit 16 read holding registers 0..9', 'чтение регистров хранения 0..9'],
    ['unit 16 read coils 0..1 → 2 values: 0 1', 'чтение дискретных выходов 0..1 → значений 2: 0 1'],
    ['unit 1 write single coil 5 = on', 'запись дискретного выхода 5 = вкл.'],
    ['unit 1 write multiple registers 8..9 → 8..9 written', 'запись регистров 8..9 → 8..9 записано'],
    [
      'unit 1 read/write multiple registers read 1, write 2 = 3',
      'чтение и запись регистров чтение 1, запись 2 = 3',
    ],
    [
      'unit 1 read coils 0 → exception 2 illegal data address',
      'чтение дискретных выходов 0 → исключение 2 недопустимый адрес данных',
    ],
  ] as const;
  for (const [words, wanted] of cases) assert.equal(frameWords(frame(words)), wanted);
});

test('no English words are left in a frame', async () => {
  const { frameWords } = await import('../src/views/traffic/words');
  assert.equal(
    frameWords(frame('unit 2 write single register (too short, 5 of 6 bytes) 06 00')),
    'запись регистра (слишком коротко, 5 из 6 байт) 06 00',
  );
  const source = readFileSync(join(process.cwd(), '../src/wire/test/frame_words_test.cpp'), 'utf8');
  const all = source.match(/"unit \d+ (?:[^"\\]|\\.)*"/g)!;
  assert.ok(all.length > 60);
  for (const literal of all) {
    const words = literal.slice(1, -1).replace(/\\"/g, '"');
    assert.doesNotMatch(frameWords(frame(words)).replace(/"[^"]*"/g, ''), /[a-z]{2,}/, words);
  }
});

test('the phase of a request has its unit', async () => {
  const { whenWords } = await import('../src/views/requests/words');
  const turn = { period_ms: 1100, phase_ms: 600.125 } as PlannedRequest;
  assert.equal(whenWords(turn), '1100 мс +600.125 мс');
});

test('texts of devices stay as they are', async () => {
  const { frameWords } = await import('../src/views/traffic/words');
  const words = 'unit 1 encapsulated interface transport → 0 "read on off", 1 "X"';
  assert.equal(frameWords(frame(words)), 'инкапсулированный интерфейс → 0 "read on off", 1 "X"');
});

test('a fault of the frame is named, an exception is described', async () => {
  const { frameWords } = await import('../src/views/traffic/words');
  assert.equal(frameWords(frame('checksum', 'checksum')), 'неверная контрольная сумма');
  assert.equal(
    frameWords(frame('unit 1 read coils → exception 1', 'exception')),
    'чтение дискретных выходов → исключение 1',
  );
});

test('durations are those of the program in each language', async () => {
  const { formatDuration, setLanguage } = await import('../src/i18n');
  const rows = readFileSync(join(process.cwd(), '../src/text/test/durations.inc'), 'utf8').split('\n');
  const cells = rows.map((row) => row.split(' | ')).filter((row) => /^-?\d+$/.test(row[0]!));
  assert.ok(cells.length > 20);
  for (const [i, language] of (['en', 'ru', 'uk'] as const).entries()) {
    setLanguage(language);
    for (const row of cells) assert.equal(formatDuration(Number(row[0]) / 1e6), row[i + 1]);
  }
  setLanguage('ru');
});

test('a proved bound is not shown smaller than it is', async () => {
  const { formatBound, setLanguage } = await import('../src/i18n');
  setLanguage('en');
  const cases: [number, string][] = [
    [60_525, '1 min 1 s'],
    [12.31, '12.4 ms'],
    [12.3, '12.3 ms'],
    [9.991, '10.0 ms'],
    [12_340, '12.4 s'],
    [3_600_000.1, '1 h 1 min'],
  ];
  for (const [ms, text] of cases) assert.equal(formatBound(ms), text);
  setLanguage('ru');
});

test('a late or surplus response is one row with its bytes', async () => {
  const { put } = await import('../src/views/traffic/frames');
  const { frameWords } = await import('../src/views/traffic/words');
  const rows: Parameters<typeof put>[0] = [];
  const incident = (which: Frame['incident'], after_ms?: number): Frame => ({
    t: 0,
    line: 'bus',
    unit: 1,
    words: '',
    ...(which && { incident: which }),
    ...(after_ms !== undefined && { after_ms }),
  });
  put(rows, frame('first'));
  put(rows, incident('late_response', 230));
  put(rows, { ...frame('second'), raw: '01 03' });
  put(rows, incident('surplus_response'));
  put(rows, { ...incident('surplus_response'), unit: 2 });
  put(rows, incident('no_response', 500));
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
  assert.match(rows[0] ? frameWords(rows[0]) : '', /^Опоздал на 230/);
  assert.match(
    frameWords({ ...incident('surplus_response'), instead: { part: 'unit', came: 1, asked: 5 } }),
    /пришёл ответ с адреса 1, а запрос был к адресу 5/,
  );
});
