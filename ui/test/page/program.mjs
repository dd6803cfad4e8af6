// `takt run` with the page on a port that the kernel chose, a browser, and pages whose errors fail the test.
//
// No program outlives a test file, not even a killed one: the kernel kills the programs with the process that
// started them, and the browser ends with the pipe that it gets its commands from.
import { spawn } from 'node:child_process';
import { appendFileSync, cpSync, existsSync, mkdtempSync, rmSync } from 'node:fs';
import { createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

const ROOT = fileURLToPath(new URL('../../..', import.meta.url));
const TAKT = process.env.TAKT ?? join(ROOT, 'build/takt');
// The shell is Chromium without windows: it takes a third less processor time.
const SHELL = '/usr/lib/chromium/chromium-headless-shell';
const CHROMIUM = process.env.CHROMIUM ?? (existsSync(SHELL) ? SHELL : '/usr/bin/chromium');
const HISTORY = '\noutputs:\n  - name: history\n    transport: history\n';

/** The longest wait for a condition. It detects what hangs, and measures nothing. */
export const PATIENCE = 120_000;

/** A running program; `ended` resolves with its exit code. */
function start(options) {
  const child = spawn('setpriv', ['--pdeathsig', 'KILL', '--', TAKT, ...options]);
  const ended = new Promise((done) => {
    child.on('exit', done);
    child.on('error', done);
  });
  let text = '';
  const listeners = new Set();
  for (const stream of [child.stdout, child.stderr])
    stream.on('data', (data) => {
      text += data;
      for (const look of listeners) look();
    });
  return {
    child,
    ended,
    /** The match of `pattern` in the output, as soon as it is there. */
    prints(pattern) {
      return new Promise((found, failed) => {
        const timer = setTimeout(() => {
          child.kill('SIGKILL'); // a program that still runs would keep this process
          finish(() => failed(new Error(`no ${pattern} in: ${text}`)));
        }, PATIENCE);
        const finish = (act) => {
          clearTimeout(timer);
          listeners.delete(look);
          act();
        };
        const look = () => {
          const match = text.match(pattern);
          if (match) finish(() => found(match));
        };
        listeners.add(look);
        look();
        ended.then((code) => finish(() => failed(new Error(`the program ended (${code}): ${text}`))));
      });
    },
    /** @returns the exit code; null if the program had to be killed */
    async end() {
      child.kill('SIGINT');
      const timer = setTimeout(() => child.kill('SIGKILL'), PATIENCE);
      const code = await ended;
      clearTimeout(timer);
      return code;
    },
  };
}

/** A copy of an example with a history, served by the program. */
export class Plant {
  /** @param change  called with the path of the copy before the program starts */
  static async start(change = () => {}) {
    const plant = new Plant();
    plant.folder = mkdtempSync(join(tmpdir(), 'takt-page-'));
    plant.file = join(plant.folder, 'plant.yaml');
    cpSync(join(ROOT, 'examples/demo.yaml'), plant.file);
    appendFileSync(plant.file, HISTORY);
    change(plant.file);
    await plant.run();
    return plant;
  }

  async run() {
    this.program = start(['run', this.file, '--web', '127.0.0.1:0', '--quiet', '--allow-write']);
    this.url = (await this.program.prints(/http:\/\/127\.0\.0\.1:\d+\//))[0];
  }

  /** @returns the exit code */
  end() {
    return this.program.end();
  }

  async stop() {
    const code = await this.end();
    rmSync(this.folder, { recursive: true, force: true });
    return code;
  }
}

const freePort = () =>
  new Promise((found) => {
    const probe = createServer().listen(0, '127.0.0.1', () => {
      const { port } = probe.address();
      probe.close(() => found(port));
    });
  });

/** A device with the address 7 on a TCP port of its own. */
export async function serve() {
  // Another program may take a port between the probe and the start.
  for (let attempt = 1; ; ++attempt) {
    const port = await freePort();
    const program = start(['serve', '--listen', `127.0.0.1:${port}`, '--unit', '7']);
    try {
      await program.prints(/serving tcp:/);
      return { port, stop: () => program.end() };
    } catch (failure) {
      await program.end();
      if (attempt === 5) throw failure;
    }
  }
}

/** Chromium draws suggestions of its address bar as pages, which cost more than the page under test. */
const WINDOW = ['WebUIOmniboxPopup', 'WebUIOmniboxAimPopup', 'WebUIOmniboxFullPopup'];

export async function browser() {
  if (!existsSync(CHROMIUM)) throw new Error(`${CHROMIUM} is missing. Run: tools/setup test`);
  return chromium.launch({
    executablePath: CHROMIUM,
    timeout: PATIENCE,
    args: [
      '--no-sandbox',
      '--disable-gpu',
      '--disable-quic',
      '--no-first-run',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
      // Instead of the list of playwright-core: the last one counts.
      `--disable-features=${[...WINDOW, 'Translate', 'PaintHolding'].join(',')}`,
    ],
  });
}

/** Runs in the page before its scripts: keeps the texts of toasts, which the page removes after some time. */
function recordToasts() {
  globalThis.toasts = [];
  new MutationObserver((changes) => {
    for (const { addedNodes } of changes)
      for (const node of addedNodes)
        if (node instanceof Element && node.matches('.toast')) globalThis.toasts.push(node.textContent);
  }).observe(document, { subtree: true, childList: true });
}

/** A context of the browser for all tests of a file: a page loads much sooner than in a new one. */
export async function newContext(chromium, options) {
  const context = await chromium.newContext(options);
  context.setDefaultTimeout(PATIENCE);
  await context.addInitScript(recordToasts);
  return context;
}

/** Returns as soon as the page has shown a toast with this text. */
export const toast = (page, text) =>
  page.waitForFunction((its) => globalThis.toasts.some((one) => one.includes(its)), text, { polling: 100 });

/** A page whose errors fail the test. */
export async function openPage(context, url, errors, viewport) {
  const page = await context.newPage();
  if (viewport) await page.setViewportSize(viewport);
  page.on('pageerror', (error) => errors.push(String(error)));
  page.on('console', (message) => {
    if (message.type() === 'error') errors.push(message.text());
  });
  await page.goto(url);
  return page;
}

/**
 * Runs in the page: texts that are cut off, by their own box or by one around it. Bytes, values of a response
 * and the variables of a request may be longer than any box.
 */
export function cutTexts() {
  const found = new Set();
  const hides = (element) => ['hidden', 'clip'].includes(getComputedStyle(element).overflowX);
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const { currentNode: text } = texts;
    const its = text.parentElement;
    if (
      !text.data.trim() ||
      text.data.length > 60 ||
      !its.checkVisibility() ||
      its.closest('svg, select, .visually-hidden, code, .bar')
    )
      continue;
    const range = document.createRange();
    range.selectNodeContents(text);
    const { left, right, bottom } = range.getBoundingClientRect();
    for (let box = its; box; box = box.parentElement) {
      const style = getComputedStyle(box);
      if (['auto', 'scroll'].includes(style.overflowX)) break;
      if (style.display === 'inline' || !hides(box)) continue;
      const edge = box.getBoundingClientRect();
      if (right > edge.right + 1 || left < edge.left - 1 || bottom > edge.bottom + 3)
        found.add(`${text.data} in ${its.closest('[aria-label]')?.ariaLabel}`);
    }
  }
  const ARROW = 18;
  const pen = document.createElement('canvas').getContext('2d');
  for (const its of document.querySelectorAll('.form select')) {
    if (!its.checkVisibility()) continue;
    const style = getComputedStyle(its);
    pen.font = style.font;
    const chosen = its.selectedOptions[0]?.textContent ?? '';
    const padding = Number.parseFloat(style.paddingLeft) + Number.parseFloat(style.paddingRight);
    if (pen.measureText(chosen).width > its.clientWidth - padding - ARROW + 1)
      found.add(`${chosen} in ${its.id}`);
  }
  return [...found];
}

/** Closes the pages of a test, and forgets what they stored in the browser. */
export async function closePages(context) {
  for (const page of context.pages()) {
    await page.evaluate(() => localStorage.clear()).catch(() => {}); // a blank page has no storage
    await page.close();
  }
}

/** Pastes a text with the focus at a table. */
export const pasteInto = (grid, text) =>
  grid.evaluate((element, pasted) => {
    const data = new DataTransfer();
    data.setData('text/plain', pasted);
    element.focus();
    element.dispatchEvent(new ClipboardEvent('paste', { clipboardData: data, bubbles: true }));
  }, text);

/** A table without headings, and one of a slave, which gets a new server. */
export async function pasteTables(page) {
  await page.getByRole('button', { name: 'Paste a table' }).click();
  const dialog = page.getByRole('dialog');
  await dialog.getByRole('textbox', { name: 'Pasted table' }).fill('Alarm\tbool\t0x01\tnone\t17');
  await dialog.locator('.error', { hasText: 'the first line of a table must name its columns' }).waitFor();
  await dialog
    .getByRole('textbox', { name: 'Pasted table' })
    .fill('Name\tType\tRegister\tUsed\nServed\tint\t0\tyes');
  await dialog.locator('option', { hasText: 'A new server' }).waitFor({ state: 'attached' });
  await dialog.getByRole('button', { name: 'Take over' }).click();
  const grid = page.getByRole('grid', { name: 'Variables' });
  await grid.getByText('Served', { exact: true }).waitFor();
  await page.getByRole('button', { name: 'Undo' }).click();
  await grid.waitFor({ state: 'detached' });
}
