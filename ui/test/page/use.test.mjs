// What people do with the page, by mouse and by keyboard.
import assert from 'node:assert/strict';
import { once } from 'node:events';
import { readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:net';
import { after, afterEach, before, beforeEach, test } from 'node:test';
import { browser, closePages, cutTexts, newContext, openPage, Plant, serve, toast } from './program.mjs';

let plant; // of all tests that save nothing
let chromium;
let context;
let errors;
before(async () => {
  plant = await Plant.start();
  chromium = await browser();
  context = await newContext(chromium, { viewport: { width: 1440, height: 900 } });
});
after(async () => {
  await chromium?.close();
  await plant?.stop();
});
beforeEach(() => {
  errors = [];
});
afterEach(async () => {
  await closePages(context);
  assert.deepEqual(errors, []);
});

const open = (hash = '#/project', its = plant, language = 'en') =>
  openPage(context, `${its.url}?lang=${language}&theme=light${hash}`, errors);
/** Runs in the page: nothing of the view is beyond its lower edge. */
function onOneScreen() {
  const main = document.querySelector('main');
  return main.scrollHeight <= main.clientHeight;
}
const text = (its = plant) => readFileSync(its.file, 'utf8');

test('grouping switched off shows what it costs, and undo takes it back', async () => {
  const page = await open();
  await page.getByRole('treeitem', { name: /Boiler, 16/ }).click();
  await page.getByText('6 requests instead of 17').waitFor();
  await page.getByLabel('Group requests').selectOption('false');
  await page.getByText(/10 requests instead of 17/).waitFor();
  assert.ok(await page.getByLabel('Registers per request').isDisabled());
  // Words of the IDE are explained where they stand, by keyboard too.
  await page.getByLabel('Group requests').press('Tab');
  await page.locator('.hint:focus .tip', { hasText: 'neighbouring variables share a request' }).waitFor();
  await page.keyboard.press('Control+z');
  await page.getByText('6 requests instead of 17').waitFor();
});

test('the formed requests are downloaded as a table, as JSON and as a picture', async () => {
  const page = await open();
  await page.getByText('6 requests instead of 17').waitFor();
  const saved = async (name) => {
    const [download] = await Promise.all([
      page.waitForEvent('download'),
      page.getByRole('button', { name, exact: true }).click(),
    ]);
    return [download.suggestedFilename(), readFileSync(await download.path(), 'utf8')];
  };
  const [csvName, csv] = await saved('CSV');
  assert.equal(csvName, 'plant.requests.csv');
  assert.equal(csv.trim().split('\r\n').length, 7);
  assert.match(csv, /rs485-1,Meter,17,4,,100,12,Voltage L1; .*; Energy,21; 21; 21; 2143,500\.0,/);
  const [, json] = await saved('JSON');
  assert.equal(JSON.parse(json).lines[0].requests.length, 6);
  assert.match((await saved('SVG'))[1], /^<\?xml|^<svg/);
});

test('a wrong value shows the permitted range and cannot be saved', async () => {
  const page = await open();
  await page.getByRole('treeitem', { name: /Boiler, 16/ }).click();
  const before = text();
  await page.getByLabel('Registers per request').fill('126');
  const mark = page.locator('.mark.error').first();
  await mark.waitFor();
  assert.match(await mark.getAttribute('aria-label'), /2\.\.125/);
  assert.ok(await page.getByRole('button', { name: /^Save/ }).isDisabled());
  assert.equal(text(), before);
  // The draft has no lines: its findings name fields.
  await page.getByRole('button', { name: '1 error' }).click();
  await page.getByRole('dialog').getByText('rs485-1 · Boiler · Registers per request').waitFor();
  await page.keyboard.press('Escape');
  // A save says what is wrong, and goes there.
  await page.locator('nav a[href="#/traffic"]').click();
  await page.getByRole('tab', { name: 'Requests' }).waitFor();
  await page.keyboard.press('Control+s');
  await toast(page, 'Correct the wrong values first.');
  await page.waitForFunction(() => document.activeElement?.id.endsWith('registers_per_request'));
});

test('saving keeps the comments of the file, and the running lines follow', async (t) => {
  const own = await Plant.start();
  t.after(() => own.stop());
  const page = await open('#/project', own);
  await page.getByRole('treeitem', { name: /Boiler, 16/ }).click();
  await page.getByLabel('Poll period, ms').fill('400');
  await page.getByRole('button', { name: /^Save/ }).click();
  const dialog = page.getByRole('dialog');
  await dialog.getByText(/400/).first().waitFor();
  await dialog.getByRole('button', { name: /^Save/ }).click();
  await dialog.waitFor({ state: 'detached' });
  assert.match(text(own), /poll_period: 400ms/);
  assert.match(text(own), /# five floats in a row: one request/);
  await page.getByRole('link', { name: 'Traffic' }).click();
  await page.getByRole('tab', { name: 'Requests' }).click();
  await page
    .getByText(/400 ms →/)
    .first()
    .waitFor();
});

test('a value is written after a preview of its frame', async () => {
  const page = await open('#/live');
  await page.getByRole('button', { name: 'Write: Setpoint' }).click();
  await page.getByLabel('New value').fill('21.5');
  await page.getByRole('dialog').locator('code').first().waitFor();
  await page.keyboard.press('Enter');
  await toast(page, 'Setpoint = 21.5: acknowledged, not read back');
});

test('typing replaces the old value, and a value ten times as large is confirmed', async () => {
  const page = await open('#/live');
  const write = async (typed, change) => {
    await page.getByRole('button', { name: 'Write: Setpoint' }).click();
    await page.getByLabel('New value').waitFor();
    await page.keyboard.type(typed);
    await page.getByRole('dialog').getByText(change).waitFor();
    await page.keyboard.press('Enter');
  };
  await write('12,5', / → 12\.5 °C$/);
  await toast(page, 'Setpoint = 12.5: acknowledged, not read back');
  await page.locator('[role="row"]', { hasText: 'Setpoint' }).getByText('12.5', { exact: true }).waitFor();
  await write('125', '12.5 → 125 °C');
  const question = page.getByRole('dialog', { name: 'Write Setpoint?' });
  await question.getByText('125 is at least ten times the present value 12.5.').waitFor();
  await page.keyboard.press('Enter'); // Cancel has the focus
  await page.getByRole('dialog', { name: 'Write Setpoint', exact: true }).waitFor();
  await page.keyboard.press('Enter');
  await question.getByRole('button', { name: 'Write anyway' }).click();
  await toast(page, 'Setpoint = 125: acknowledged, not read back');
});

test('a value outside the written range is confirmed; pasted bools are asked about', async (t) => {
  const own = await Plant.start((file) =>
    writeFileSync(
      file,
      readFileSync(file, 'utf8').replace(
        'write_on_change: true',
        'write_on_change: true, write_range: 5..40',
      ),
    ),
  );
  t.after(() => own.stop());
  const page = await open('#/live', own);
  const write = async (typed) => {
    await page.getByRole('button', { name: 'Write: Setpoint' }).click();
    await page.getByLabel('New value').waitFor();
    await page.keyboard.type(typed);
    await page.getByRole('dialog').locator('code').first().waitFor();
    await page.keyboard.press('Enter');
  };
  await write('40,5');
  const question = page.getByRole('dialog', { name: 'Write Setpoint?' });
  await question.getByText('40.5 is outside the range 5..40.').waitFor();
  await page.keyboard.press('Escape');
  const dialog = page.getByRole('dialog', { name: 'Write Setpoint', exact: true });
  await dialog.waitFor();
  await page.keyboard.press('Escape');
  await dialog.waitFor({ state: 'detached' });
  await write('5');
  await toast(page, 'Setpoint = 5: acknowledged, not read back');

  await page.goto(`${own.url}?lang=en&theme=light#/project`);
  await page.getByRole('treeitem', { name: /Pump, 18/ }).click();
  await page.getByRole('tab', { name: /Variables/ }).click();
  const grid = page.getByRole('grid', { name: 'Variables' });
  await grid.getByText('Fault', { exact: true }).waitFor();
  await grid.evaluate((element) => {
    const data = new DataTransfer();
    data.setData('text/plain', 'Alarm\tbool\t0x01\tnone\t17');
    element.dispatchEvent(new ClipboardEvent('paste', { clipboardData: data, bubbles: true }));
  });
  const coils = page.getByRole('dialog', { name: 'Which coils are meant?' });
  await coils.getByText('Alarm has the register 17 and no bit').waitFor();
  assert.ok(await coils.getByRole('button', { name: 'OK' }).isDisabled());
  await coils.getByLabel('Bit 0 of register 17: coil 272').check();
  await coils.getByRole('button', { name: 'OK' }).click();
  await grid.getByText('Alarm').waitFor();
});

test('the age of a value is explained hop by hop', async () => {
  const page = await open('#/live');
  await page.getByRole('button', { name: /Why is this value old\? Pressure/ }).click();
  const hops = page.getByRole('dialog').getByRole('listitem');
  await hops.first().waitFor();
  assert.ok((await hops.count()) >= 2);
  await page.keyboard.press('Escape');
  await page.getByRole('dialog').waitFor({ state: 'detached' });
});

test('the table is used by keyboard alone', async () => {
  const page = await open('#/live');
  const grid = page.getByRole('grid');
  await grid.getByText('Pressure', { exact: true }).waitFor();
  await grid.focus();
  for (let i = 0; i < 4; ++i) await page.keyboard.press('ArrowDown');
  await page.keyboard.press('Enter');
  await page.getByRole('dialog', { name: 'Write Setpoint' }).waitFor();
  await page.keyboard.press('Escape');
  await page.getByRole('dialog').waitFor({ state: 'detached' });
});

test('two browsers agree', async () => {
  const other = await open('#/live', plant, 'ru');
  const page = await open('#/live');
  await page.getByRole('button', { name: 'Write: Running' }).click();
  await page.getByLabel('New value').selectOption('true');
  await page.getByRole('dialog').locator('code').first().waitFor();
  await page.getByRole('dialog').getByRole('button', { name: 'Write' }).click();
  await toast(page, 'Running = on: acknowledged, not read back');
  await other.getByRole('grid').getByText('Running').waitFor();
});

/** Runs in the page: returns after more frames have come, and after the page had its turn to draw them. */
async function framesArrive() {
  const stream = new EventSource('api/v1/traffic');
  for (let events = 0; events < 5; ++events)
    await new Promise((done) => stream.addEventListener('frames', done, { once: true }));
  stream.close();
  // The timers of a page fire in order: this one after that of the table, which began earlier and is shorter.
  await new Promise((done) => setTimeout(done, 500));
  await new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
}

test('the frames can be paused, filtered and downloaded', async () => {
  const page = await open('#/traffic');
  await page
    .getByText(/read holding registers/)
    .first()
    .waitFor();
  await page.getByRole('button', { name: 'Pause', pressed: false }).click();
  await page.getByRole('button', { name: 'Continue', pressed: true }).waitFor();
  const shown = await page.locator('[role="row"]').nth(1).textContent();
  await page.evaluate(framesArrive);
  assert.equal(await page.locator('[role="row"]').nth(1).textContent(), shown);
  await page.getByRole('button', { name: 'Continue' }).click();
  await page.waitForFunction(
    (its) => document.querySelectorAll('[role="row"]')[1]?.textContent !== its,
    shown,
    { polling: 100 },
  );
  const download = page.waitForEvent('download');
  await page.getByRole('link', { name: 'Download capture' }).click();
  const bytes = readFileSync(await (await download).path());
  assert.equal(bytes.readUInt32LE(0), 0x0a0d0d0a, 'pcapng');
});

/** Unit 7 is silent, unit 8 has register 0 only, unit 9 answers as unit 1. */
function answer(request) {
  const [asked, code, start] = [request[6], request[7], request.readUInt16BE(8)];
  if (asked === 7) return Buffer.alloc(0);
  const unit = asked === 9 ? 1 : asked;
  const body = start === 0 ? [unit, code, 2, 0, 42] : [unit, code + 128, 2];
  return Buffer.from([request[0], request[1], 0, 0, 0, body.length, ...body]);
}

test('a response that does not come is a red row, and a device with findings is not green', async (t) => {
  let polls = 0;
  const silent = createServer((socket) => {
    socket.on('data', (request) => {
      if (request[6] === 11 && ++polls % 3 === 0) return; // unit 11 omits each third response
      // Unit 10 answers after its time-out.
      setTimeout(() => socket.write(answer(request)), request[6] === 10 ? 300 : 0);
    });
    socket.on('error', () => {});
  }).listen(0, '127.0.0.1');
  await once(silent, 'listening');
  const own = await Plant.start((file) =>
    writeFileSync(
      file,
      `takt: 1
lines:
  - name: net
    transport: tcp
    host: 127.0.0.1
    tcp_port: ${silent.address().port}
    framing: tcp
    devices:
      - name: Mute
        address: 7
        poll_period: 100ms
        response_timeout: 200ms
        variables: [{name: A, type: uint16, register: 0, read: 0x03}]
      - name: Half
        address: 8
        poll_period: 100ms
        variables:
          - {name: B, type: uint16, register: 0, read: 0x03}
          - {name: C, type: int16, register: 500, read: 0x03, default: -1}
      - name: Wrong
        address: 9
        poll_period: 100ms
        response_timeout: 50ms
        variables: [{name: D, type: uint16, register: 0, read: 0x03}]
      - name: Late
        address: 10
        poll_period: 100ms
        response_timeout: 150ms
        variables: [{name: E, type: uint16, register: 0, read: 0x03}]
      - name: Heating controller
        address: 11
        poll_period: 100ms
        response_timeout: 50ms
        variables: [{name: F, type: uint16, register: 0, read: 0x03}]
`,
    ),
  );
  t.after(() => own.stop());
  t.after(() => silent.close());
  const page = await open('#/traffic', own);
  // Only the rows of a filter stay in sight.
  const filter = page.getByLabel('Filter words and bytes');
  await filter.fill('No response within 200');
  const row = page.locator('[role="row"]', { hasText: /No response within 200 ms/ }).first();
  await row.locator('.bad').waitFor();
  assert.match(await row.textContent(), /Mute/);
  // A response of another unit, and one that is late, are one red row each, with its bytes.
  for (const words of [
    /Surplus response: a response of unit 1 came, unit 9 was asked/,
    /Late response: late by [\d.]+ m?s/,
  ]) {
    await filter.fill(words.source.slice(0, 7));
    const response = page.locator('[role="row"]', { hasText: words }).first();
    await response.locator('.bad').waitFor();
    assert.match(await response.locator('code').first().textContent(), /^[\dA-F]{2} [\dA-F ]+$/);
  }
  // One state in each view.
  await page.locator('nav a[href="#/devices"]').click();
  const device = page.locator('[role="row"]', { hasText: 'Half' });
  await device.getByText('answering, with findings').waitFor();
  assert.equal(await device.locator('.dot.warn').count(), 1);
  await page.locator('[role="row"]', { hasText: 'Wrong' }).getByText('answers do not fit').waitFor();
  // A device that fails often has its finding: since when, how often, the next step.
  const often = page.locator('[role="row"]', { hasText: 'Heating controller' });
  await often.getByText('answering, with findings').waitFor();
  await often.getByText('Heating controller').click();
  const finding = page.locator('aside .reasons li', { hasText: 'Heating controller does not answer each' });
  await finding.getByText(/^for \d.* · \d+ of \d+ requests \([\d.]+ %\)$/).waitFor();
  await finding.getByText(/^Check the unit address and the power supply/).waitFor();
  await page.locator('nav a[href="#/overview"]').click();
  await page.locator('.overview .states', { hasText: 'answering, with findings: 2' }).waitFor();
  await page.getByRole('link', { name: 'Half: answering, with findings' }).waitFor();
  await page.getByText('Wrong: a response of unit 1 came, unit 9 was asked').first().waitFor();
  // A variable that was never read has no value: its default is none.
  await page.locator('nav a[href="#/live"]').click();
  const value = (name) => page.getByRole('row', { name: new RegExp(`^Half ${name} `) }).locator('.value');
  await page.getByRole('row', { name: /^Half B 42/ }).waitFor();
  assert.equal(await value('B').count(), 1);
  assert.equal(await value('C').count(), 0);
  // Each word of a state and of a reason is there, in the longest language and on the narrowest screen.
  for (const language of ['ru', 'uk'])
    for (const [width, height] of [
      [1440, 900],
      [768, 1024],
      [390, 844],
    ]) {
      const other = await openPage(context, `${own.url}?lang=${language}&theme=light#/live`, errors, {
        width,
        height,
      });
      for (const view of ['live', 'devices', 'traffic']) {
        await other.locator(`nav a[href="#/${view}"]`).click();
        await other.locator('[role="row"]', { hasText: 'Heating controller' }).first().waitFor();
        assert.deepEqual(await other.evaluate(cutTexts), [], `${view} ${language} ${width}`);
      }
      await other.close();
    }
});

test('a line without a connection is named where its values and frames are missed', async (t) => {
  const own = await Plant.start((file) =>
    writeFileSync(
      file,
      `takt: 1
lines:
  - name: net
    transport: tcp
    host: 127.0.0.1
    tcp_port: 1
    framing: tcp
    devices:
      - {name: Meter, address: 1, variables: [{name: A, type: uint16, register: 0, read: 0x03}]}
`,
    ),
  );
  t.after(() => own.stop());
  const page = await open('#/traffic', own);
  await page.locator('.grid .empty').getByText('net: 127.0.0.1:1: cannot be opened').waitFor();
  await page.locator('nav a[href="#/devices"]').click();
  await page.locator('[role="row"]', { hasText: 'Meter' }).getByText('Meter').click();
  await page.locator('aside .reasons').getByText('net: 127.0.0.1:1: cannot be opened').waitFor();
});

test('the times of a request and of its line are drawn', async () => {
  const page = await open('#/traffic');
  await page.getByRole('tab', { name: 'Requests' }).click();
  await page.getByRole('img', { name: 'Times of the request' }).waitFor();
  for (const part of ['On the wire', 'Turnaround of the devices', 'Late wake-ups of the program'])
    await page.getByRole('img', { name: part }).locator('rect').first().waitFor();
});

test('the trends begin with the first numbers of a device, and again with the last pens', async () => {
  // A program that has just started keeps no sample yet.
  const kept = async () => (await (await fetch(`${plant.url}api/v1/history/series`)).json()).variables;
  while ((await kept()).length < 16) await new Promise((done) => setTimeout(done, 100));
  const page = await open('#/trends');
  const pens = page.locator('.pens tbody th');
  await pens.filter({ hasText: 'Supply temperature' }).waitFor();
  assert.equal(await pens.count(), 3);
  await page.locator('.chart canvas').waitFor();
  await page.getByLabel('Add a pen').selectOption('Bearing temperature');
  await pens.filter({ hasText: 'Bearing temperature' }).waitFor();
  await page.getByRole('button', { name: 'Remove Pressure' }).click();
  const again = await open('#/trends');
  await again.locator('.pens tbody tr', { hasText: 'Bearing temperature' }).waitFor();
  assert.equal(await again.locator('.pens tbody th').count(), 3);
  // Values as in Live: a float without the digits that it does not have.
  const last = again.locator('.pens tbody tr', { hasText: 'Supply temperature' }).locator('td').first();
  assert.match(await last.textContent(), /^\d+(\.\d{1,7})?$/);
});

test('registers are shown as they were on the wire', async () => {
  const page = await open('#/live');
  await page.getByLabel('Format', { exact: true }).selectOption('registers');
  const cell = page.locator('[role="row"]', { hasText: 'Voltage L1' }).locator('.value.mono');
  await cell.waitFor();
  assert.match(await cell.textContent(), /^[0-9A-F]{4}$/);
  assert.match(await cell.getAttribute('title'), /function 0x04, start 100, quantity \d+/);
});

test('a scan of the running line finds its devices, and a new one is added to the draft', async () => {
  const page = await open('#/devices');
  await page.getByLabel('Where').selectOption('line:rs485-1');
  await page.getByLabel('Addresses').fill('15-19');
  await page.getByText(/older by up to [2-9]\d\d ms/).waitFor();
  await page.getByLabel('Time-out, ms').fill('30');
  await page.getByText(/older by up to 1\d\d ms/).waitFor();
  await page.getByLabel('Only in spare time').check();
  await page.getByText('Values do not become older.').waitFor();
  await page.getByRole('button', { name: 'Scan' }).click();
  await page.getByText(/Found: 3 · requests/).waitFor();
  const found = page.getByRole('grid', { name: 'Found devices' });
  await found.getByText('Boiler').waitFor();
  await found.getByText('Pump').waitFor();
});

test('a device of another host is found, probed and added to the project', async (t) => {
  const device = await serve();
  t.after(() => device.stop());
  const page = await open('#/devices');
  await page.getByLabel('Target').fill(`tcp://127.0.0.1:${device.port}`);
  await page.getByLabel('Addresses').fill('6-8');
  await page.getByLabel('Time-out, ms').fill('5000'); // the units that are not there are refused at once
  await page.getByRole('button', { name: 'Scan' }).click();
  await page.getByText(/Found: 1 · requests/).waitFor();
  await page.getByRole('button', { name: 'Add to project' }).click();
  await page.getByRole('button', { name: 'In the draft: unit 7' }).click();
  await page.getByRole('treeitem', { name: /unit 7/ }).waitFor();
  await page.keyboard.press('Control+z');
  await page.getByRole('treeitem', { name: /unit 7/ }).waitFor({ state: 'detached' });
  assert.ok(!text().includes('unit 7'));
});

test('a device that does not answer is tried now, and the outcome is shown', async (t) => {
  const device = await serve();
  t.after(() => device.stop());
  const own = await Plant.start((file) =>
    writeFileSync(
      file,
      `takt: 1
lines:
  - name: net
    transport: tcp
    host: 127.0.0.1
    tcp_port: ${device.port}
    framing: tcp
    devices:
      - name: Here
        address: 7
        poll_period: 100ms
        variables: [{name: A, type: uint16, register: 0, read: 0x03}]
      - name: Away
        address: 8
        poll_period: 60s
        attempts: 1
        backoff: 60s
        variables: [{name: B, type: uint16, register: 0, read: 0x03}]
`,
    ),
  );
  t.after(() => own.stop());
  const page = await open('#/devices', own);
  const row = page.locator('[role="row"]', { hasText: 'Away' });
  await row.getByText('not answering').waitFor();
  const russian = await open('#/devices', own, 'ru');
  const state = russian.locator('[role="row"] .text', { hasText: 'не отвечает' });
  await russian.getByRole('button', { name: 'Опросить' }).waitFor();
  assert.deepEqual(
    await state.evaluate((its) => [its.scrollWidth, its.scrollHeight]),
    await state.evaluate((its) => [its.clientWidth, its.clientHeight]),
  );
  await row.getByText('Away').click();
  await page.getByText(/next probe in|the probe is due/).waitFor();
  await row.getByRole('button', { name: 'Try now' }).click();
  await page.getByText(/Still no answer: exception 10\./).waitFor();
  await page.locator('nav a[href="#/overview"]').click();
  await page.locator('.overview .states', { hasText: 'not answering: 1' }).waitFor();
  await page
    .locator('.overview .reasons', { hasText: 'Away: the device answers with exception 10' })
    .waitFor();
  // The health lists it with the next step, and leads to it.
  await page.locator('nav a[href="#/live"]').click();
  await page.getByRole('button', { name: 'Degraded' }).click();
  const first = page.locator('dialog .reasons li').first();
  await first.getByText('Away: the device answers with exception 10: gateway path unavailable').waitFor();
  await first.getByText('Check the settings of the gateway and the units that it knows.').waitFor();
  await first.getByText(/for \d/).waitFor();
  await first.getByRole('button', { name: 'Details' }).click();
  await page.locator('aside h2', { hasText: 'Away' }).waitFor();
  await page.locator('aside .reasons', { hasText: 'exception 10' }).waitFor();
});

test('the overview opens first, on one screen, and leads to devices, values and requests', async () => {
  const page = await open('');
  const overview = page.locator('.overview');
  assert.equal(await page.locator('nav a[aria-current="page"]').textContent(), 'Overview');
  for (const name of ['Boiler', 'Meter', 'Pump']) await overview.getByText(name, { exact: true }).waitFor();
  await overview.getByRole('meter', { name: /rs485-1/ }).waitFor();
  await overview.getByText('Nothing to report.').waitFor();
  // A value is not older than it was proved.
  const age = overview.locator('.ages li').first();
  await age.waitFor();
  assert.match(await age.textContent(), /\d+ m?s \/ [\d.,]+ m?s/);
  assert.ok(await page.evaluate(onOneScreen));
  // The planned load is that of `takt check`; the worst case is a figure of the proof.
  await overview.locator('.loads').getByText('planned 34.4 %').waitFor();
  await overview
    .locator('.loads')
    .getByText(/^now [\d.]+ %$/)
    .waitFor();
  await overview.getByRole('link', { name: 'Pump: answering' }).click();
  await page.locator('aside h2', { hasText: 'Pump' }).waitFor();
  await page.goBack();
  await overview.locator('.values a').click();
  await page.getByRole('grid', { name: 'Values' }).waitFor();
  await page.goBack();
  await overview.getByRole('button', { name: 'Requests' }).click();
  await page.getByText('6 requests instead of 17').waitFor();
  await page.locator('.utilisation').getByText('34.4 %', { exact: true }).waitFor();
  assert.doesNotMatch(await page.locator('.summary').innerHTML(), /worst case|34\.8/);
  await page.getByRole('tab', { name: 'Ages' }).click();
  await page
    .locator('.plan-panel')
    .getByText(/busy 34\.8 % in the worst case/)
    .waitFor();
});

test('300 devices are on one screen, coloured by state', async (t) => {
  const devices = (first) =>
    [...Array(150).keys()].map(
      (n) =>
        `      - {name: Device ${first + n}, address: ${n + 1}, poll_period: 10s, turnaround: 2ms, ` +
        `variables: [{name: V${first + n}, type: int16, register: 0, read: 0x03}]}`,
    );
  const line = (name, first) =>
    `  - name: ${name}\n    transport: simulated\n    baud: 115200\n    devices:\n` +
    devices(first).join('\n');
  const own = await Plant.start((file) =>
    writeFileSync(file, `takt: 1\nlines:\n${line('west', 1)}\n${line('east', 151)}\n`),
  );
  t.after(() => own.stop());
  for (const viewport of [
    { width: 1440, height: 900 },
    { width: 1024, height: 768 },
    { width: 390, height: 844 },
  ]) {
    const page = await openPage(context, `${own.url}?lang=en&theme=light`, errors, viewport);
    await page.locator('.overview .devices-map a.good').nth(299).waitFor();
    assert.equal(await page.locator('.overview .devices-map a').count(), 300);
    assert.ok(await page.evaluate(onOneScreen), JSON.stringify(viewport));
    // One stop of the Tab key; arrows move within.
    await page.locator('.devices-map a').first().focus();
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press('Enter');
    await page.locator('aside h2', { hasText: 'Device 2' }).waitFor();
  }
});
