// Every view in every language, light and dark, wide and narrow: nothing is cut off, nothing is untranslated,
// axe-core finds nothing serious. TAKT_SCREENSHOTS names a folder for a picture of each.
import assert from 'node:assert/strict';
import { mkdirSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { browser, closePages, cutTexts, newContext, openPage, Plant } from './program.mjs';

const SHOTS = process.env.TAKT_SCREENSHOTS;
const AXE = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const VIEWS = ['overview', 'project', 'live', 'trends', 'traffic', 'devices'];
const TITLES = {
  en: ['Overview', 'Project', 'Live', 'Trends', 'Traffic', 'Devices'],
  ru: ['Обзор', 'Проект', 'Значения', 'Графики', 'Обмен', 'Устройства'],
  uk: ['Огляд', 'Проєкт', 'Значення', 'Графіки', 'Обмін', 'Пристрої'],
};
const SIZES = {
  wide: { width: 1440, height: 900 },
  middle: { width: 1024, height: 768 }, // in the language with the longest words
  narrow: { width: 390, height: 844 },
};

let plant;
let chromium;
let context;
before(async () => {
  if (SHOTS) mkdirSync(SHOTS, { recursive: true });
  plant = await Plant.start();
  chromium = await browser();
  // The policy of the page allows no script from elsewhere; axe-core is the test's, not the page's.
  context = await newContext(chromium, { bypassCSP: true });
  await context.addInitScript(AXE);
});
afterEach(() => closePages(context));
after(async () => {
  await chromium?.close();
  assert.equal(await plant?.stop(), 0, 'Ctrl-C ends the program with an open stream');
});

/** A mark of the last minute for the trends. */
async function command() {
  const response = await fetch(`${plant.url}api/v1/commands`, {
    method: 'POST',
    headers: { 'Content-Type': 'application/json', 'X-Takt': '1' },
    body: JSON.stringify({ kind: 'set', variable: 'Setpoint', value: '21.5' }),
  });
  assert.equal(response.status, 200);
}

async function settled(page, view) {
  await page.locator('nav a[aria-current="page"]').waitFor();
  if (view === 'overview') await page.locator('.overview .ages li').first().waitFor();
  if (view === 'live' || view === 'devices') await page.locator('[role="row"]').nth(3).waitFor();
  if (view === 'traffic') await page.locator('[role="row"]').nth(5).waitFor();
  if (view === 'project') await page.locator('[role="tree"]').first().waitFor();
  if (view === 'trends') await page.locator('.chart canvas').waitFor();
}

/** Runs in the page. @param wanted  whether the rules about colours run, and the others */
async function audit({ colours, others }) {
  const grave = (impact) => impact === 'serious' || impact === 'critical';
  const aboutColours = ['color-contrast', 'link-in-text-block'];
  const rules = {};
  for (const { id, impact } of globalThis.axe._audit.rules)
    if ((impact && !grave(impact)) || !(aboutColours.includes(id) ? colours : others))
      rules[id] = { enabled: false };
  const { violations } = await globalThis.axe.run({ resultTypes: ['violations'], rules });
  return violations
    .filter((its) => grave(its.impact))
    .map((its) => `${its.id}: ${its.help}: ${its.nodes.map((node) => node.html.slice(0, 160)).join(' | ')}`);
}

/** Where the halves of the project are shown one at a time: this one. */
async function half(page, name) {
  const tab = page.locator(`#half-${name}`);
  if (await tab.isVisible()) await tab.click();
}

/** Further screens of a view: what is opened, and what is there then. */
const FURTHER = {
  devices: [['problems', (page) => page.locator('.health').click(), 'dialog p']],
  project: [
    ['variables', (page) => page.locator('#details-variables').click(), '.table [role="row"]'],
    ['requests', (page) => half(page, 'effect'), '.plan-panel [role="row"]'],
    ['ages', (page) => page.locator('#plan-ages').click(), '.plan-panel .age-bar'],
    [
      'output',
      async (page) => {
        await half(page, 'edit');
        await page.locator('.tree .output').click();
        await page.locator('.more summary').click();
      },
      '.form .group',
    ],
    [
      'line',
      async (page) => {
        await page.locator('.tree .line').first().click();
        await page.locator('.more summary').click();
      },
      '.form .group',
    ],
    [
      'instrument',
      async (page) => {
        await page.locator('.tree-pane .bottom button').last().click();
        await page.locator('.part summary').first().click();
        await page.locator('.part .part summary').first().click();
      },
      '.part .part .fields',
    ],
  ],
  trends: [['marks', (page) => page.locator('.marks summary').click(), '.marks li']],
  traffic: [['requests', (page) => page.locator('#traffic-requests').click(), '.histogram rect']],
};

/** Runs in the page: the tables with columns that are out of sight. */
const cutTables = () =>
  [...document.querySelectorAll('.grid')]
    .filter((its) => its.scrollWidth > its.clientWidth)
    .map((its) => `${its.ariaLabel}: ${its.scrollWidth} of ${its.clientWidth} pixels`);

/** Runs in the page: the words of headings that are broken, and the row that the end of a table cuts. */
function brokenTexts() {
  const found = [];
  for (const cell of document.querySelectorAll('.grid .head > div')) {
    const texts = document.createTreeWalker(cell, NodeFilter.SHOW_TEXT);
    while (texts.nextNode())
      for (const { 0: word, index } of texts.currentNode.data.matchAll(/[^\s-]+/g)) {
        const range = document.createRange();
        range.setStart(texts.currentNode, index);
        range.setEnd(texts.currentNode, index + word.length);
        if (new Set([...range.getClientRects()].map((its) => its.top)).size > 1) found.push(word);
      }
  }
  const live = innerWidth <= 800 ? document.querySelector('.live .grid') : null;
  const end = live?.getBoundingClientRect().bottom ?? 0;
  for (const line of live?.querySelectorAll('.line') ?? []) {
    const { top, bottom } = line.getBoundingClientRect();
    if (top < end - 2 && bottom > end + 2) found.push(line.textContent);
  }
  return found;
}

async function screen(page, name, rules) {
  const { width } = page.viewportSize();
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(wide <= width, `${name} is ${wide} pixels wide`);
  assert.deepEqual(await page.evaluate(cutTables), [], name);
  assert.deepEqual(await page.evaluate(brokenTexts), [], name);
  assert.deepEqual(await page.evaluate(cutTexts), [], name);
  if (SHOTS) await page.screenshot({ path: join(SHOTS, `${name}.png`) });
  if (rules.colours || rules.others) assert.deepEqual(await page.evaluate(audit, rules), [], name);
}

for (const [language, titles] of Object.entries(TITLES))
  for (const theme of ['light', 'dark'])
    for (const [size, viewport] of Object.entries(SIZES)) {
      const middle = size === 'middle';
      if (middle && (language !== 'ru' || theme !== 'light')) continue;
      test(`${language}, ${theme}, ${size}`, async () => {
        // A theme changes colours alone, and a language texts alone (tokens.css, i18n): the rules about
        // colours see both themes in one language, the others see all languages in one theme.
        const rules = { colours: language === 'en', others: theme === 'light' && !middle };
        const errors = [];
        const page = await openPage(
          context,
          `${plant.url}?lang=${language}&theme=${theme}`,
          errors,
          viewport,
        );
        await command();
        for (const [i, view] of VIEWS.entries()) {
          const query = view === 'trends' ? '?pens=Pressure%1FSpeed%1FRunning&span=60' : '';
          await page.evaluate((hash) => {
            location.hash = hash;
          }, `#/${view}${query}`);
          await settled(page, view);
          assert.equal(await page.locator('nav a[aria-current="page"]').textContent(), titles[i]);
          const kind = `${language}-${theme}-${size}`;
          await screen(page, `${view}-${kind}`, rules);
          for (const [name, open, wanted] of FURTHER[view] ?? []) {
            await open(page);
            await page.locator(wanted).first().waitFor();
            await screen(page, `${view}-${name}-${kind}`, rules);
          }
        }
        assert.deepEqual(errors, []);
      });
    }
