// Projects that are built and changed in the page: scenario 1 of the source by hand, two browsers at one
// file, outputs and instruments, a project of 1,024 variables.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { after, afterEach, before, beforeEach, test } from 'node:test';
import { plantProject } from '../measure/field.mjs';
import {
  browser,
  closePages,
  newContext,
  openPage,
  Plant,
  serve,
  toast,
  pasteInto,
  pasteTables,
} from './program.mjs';

const SMALL = `takt: 1
# Scenario 1 of the source takes its place.
lines:
  - name: old
    transport: simulated
    devices:
      - {name: Old, address: 1, variables: [{name: Old value, type: int16, register: 0, read: 0x03}]}
`;

let plant; // of one test
let chromium;
let context;
let errors;
before(async () => {
  chromium = await browser();
  context = await newContext(chromium, { viewport: { width: 1440, height: 900 } });
});
after(() => chromium?.close());
beforeEach(() => {
  plant = undefined;
  errors = [];
});
afterEach(async () => {
  await closePages(context);
  await plant?.stop();
  assert.deepEqual(errors, []);
});

const startWith = (project) => Plant.start((file) => writeFileSync(file, project));
const open = (hash = '#/project') => openPage(context, `${plant.url}?lang=en&theme=light${hash}`, errors);
const text = () => readFileSync(plant.file, 'utf8');

async function save(page) {
  await page.getByRole('button', { name: 'Save…' }).click();
  const dialog = page.getByRole('dialog');
  await dialog.getByRole('button', { name: 'Save and apply' }).click();
  await dialog.waitFor({ state: 'detached' });
}

test('scenario 1 of the source is built by hand', async () => {
  plant = await startWith(SMALL);
  const page = await open();
  await page.getByRole('treeitem', { name: 'Project settings' }).click();
  await page.getByLabel('Profile').selectOption('owen-kc1');
  await page.getByRole('treeitem', { name: /^old/ }).click();
  await page.getByRole('button', { name: 'Delete', exact: true }).click();
  await page.getByRole('button', { name: 'Line', exact: true }).click();
  await page.locator('.form .banner', { hasText: 'A simulated line has no hardware' }).waitFor();
  await page.getByLabel('Name', { exact: true }).fill('Node1');
  await page.getByLabel('Bit rate, bit/s').fill('115200');
  await page.getByLabel('Parity').selectOption('none');
  await page.getByRole('button', { name: 'Device', exact: true }).click();
  await page.getByLabel('Name', { exact: true }).fill('Device1');
  await page.getByLabel('Address', { exact: true }).fill('16');
  await page.getByLabel('Poll period, ms').fill('100');
  await page.getByLabel('Group requests').selectOption('true');
  await page.getByLabel('Registers per request').fill('125');

  await page.getByRole('tab', { name: /^Variables/ }).click();
  await page.getByRole('button', { name: 'Add', exact: true }).click();
  const grid = page.getByRole('grid', { name: 'Variables' });
  await grid.locator('[role="row"]').nth(1).locator('[role="gridcell"]').nth(1).dblclick();
  await grid.locator('select').selectOption('float');
  await page.keyboard.press('Enter');
  for (let i = 1; i < 10; ++i) await page.getByRole('button', { name: 'Add', exact: true }).click();
  await grid.getByText('Var10').waitFor();
  await page.getByText('1 request instead of 10').waitFor();
  const request = page.getByRole('grid', { name: 'Requests' }).locator('[role="row"]').nth(1);
  assert.match(await request.textContent(), /0x030?20.*Var1, Var2, Var3/);

  await save(page);
  const rows =
    text().match(/name: Var\d+, type: float, register: \d+, read: 0x03/g) ?? text().match(/name: Var\d+/g);
  assert.equal(rows.length, 10, text());
  assert.match(text(), /# Scenario 1 of the source/);
  // What the source's capture shows: one request for all ten.
  await page.goto(`${plant.url}#/traffic`);
  await page
    .getByText(/^10 03 00 00 00 14/)
    .first()
    .waitFor();
  await page.goto(`${plant.url}#/project`);
  await page.getByRole('treeitem', { name: /Device1, 16/ }).click();
  await page.getByRole('tab', { name: 'Settings' }).click();
  await page.getByLabel('Group requests').selectOption('false');
  await page.getByText('10 requests, one for each variable').waitFor();
});

test('the answer to an earlier edit does not undo what is chosen in a cell', async () => {
  plant = await startWith(SMALL);
  const page = await open();
  await page.getByRole('treeitem', { name: /^Old/ }).click();
  await page.getByRole('tab', { name: /^Variables/ }).click();
  await page.getByRole('grid', { name: 'Requests' }).locator('[role="row"]').nth(1).waitFor();
  const grid = page.getByRole('grid', { name: 'Variables' });
  let answer;
  const chosen = new Promise((done) => {
    answer = done;
  });
  await page.route('**/project/evaluate*', async (route) => {
    await chosen;
    await route.continue();
  });
  await page.getByRole('button', { name: 'Add', exact: true }).click();
  const cell = grid.locator('[role="row"]').nth(1).locator('[role="gridcell"]').nth(1);
  await cell.dblclick();
  await grid.locator('select').selectOption('float');
  answer();
  await page.getByText('1 request instead of 2').waitFor();
  assert.equal(await grid.locator('select').inputValue(), 'float');
  await page.keyboard.press('Enter');
  await grid.locator('select').waitFor({ state: 'detached' });
  assert.match(await cell.textContent(), /float/i);
});

test('two browsers change one project: the second one merges, and nothing is lost', async () => {
  plant = await Plant.start();
  const first = await open();
  const second = await open();
  for (const page of [first, second]) await page.getByRole('treeitem', { name: /Boiler, 16/ }).click();
  await first.getByLabel('Poll period, ms').fill('400');
  await second.getByLabel('Attempts').fill('5');
  await save(first);
  const banner = second.getByRole('alert').filter({ hasText: 'The file was changed on the disk' });
  await banner.waitFor();
  await banner.getByRole('button', { name: 'Merge with my changes' }).click();
  await toast(second, 'Your changes are merged with the file.');
  assert.equal(await second.getByLabel('Poll period, ms').inputValue(), '400');
  assert.equal(await second.getByLabel('Attempts').inputValue(), '5');
  await save(second);
  assert.match(text(), /poll_period: 400ms/);
  assert.match(text(), /attempts: 5/);
  // The first browser has no edits: it follows.
  await first.waitForFunction(() => document.getElementById('lines[0].devices[0].attempts')?.value === '5');
});

test('both browsers show the same values', async () => {
  plant = await Plant.start();
  const pages = [await open('#/live'), await open('#/live')];
  await pages[0].getByRole('button', { name: 'Write: Setpoint' }).click();
  await pages[0].getByLabel('New value').fill('33.25');
  await pages[0].getByRole('dialog').locator('code').first().waitFor();
  await pages[0].keyboard.press('Enter');
  for (const page of pages) await page.getByRole('grid').getByText('33.25').waitFor();
});

test('commands are marks in the trends, also after a reload and a restart of the program', async () => {
  plant = await Plant.start();
  const page = await open('#/live');
  await page.getByRole('button', { name: 'Write: Setpoint' }).click();
  await page.getByLabel('New value').fill('21.5');
  await page.getByRole('dialog').locator('code').first().waitFor();
  await page.keyboard.press('Enter');
  await toast(page, 'Setpoint = 21.5: acknowledged, not read back');
  await page.goto(`${plant.url}?lang=ru#/trends?pens=Setpoint&span=60`);
  await page.reload();
  const marks = page.locator('details.marks');
  await marks.locator('summary').click();
  const mark = marks.getByRole('listitem').filter({ hasText: 'Setpoint = 21.5' });
  await mark.waitFor();
  assert.match(await mark.textContent(), /браузер 127\.0\.0\.1/);
  await marks.getByText('Boiler: отвечает').waitFor();
  await page.goto('about:blank');
  await plant.end();
  await plant.run();
  await page.goto(`${plant.url}?lang=uk#/trends?pens=Setpoint&span=60`);
  await marks.locator('summary').click();
  await mark.waitFor();
  assert.match(await mark.textContent(), /браузер 127\.0\.0\.1/);
});

const FROM_FILES = `takt: 1
lines:
  - name: bus # the only one
    transport: simulated
    devices:
      - {name: Meter, address: 1, variables: meter.csv}
      - name: Drive
        address: 2
        device_template: drive.yaml
        parameters: {base: 100} # second drive
`;

test('the rows of a table and of a template are taken over, edited and saved', async () => {
  plant = await Plant.start((file) => {
    writeFileSync(file, FROM_FILES);
    writeFileSync(
      join(dirname(file), 'meter.csv'),
      'Name;Type;Register;Read;Scale\nVolts;int16;0;0x03;0,1\nAmps;int16;1;0x03;0,01\n',
    );
    writeFileSync(
      join(dirname(file), 'drive.yaml'),
      'takt: 1\nparameters: {base}\npoll_period: 5s\nvariables:\n' +
        '  - {name: Speed, type: int16, register: $(base + 2), read: 0x03}\n',
    );
  });
  const page = await open();
  await page.getByRole('treeitem', { name: /^Meter/ }).click();
  await page.getByRole('tab', { name: /^Variables/ }).click();
  await page.getByText(/Volts/).first().waitFor();
  assert.equal(await page.getByRole('button', { name: 'Add', exact: true }).count(), 0);
  await page.getByRole('button', { name: 'Take the table into the project' }).click();
  await page.getByRole('button', { name: 'Add', exact: true }).waitFor(); // the rows can be edited now
  await page.getByRole('gridcell', { name: 'Amps', exact: true }).dblclick();
  await page.locator('.cell-editor').fill('Current');
  await page.keyboard.press('Enter');
  await page.getByRole('treeitem', { name: /^Drive/ }).click();
  await page.getByText('Variables of the template (1)').click();
  await page.getByRole('button', { name: 'Take the template into the device' }).click();
  await page.getByRole('gridcell', { name: 'Drive.Speed', exact: true }).first().waitFor();
  await page.getByText('Variables of the template').waitFor({ state: 'detached' });
  // Undo takes the template back, redo takes it over again.
  await page.getByRole('button', { name: /^Undo/ }).click();
  await page.getByText('Variables of the template (1)').waitFor();
  await page.getByRole('button', { name: /^Redo/ }).click();
  await page.getByText('Variables of the template').waitFor({ state: 'detached' });

  await page.getByRole('button', { name: 'Save…' }).click();
  const dialog = page.getByRole('dialog');
  await dialog.getByText('variables: meter.csv').first().waitFor();
  await dialog.getByRole('button', { name: 'Save and apply' }).click();
  await dialog.waitFor({ state: 'detached' });
  assert.match(text(), /name: bus # the only one/);
  assert.match(text(), /\{name: Volts, type: int16, register: 0, read: 0x03, scale: 0\.1\}/);
  assert.match(text(), /\{name: Current, type: int16, register: 1, read: 0x03, scale: 0\.01\}/);
  assert.match(text(), /poll_period: 5s/);
  assert.match(text(), /\{name: Drive\.Speed, type: int16, register: 102, read: 0x03\}/);
  assert.doesNotMatch(text(), /meter\.csv|device_template|parameters/);
  assert.match(readFileSync(join(dirname(plant.file), 'meter.csv'), 'utf8'), /Amps;int16;1;0x03;0,01/);
  // After the save the rows are those of the project.
  await page.getByRole('treeitem', { name: /^Meter/ }).click();
  await page.getByRole('gridcell', { name: 'Current', exact: true }).first().waitFor();
  assert.equal(await page.getByRole('button', { name: /^Take the/ }).count(), 0);
});

test('outputs and instruments are added and checked like everything else', async () => {
  plant = await Plant.start();
  const page = await open();
  await page.getByRole('treeitem', { name: /Boiler, 16/ }).waitFor();
  await page.getByRole('button', { name: 'Instrument', exact: true }).click();
  await page.getByLabel('Every, ms').fill('5');
  const mark = page.locator('.mark.error').first();
  await mark.waitFor();
  assert.match(await mark.getAttribute('aria-label'), /10ms\.\.24h/);
  await page.getByLabel('Every, ms').fill('500');
  await mark.waitFor({ state: 'detached' });
  await page.locator('.part summary').first().click();
  await page.getByLabel('Request', { exact: true }).fill('W\\r');
  await page.getByRole('button', { name: 'Output', exact: true }).click();
  await page.getByLabel('Brokers').fill('mqtt://127.0.0.1:1');
  await save(page);
  assert.match(text(), /instruments:\n/);
  assert.match(text(), /every: 500ms/);
  assert.match(text(), /request: 'W\\r'|request: W\\r/);
  assert.match(text(), /mqtt:\/\/127\.0\.0\.1:1/);
});

/** Runs in the page: does something to its table, and returns after the frames that show it. */
async function act({ what, turn }) {
  const frame = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
  const frames = () => frame().then(frame).then(frame); // a scroll event comes with the next one
  const grid = document.querySelector('.table .grid');
  const filter = document.querySelector('.table input[type="search"]');
  const type = (box, text) => {
    Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, 'value').set.call(box, text);
    box.dispatchEvent(new InputEvent('input', { bubbles: true }));
  };
  if (what === 'scroll') grid.scrollTop = (turn % 10) * 250;
  if (what === 'filter') {
    type(filter, 'D1.V9');
    await frames();
    type(filter, '');
  }
  if (what === 'move') {
    grid.focus();
    grid.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowDown', bubbles: true }));
  }
  // The rows in sight once more, as they are, without what the page does for them.
  const copy = what === 'copy' && grid.cloneNode(true);
  if (copy) grid.after(copy);
  await frames();
  if (copy) copy.remove();
}

/**
 * What each act costs in a project whose first device has 100 variables: milliseconds of processor time of
 * the page's thread, so that other programs on this computer do not count. The median of several turns,
 * because the page does other things in some of them.
 */
async function costs(variables) {
  plant = await startWith(plantProject(variables, { transport: 'simulated', baud: 115200 }, '10s'));
  // The last evaluation of a project that was opened.
  const evaluated = context.waitForEvent('response', (its) => its.url().includes('measures=1'));
  const page = await open();
  await page.getByRole('treeitem', { name: /Device 1, 1/ }).click();
  await page.getByRole('tab', { name: /^Variables/ }).click();
  const table = page.getByRole('grid', { name: 'Variables' });
  await table.getByText('D1.V1', { exact: true }).waitFor();
  assert.equal(await table.getAttribute('aria-rowcount'), '101');
  const drawn = await table.getByRole('row').count();
  assert.ok(drawn < 80, `${drawn} rows are drawn`);
  await page.getByRole('grid', { name: 'Requests' }).waitFor();
  await evaluated;
  const devtools = await context.newCDPSession(page);
  await devtools.send('Performance.enable', { timeDomain: 'threadTicks' });
  const spent = async () => {
    const { metrics } = await devtools.send('Performance.getMetrics');
    return 1000 * metrics.find((its) => its.name === 'TaskDuration').value;
  };
  const found = {};
  for (const what of ['scroll', 'filter', 'move', 'copy']) {
    const turns = [];
    for (let turn = 1; turn <= 9; ++turn) {
      const before = await spent();
      await page.evaluate(act, { what, turn });
      turns.push((await spent()) - before);
    }
    found[what] = turns.sort((a, b) => a - b)[turns.length >> 1];
  }
  await closePages(context);
  await plant.stop();
  plant = undefined;
  return found;
}

test('a project of 1,024 variables stays quick', async () => {
  const small = await costs(100);
  const large = await costs(1024);
  const text = JSON.stringify({ small, large });
  console.log(`milliseconds of processor time: ${text}`);
  for (const what of ['scroll', 'filter', 'move']) {
    assert.ok(large[what] < 3 * small[what], `${what} of ten times as many variables: ${text}`);
    // What the page works out for its rows must not take much longer than to draw them.
    assert.ok(large[what] < 8 * large.copy, `${what} beside a copy of the rows: ${text}`);
  }
});

test('an empty project begins with an example, which runs after saving', async () => {
  plant = await startWith('takt: 1\nlines: []\n');
  await context.route('**/search/targets*', (route) =>
    route.fulfill({ json: { targets: ['rtu:///dev/ttyUSB7', 'tcp://10.0.0.1-254'] } }),
  );
  const page = await open('');
  // The search for devices is first, with what this computer is connected to.
  const targets = page.getByRole('group', { name: 'On this computer:' });
  await targets.getByRole('button', { name: '10.0.0.1-254' }).waitFor();
  await targets.getByRole('button', { name: '/dev/ttyUSB7' }).click();
  assert.equal(await page.getByLabel('Target').inputValue(), 'rtu:///dev/ttyUSB7');
  assert.ok(await page.getByRole('button', { name: 'Scan' }).isEnabled());
  await context.unroute('**/search/targets*');
  await page.getByRole('button', { name: 'Paste a table' }).click();
  await page.getByRole('dialog').getByRole('textbox').waitFor();
  await page.keyboard.press('Escape');
  await page.getByRole('dialog').waitFor({ state: 'detached' });
  // Nothing was changed, so nothing can be undone.
  const undo = page.getByRole('button', { name: 'Undo' });
  assert.ok(await undo.isDisabled());
  await page.locator('.health', { hasText: 'No device yet' }).waitFor();
  await pasteTables(page);
  // A table gets the line that the user describes, as one step.
  await page.getByRole('button', { name: 'Paste a table' }).click();
  const dialog = page.getByRole('dialog');
  await dialog.getByRole('textbox').fill('Name\tType\tRegister\nLevel\tfloat\t10');
  const accept = dialog.getByRole('button', { name: 'Take over' });
  await dialog.getByLabel('Connection').waitFor();
  assert.ok(await accept.isDisabled(), 'a serial line needs its port');
  await dialog.getByLabel('Port', { exact: true }).fill('/dev/ttyS7');
  assert.ok(await accept.isEnabled());
  await dialog.getByLabel('Connection').selectOption('simulated');
  // The button that was pressed is gone: the one that acts next has the focus.
  const next = page.getByRole('button', { name: 'Save…' }).and(page.locator(':focus'));
  await accept.click();
  await page.getByRole('treeitem', { name: /^Simulated/ }).waitFor();
  await next.waitFor();
  // A button that can be pressed no more leaves the focus to the tree.
  const tree = page.getByRole('tree').and(page.locator(':focus'));
  await undo.click();
  await tree.waitFor();
  await page.getByRole('button', { name: 'Example' }).press('Enter');
  await next.waitFor();
  await page.keyboard.press('Enter');
  await page.getByRole('button', { name: 'Save and apply' }).and(page.locator(':focus')).waitFor();
  await page.keyboard.press('Enter');
  await page.getByRole('dialog').waitFor({ state: 'detached' });
  await tree.waitFor();
  await page.locator('nav a[href="#/live"]').click();
  const row = page.locator('[role="row"]', { hasText: 'Supply temperature' });
  await row.locator('.value', { hasText: /\d/ }).waitFor();
  assert.match(text(), /lines:\n\s+- name: example/);
});

test('a first project over TCP shows no red before something is late', async (t) => {
  const device = await serve();
  t.after(() => device.stop());
  const variables = Array.from(
    { length: 10 },
    (_, i) => `          - {name: V${i}, type: int16, register: ${200 * i}, read: 0x03}\n`,
  );
  plant = await startWith(`takt: 1
lines:
  - name: net
    transport: tcp
    host: 127.0.0.1
    tcp_port: ${device.port}
    devices:
      - name: Meter
        address: 7
        poll_period: 100ms
        variables:
${variables.join('')}`);
  const page = await open('#/project');
  const line = page.locator('.unmeasured', { hasText: 'Meter' });
  // After 100 exchanges the button offers the measured time.
  await line.getByRole('button', { name: /^(Measure|Use \d+ms)$/ }).waitFor();
  const shown = await page.locator('main').textContent();
  assert.doesNotMatch(shown, /at risk/);
  // The offered time names what it rests on.
  await line.getByText(/^Measured: longest .* over [\d,]+ exchanges$/).waitFor();
  assert.deepEqual(await page.locator('main .bad, main .late').allInnerTexts(), []);
  await page.locator('nav a[href="#/live"]').click();
  await page.locator('[role="row"]', { hasText: 'V9' }).locator('.value', { hasText: /\d/ }).waitFor();
  assert.deepEqual(await page.locator('main .bad, .health .bad').allInnerTexts(), []);
});

test('measures of a line that was not measured are estimates', async () => {
  plant = await startWith(`takt: 1
lines:
  - name: bus
    transport: simulated
    baud: 1200
    devices:
      - name: Meter
        address: 1
        poll_period: 100ms
        variables:
          - {name: A, type: int16, register: 0, read: 0x03}
          - {name: B, type: int16, register: 500, read: 0x03}
`);
  const page = await open('#/project');
  await page.getByText('Searching for measures').waitFor({ state: 'detached' });
  const measures = page.locator('details.measures');
  await measures.getByText(/rest on an assumed one/).waitFor();
  await measures.locator('.measure summary').first().click();
  const loads = await measures.getByText(/in the worst case/).allInnerTexts();
  assert.ok(loads.length > 0);
  for (const load of loads) assert.match(load, /≈ [\d.]+ %$/);
  await page.locator('.utilisation').getByText(/^≈ \d/).waitFor();
  await page.locator('.strategy.current').getByText(/^≈ \d/).waitFor();
});

const LISTED = [
  'Имя переменной\tТип\tАдрес регистра\tКомментарий',
  'Температура\tС плавающей запя...\t5\t',
  'Давление\tЦелочисленное\t7\t',
];

test('the window of a device is pasted as the IDE shows it', async () => {
  plant = await startWith('takt: 1\nlines: []\n');
  const page = await open('#/project');
  const lines = (name, address) => [
    `Имя;${name}`,
    `Адрес;${address}`,
    'Период опроса, мс;100',
    'Таймаут ответа, мс;150',
    'Кол-во попыток;3',
    'Протокол;Modbus ASCII',
    'Группировать запросы;Да',
    'Кол-во регистров в запросе;20',
    'Порядок байт;☒ Старшим байтом вперед ☐ Старшим регистром вперед',
    'Float;2 1 4 3',
  ];
  await page.getByRole('button', { name: 'Paste a table' }).click();
  const dialog = page.getByRole('dialog');
  const pasted = dialog.getByRole('textbox', { name: 'Pasted table' });
  const take = dialog.getByRole('button', { name: 'Take over' });
  await pasted.fill(`${lines('Устройство', 16).join('\n')}\nV1;int;0;\n`);
  await dialog.locator('.error', { hasText: /^Line 11: .*V1;int;0;/ }).waitFor();
  assert.ok(await take.isDisabled());
  await pasted.fill(lines('Устройство', 16).join('\n'));
  await dialog.locator('td', { hasText: '2143' }).waitFor();
  assert.equal(await dialog.locator('.error, .warning').count(), 0);
  await dialog.getByLabel('Port', { exact: true }).fill('/dev/ttyS7');
  await dialog.getByRole('button', { name: 'Take over' }).click();
  await dialog.waitFor({ state: 'detached' });
  await page.getByRole('treeitem', { name: 'Устройство, 16' }).click();
  // A second window with its table, into the grid of the first device.
  await page.getByRole('tab', { name: /Variables/ }).click();
  const grid = page.getByRole('grid', { name: 'Variables' });
  await grid.evaluate(
    (element, window) => {
      const data = new DataTransfer();
      data.setData('text/plain', window);
      element.dispatchEvent(new ClipboardEvent('paste', { clipboardData: data, bubbles: true }));
    },
    ['RS485, Слот 1, Master', ...lines('Устройство', 17), '', ...LISTED].join('\n'),
  );
  await dialog.locator('td', { hasText: 'Давление' }).waitFor();
  await take.click();
  await page.getByRole('treeitem', { name: 'Устройство, 17' }).waitFor();
  await save(page);
  const settings = 'poll_period: 100ms, response_timeout: 150ms, attempts: 3, group_requests: true, ';
  const saved = text().replace(/\n\s+(?=\w+:)/g, ', ');
  assert.equal(saved.split(settings).length, 3, text());
  assert.match(saved, /name: Устройство, address: 16/);
  assert.match(saved, /name: Устройство, address: 17/);
  assert.match(saved, /\{name: Давление, type: int16, area: holding_register, register: 7/);
  assert.match(saved, /byte_order: "2143"/);
  assert.match(saved, /transport: serial, port: \/dev\/ttyS7/);
  assert.match(saved, /framing: ascii/);
  assert.doesNotMatch(saved, /protocol|Device 1/);
});

test('a paste says what is wrong, what it renames and what it replaces', async () => {
  plant = await startWith(SMALL);
  const page = await open();
  await page.getByRole('treeitem', { name: /^Old, 1/ }).click();
  await page.getByRole('tab', { name: /^Variables/ }).click();
  const grid = page.getByRole('grid', { name: 'Variables' });
  await grid.getByText('Old value').first().click();
  const window = (name, address) =>
    `Имя;${name}\nАдрес;${address}\nПериод опроса, мс;100\n\n` +
    `Имя переменной;Тип;Адрес регистра\nLevel;float;5\nOld value;int;9\n\n`;
  await pasteInto(grid, window('Tank', 'abc'));
  const dialog = page.getByRole('dialog');
  const take = dialog.getByRole('button', { name: 'Take over' });
  await dialog.locator('.error', { hasText: /^Line 2, Address: .*abc.* 1\.\.247/ }).waitFor();
  assert.ok(await take.isDisabled());
  await dialog.locator('footer', { hasText: 'Correct the errors in the table first.' }).waitFor();
  // Escape leaves everything as it was, with the focus at the cell.
  await page.keyboard.press('Escape');
  await dialog.waitFor({ state: 'detached' });
  assert.ok(await grid.evaluate((its) => its === document.activeElement));
  assert.equal(await grid.locator('[role="row"].selected').count(), 1);

  await pasteInto(grid, window('Tank', 1) + window('Pump', 2));
  await dialog.locator('.warning', { hasText: /^Replaces the device Old, 1: 1 variable$/ }).waitFor();
  await dialog.locator('.warning', { hasText: 'for example Tank.Level' }).waitFor();
  await dialog.locator('td', { hasText: 'Pump.Old value' }).waitFor();
  await dialog.locator('td', { hasText: 'Holding registers' }).first().waitFor();
  await take.click();
  await dialog.waitFor({ state: 'detached' });
  await page.getByRole('treeitem', { name: 'Pump, 2' }).click();
  // A later paste meets the names that other devices have.
  await pasteInto(grid, 'Имя переменной;Тип;Адрес регистра\nTank.Level;int;20\nPump.Level;int;21\n');
  await dialog.locator('td', { hasText: 'Pump.Tank.Level' }).waitFor();
  await dialog.getByText('Replaces 1 row: Pump.Level').waitFor();
  await take.click();
  await dialog.waitFor({ state: 'detached' });
  // Rows without headings have the words of the IDE too.
  await pasteInto(grid, 'Word\tWORD\t3\tнет\t40\nPlain\tЦелочисленный без знака\t3\tнет\t41');
  await grid.getByText('Plain', { exact: true }).waitFor();
  await save(page);
  assert.match(text(), /name: Word, type: uint16, .*\n.*name: Plain, type: uint16, /);
  for (const name of ['Tank.Level', 'Pump.Level', 'Tank.Old value', 'Pump.Old value', 'Pump.Tank.Level'])
    assert.ok(text().includes(`{name: ${name}, `), text());
});

test('Ctrl+S and Enter save in each view, and what was saved can be undone', async () => {
  plant = await startWith(SMALL);
  const page = await open('#/project');
  await page.locator('.tree').getByText('Old, 1').click();
  const period = page.getByLabel('Poll period, ms');
  await period.fill('250');
  await period.press('Tab');
  await page.locator('nav a[href="#/traffic"]').click();
  await page.keyboard.press('Control+s');
  await page.getByRole('button', { name: 'Save and apply' }).and(page.locator(':focus')).waitFor();
  await page.keyboard.press('Enter');
  await page.getByRole('dialog').waitFor({ state: 'detached' });
  assert.match(text(), /poll_period: 250ms/);
  await page.locator('nav a[href="#/project"]').click();
  await page.locator('.tree').waitFor();
  await page.keyboard.press('Control+z');
  await page.keyboard.press('Control+s');
  await page.getByRole('button', { name: 'Save and apply' }).and(page.locator(':focus')).waitFor();
  await page.keyboard.press('Enter');
  await page.getByRole('dialog').waitFor({ state: 'detached' });
  assert.doesNotMatch(text(), /250ms/);
  assert.match(text(), /# Scenario 1 of the source takes its place/);
});
