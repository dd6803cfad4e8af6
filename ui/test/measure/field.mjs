// A field whose values change all the time, and a program that polls it: for measurements of the page.
import { spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const ROOT = fileURLToPath(new URL('../../..', import.meta.url));
const TAKT = process.env.TAKT ?? join(ROOT, 'build/takt');
const PER_DEVICE = 100;

const freePort = () =>
  new Promise((found) => {
    const server = createServer();
    server.listen(0, '127.0.0.1', () => {
      const { port } = server.address();
      server.close(() => found(port));
    });
  });

// Of some of them: a history of all would be measured too.
const HISTORY = "outputs:\n  - {name: history, transport: history, variables: ['D?.V1', 'D?.V2']}\n";

const range = (count) => [...Array(count).keys()];
const devicesOf = (count) =>
  range(Math.ceil(count / PER_DEVICE)).map((d) => range(Math.min(PER_DEVICE, count - d * PER_DEVICE)));

/** A TCP server with floats that rise all the time. */
export function fieldProject(count, port) {
  const units = devicesOf(count).map((its, d) => {
    const rows = its.map(
      (v) =>
        `          - {name: D${d + 1}.V${v + 1}, type: float, area: holding_register, register: ${2 * v}, ` +
        `source: {ramp: {from: ${v}, to: ${v + 1000}, period: 100s}}}`,
    );
    return `      - address: ${d + 1}
        banks: [{area: holding_register, items: [0..${2 * PER_DEVICE - 1}]}]
        variables:\n${rows.join('\n')}`;
  });
  return `takt: 1
servers:
  - name: field
    listen: 127.0.0.1
    tcp_port: ${port}
    units:
${units.join('\n')}
`;
}

/** @param line  the keys of the line that the devices are on */
export function plantProject(count, line, period = '100ms') {
  const devices = devicesOf(count).map((its, d) => {
    const rows = its.map(
      (v) =>
        `          - {name: D${d + 1}.V${v + 1}, type: float, register: ${2 * v}, read: 0x03, unit: bar}`,
    );
    return `      - name: Device ${d + 1}
        address: ${d + 1}
        poll_period: ${period}
        registers_per_request: 125
        variables:\n${rows.join('\n')}`;
  });
  const keys = Object.entries(line).map(([key, value]) => `    ${key}: ${value}`);
  return `takt: 1\nlines:\n  - name: field\n${keys.join('\n')}\n    devices:\n${devices.join('\n')}\n`;
}

export function started(arguments_, pattern) {
  const child = spawn(TAKT, arguments_);
  return new Promise((found, failed) => {
    let text = '';
    const look = (data) => {
      text += data;
      const match = text.match(pattern);
      if (match) found({ child, match });
    };
    child.stdout.on('data', look);
    child.stderr.on('data', look);
    child.on('exit', () => failed(new Error(`the program ended: ${text}`)));
  });
}

const ended = (child) =>
  new Promise((done) => {
    child.on('exit', done);
    child.kill('SIGINT');
  });

export class Field {
  /** @param count  variables, each with another value ten times a second */
  static async start(count) {
    const its = new Field();
    its.folder = mkdtempSync(join(tmpdir(), 'takt-field-'));
    const port = await freePort();
    const field = join(its.folder, 'field.yaml');
    its.file = join(its.folder, 'plant.yaml');
    writeFileSync(field, fieldProject(count, port));
    const line = { transport: 'tcp', host: '127.0.0.1', tcp_port: port };
    writeFileSync(its.file, plantProject(count, line) + HISTORY);
    its.server = spawn(TAKT, ['serve', field], { stdio: 'ignore' });
    const { child, match } = await started(
      ['run', its.file, '--web', '127.0.0.1:0', '--quiet', '--allow-write'],
      /http:\/\/127\.0\.0\.1:\d+\//,
    );
    its.program = child;
    its.url = match[0];
    return its;
  }
  async stop() {
    await ended(this.program);
    await ended(this.server);
    rmSync(this.folder, { recursive: true, force: true });
  }
}

const TICKS = 100; // of the clock of /proc, in a second

/** Seconds of processor time of a process. */
export function processorTime(pid) {
  const fields = readFileSync(`/proc/${pid}/stat`, 'utf8')
    .replace(/^.*\) /, '')
    .split(' ');
  return (Number(fields[11]) + Number(fields[12])) / TICKS;
}
/** Resident memory in MB. */
export function residentMemory(pid) {
  const match = readFileSync(`/proc/${pid}/status`, 'utf8').match(/VmRSS:\s+(\d+)/);
  return Number(match?.[1] ?? 0) / 1024;
}
