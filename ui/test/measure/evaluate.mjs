// From a keystroke in a project of 1,000 variables to the drawn requests that follow from it,
// in milliseconds.
//
//   TAKT=<program> node ui/test/measure/evaluate.mjs [EDITS] [FILE]
//
// FILE: a project that runs without hardware. Its first device is edited.
import { copyFileSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { browser } from '../page/program.mjs';
import { plantProject, started } from './field.mjs';

const EDITS = Number(process.argv[2] ?? 100);
const FILE = process.argv[3];

const folder = mkdtempSync(join(tmpdir(), 'takt-evaluate-'));
const file = join(folder, 'plant.yaml');
if (FILE) copyFileSync(FILE, file);
else writeFileSync(file, plantProject(1000, { transport: 'simulated', baud: 115200 }, '5s'));
const { child, match } = await started(
  ['run', file, '--web', '127.0.0.1:0', '--quiet', '--allow-write'],
  /http:\/\/127\.0\.0\.1:\d+\//,
);
const chromium = await browser();

/** Runs in the page. Pauses between edits vary, so that some of them interrupt the search for measures. */
async function measure(edits) {
  const box = document.getElementById('lines[0].devices[0].poll_period');
  const pane = document.querySelector('.panel.requests');
  const results = [];
  const fetchBefore = window.fetch;
  let call = null;
  window.fetch = async (...its) => {
    if (!String(its[0]).includes('evaluate') || String(its[0]).includes('measures=1'))
      return fetchBefore(...its);
    const mine = { sent: performance.now(), bytes: its[1].body.length };
    const response = await fetchBefore(...its);
    mine.head = performance.now();
    const text = await response.text();
    mine.received = performance.now();
    mine.answer = text.length;
    mine.server = JSON.parse(text).took_ms;
    call = mine;
    return new Response(text, { status: response.status });
  };
  const setter = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, 'value').set;
  for (let i = 0; i < edits; ++i) {
    call = null;
    let drawn = 0;
    const observer = new MutationObserver(() => {
      if (call?.received) drawn = performance.now();
    });
    observer.observe(pane, { subtree: true, childList: true, characterData: true, attributes: true });
    const begin = performance.now();
    setter.call(box, String(5000 + (i % 50)));
    box.dispatchEvent(new InputEvent('input', { bubbles: true }));
    const edited = performance.now();
    while (!drawn && performance.now() - begin < 5000)
      await new Promise((done) => requestAnimationFrame(done));
    await new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
    const end = performance.now();
    observer.disconnect();
    results.push({
      all: end - begin,
      input: edited - begin,
      wait: call.sent - edited,
      send: call.head - call.sent - call.server,
      server: call.server,
      receive: call.received - call.head,
      draw: end - call.received,
      bytes: call.bytes,
      answer: call.answer,
    });
    await new Promise((done) => setTimeout(done, 200 + ((i * 137) % 600)));
  }
  window.fetch = fetchBefore;
  return results;
}

try {
  const page = await (await chromium.newContext({ viewport: { width: 1440, height: 900 } })).newPage();
  await page.goto(`${match[0]}?lang=en&theme=light#/project`);
  await page.locator('[role="treeitem"][aria-level="2"]').first().click();
  await page.getByLabel('Poll period, ms').waitFor();
  await page.locator('.panel.requests [role="grid"]').waitFor({ timeout: 30_000 });
  await page.evaluate(measure, 5); // the first ones compile the page's code
  const results = await page.evaluate(measure, EDITS);
  console.log(`${EDITS} edits; ${results[0].bytes} bytes sent, ${results[0].answer} received`);
  console.log('          median      p95  longest');
  for (const key of ['all', 'input', 'wait', 'send', 'server', 'receive', 'draw']) {
    const sorted = results.map((its) => its[key]).sort((a, b) => a - b);
    const part = (share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
    const figures = [part(0.5), part(0.95), sorted.at(-1)].map((its) => its.toFixed(1).padStart(8));
    console.log(key.padEnd(8), figures.join(' '));
  }
} finally {
  await chromium.close();
  child.kill('SIGINT');
  rmSync(folder, { recursive: true, force: true });
}
