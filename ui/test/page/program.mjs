// Starts `takt run` with the page on a free port, and a browser.
import { spawn } from 'node:child_process';
import { connect, createServer } from 'node:net';
import { cpSync, mkdtempSync, appendFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

const ROOT = fileURLToPath(new URL('../../..', import.meta.url));
const TAKT = process.env.TAKT ?? join(ROOT, 'build/takt');
const HISTORY = '\noutputs:\n  - name: history\n    transport: history\n';

/** A copy of an example with a history, served by the program. */
export class Plant {
  static async start(example = 'demo.yaml', options = ['--allow-write'], change = () => {}) {
    const plant = new Plant();
    plant.folder = mkdtempSync(join(tmpdir(), 'takt-page-'));
    plant.file = join(plant.folder, 'plant.yaml');
    cpSync(join(ROOT, 'examples', example), plant.file);
    appendFileSync(plant.file, HISTORY);
    change(plant.file);
    plant.options = options;
    await plant.run();
    return plant;
  }

  async run() {
    this.process = spawn(TAKT, ['run', this.file, '--web', '127.0.0.1:0', '--quiet', ...this.options]);
    this.url = await new Promise((found, failed) => {
      let text = '';
      const look = (data) => {
        text += data;
        const match = text.match(/http:\/\/127\.0\.0\.1:\d+\//);
        if (match) found(match[0]);
      };
      this.process.stdout.on('data', look);
      this.process.stderr.on('data', look);
      this.process.on('exit', () => failed(new Error(`the program ended: ${text}`)));
      setTimeout(() => failed(new Error(`no address: ${text}`)), 30_000).unref();
    });
  }

  async end() {
    const ended = new Promise((done) => this.process.on('exit', done));
    this.process.kill('SIGINT');
    return ended;
  }

  async stop() {
    const code = await this.end();
    rmSync(this.folder, { recursive: true, force: true });
    return code;
  }
}

/** A device with the address 7 on a TCP port of its own. */
export async function serve() {
  const port = await new Promise((found) => {
    const probe = createServer().listen(0, '127.0.0.1', () => {
      const { port } = probe.address();
      probe.close(() => found(port));
    });
  });
  const process = spawn(TAKT, ['serve', '--listen', `127.0.0.1:${port}`, '--unit', '7']);
  const ended = new Promise((done) => process.on('exit', done));
  const connects = () =>
    new Promise((done) => {
      const socket = connect(port, '127.0.0.1', () => {
        socket.destroy();
        done(true);
      }).on('error', () => done(false));
    });
  while (!(await connects())) await new Promise((done) => setTimeout(done, 20));
  return {
    port,
    async stop() {
      process.kill('SIGINT');
      await ended;
    },
  };
}

export const browser = () =>
  chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: [
      '--no-sandbox',
      '--disable-gpu',
      '--disable-quic',
      '--no-first-run',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
    ],
  });

/** A page whose errors fail the test. */
export async function openPage(context, url, errors) {
  const page = await context.newPage();
  page.on('pageerror', (error) => errors.push(String(error)));
  page.on('console', (message) => {
    if (message.type() === 'error') errors.push(message.text());
  });
  await page.goto(url);
  return page;
}
