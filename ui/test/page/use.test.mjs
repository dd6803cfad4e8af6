// What people do with the page, by mouse and by keyboard.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, afterEach, before, beforeEach, test } from 'node:test';
import { browser, openPage, Plant } from './program.mjs';

let plant;
let chromium;
let context;
let page;
let errors;
before(async () => {
  chromium = await browser();
});
after(() => chromium?.close());
beforeEach(async () => {
  plant = await Plant.start();
  context = await chromium.newContext({ viewport: { width: 1440, height: 900 } });
  context.setDefaultTimeout(15_000);
  errors = [];
  page = await openPage(context, `${plant.url}?lang=en&theme=light`, errors);
});
afterEach(async () => {
  assert.deepEqual(errors, []);
  await context?.close();
  await plant?.stop();
});

const text = () => readFileSync(plant.file, 'utf8');

test('grouping switched off shows what it costs, and undo takes it back', async () => {
  await page.getByRole('treeitem', { name: /Boiler, 16/ }).click();
  await page.getByText('7 requests instead of 13').waitFor();
  await page.getByLabel('Group requests').selectOption('false');
  await page.getByText(/1\d requests instead of 13/).waitFor();
  assert.ok(await page.getByLabel('Registers per request').isDisabled());
  await page.keyboard.press('Control+z');
  await page.getByText('7 requests instead of 13').waitFor();
});

test('a wrong value shows the permitted range and cannot be saved', async () => {
  await page.getByRole('treeitem', { name: /Boiler, 16/ }).click();
  const before = text();
  await page.getByLabel('Registers per request').fill('126');
  const mark = page.locator('.mark.error').first();
  await mark.waitFor();
  assert.match(await mark.getAttribute('aria-label'), /2\.\.125/);
  assert.ok(await page.getByRole('button', { name: /^Save/ }).isDisabled());
  assert.equal(text(), before);
});

test('saving keeps the comments of the file, and the running lines follow', async () => {
  await page.getByRole('treeitem', { name: /Boiler, 16/ }).click();
  await page.getByLabel('Poll period, ms').fill('400');
  await page.getByRole('button', { name: /^Save/ }).click();
  const dialog = page.getByRole('dialog');
  await dialog.getByText(/400/).first().waitFor();
  await dialog.getByRole('button', { name: /^Save/ }).click();
  await dialog.waitFor({ state: 'detached' });
  assert.match(text(), /poll_period: 400ms/);
  assert.match(text(), /# five floats in a row: one request/);
  await page.goto(`${plant.url}#/traffic`);
  await page.getByRole('tab', { name: 'Requests' }).click();
  await page
    .getByText(/400 ms →/)
    .first()
    .waitFor();
});

test('a value is written after a preview of its frame', async () => {
  await page.goto(`${plant.url}#/live`);
  await page.getByRole('button', { name: 'Write: Setpoint' }).click();
  await page.getByLabel('New value').fill('21.5');
  await page.getByRole('dialog').locator('code').first().waitFor();
  await page.keyboard.press('Enter');
  await page.getByText('Setpoint = 21.5: written').waitFor();
});

test('the age of a value is explained hop by hop', async () => {
  await page.goto(`${plant.url}#/live`);
  await page.getByRole('button', { name: /Why is this value old\? Pressure/ }).click();
  const hops = page.getByRole('dialog').getByRole('listitem');
  await hops.first().waitFor();
  assert.ok((await hops.count()) >= 2);
  await page.keyboard.press('Escape');
  await page.getByRole('dialog').waitFor({ state: 'detached' });
});

test('the table is used by keyboard alone', async () => {
  await page.goto(`${plant.url}#/live`);
  const grid = page.getByRole('grid');
  await grid.getByText('Pressure').waitFor();
  await grid.focus();
  for (let i = 0; i < 4; ++i) await page.keyboard.press('ArrowDown');
  await page.keyboard.press('Enter');
  await page.getByRole('dialog', { name: 'Write Setpoint' }).waitFor();
  await page.keyboard.press('Escape');
  await page.getByRole('dialog').waitFor({ state: 'detached' });
});

test('two browsers agree', async () => {
  const other = await openPage(context, `${plant.url}?lang=ru#/live`, errors);
  await page.goto(`${plant.url}#/live`);
  await page.getByRole('button', { name: 'Write: Running' }).click();
  await page.getByLabel('New value').selectOption('true');
  await page.getByRole('dialog').locator('code').first().waitFor();
  await page.getByRole('dialog').getByRole('button', { name: 'Write' }).click();
  await page.getByText(/Running = true: written/).waitFor();
  await other.getByRole('grid').getByText('Running').waitFor();
});

test('the frames can be paused, filtered and downloaded', async () => {
  await page.goto(`${plant.url}#/traffic`);
  await page
    .getByText(/read holding registers/)
    .first()
    .waitFor();
  await page.getByRole('button', { name: 'Pause' }).click();
  const shown = await page.locator('[role="row"]').nth(1).textContent();
  await page.waitForTimeout(600);
  assert.equal(await page.locator('[role="row"]').nth(1).textContent(), shown);
  const download = page.waitForEvent('download');
  await page.getByRole('link', { name: 'Download capture' }).click();
  const bytes = readFileSync(await (await download).path());
  assert.equal(bytes.readUInt32LE(0), 0x0a0d0d0a, 'pcapng');
});
