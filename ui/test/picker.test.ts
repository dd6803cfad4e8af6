import assert from 'node:assert/strict';
import test from 'node:test';
import { choicesOf, fitsType, searched } from '../src/views/project/choices';
import {
  completed,
  framingIn,
  itemOf,
  itemsBefore,
  lineOf,
  merged,
  newTargets,
  targetAt,
  targetsFor,
} from '../src/views/project/importing';

const document = {
  lines: [
    {
      name: 'north',
      devices: [
        { name: 'Pump', address: '1', variables: [{ name: 'Speed', type: 'int', comment: 'turns' }] },
        { name: 'Fan', address: '2', variables: 'fan.csv' },
      ],
    },
    { name: 'south', devices: [{ name: 'Pump', address: '1' }] },
  ],
  locals: [{ name: 'go', type: 'bool' }],
  servers: [{ name: 'gate', units: [{ address: '1' }] }],
};

test('the picker has standard, service and network variables', () => {
  const [standard, service, ...network] = choicesOf(document);
  assert.deepEqual(
    standard!.choices.map((its) => its.name),
    ['go'],
  );
  const names = service!.choices.map((its) => its.name);
  assert.ok(names.includes('system.pulse_1s') && names.includes('system.line.south.up'));
  // The name of two devices: with their lines.
  assert.ok(names.includes('system.device.north/Pump.answering'));
  assert.ok(names.includes('system.device.Fan.state'));
  assert.deepEqual(
    network.map((its) => [its.slot, its.line, its.choices.length]),
    [
      [1, 'north', 1],
      [2, 'south', 0],
    ],
  );
  assert.deepEqual(network[0]!.choices[0], {
    name: 'Speed',
    type: 'int16',
    comment: 'turns',
    retain: false,
    initial: '',
    used: true,
    group: 'Pump, 1',
  });
  const kept = { name: 'r1', type: 'int', retain: 'true', default: '1', used: 'false' };
  const { retain, initial, used } = choicesOf({ locals: [kept] })[0]!.choices[0]!;
  assert.deepEqual([retain, initial, used], [true, '1', false]);
});

test('the picker searches names, comments and devices, and knows the types', () => {
  const { choices } = choicesOf(document)[2]!;
  assert.equal(searched(choices, 'TURN').length, 1);
  assert.equal(searched(choices, 'fan').length, 0);
  assert.ok(fitsType('bool', 'bool') && fitsType('uint32', 'int') && !fitsType('float', 'int'));
});

test('an imported table goes where its kind fits', () => {
  const names = { locals: 'Standard', devices: 'Devices' };
  const paths = (kind: Parameters<typeof targetsFor>[1]) =>
    targetsFor(document, kind, names).map((its) => its.path.join('/'));
  assert.deepEqual(paths('locals'), ['locals']);
  assert.deepEqual(paths('served'), ['servers/0/units/0/variables']);
  // The table of a file is read-only.
  assert.deepEqual(paths('variables'), ['lines/0/devices/0/variables', 'lines/1/devices/0/variables']);
  assert.deepEqual(paths('devices'), ['lines/0/devices', 'lines/1/devices']);
});

test('an imported table can go to a new device or a new line', () => {
  const names = { device: (line: string) => `${line}: new`, line: 'new', server: 'slave' };
  const made = (kind: Parameters<typeof newTargets>[1]) =>
    newTargets(document, kind, names).map((its) => `${its.path.join('/')} ${its.makes}`);
  assert.deepEqual(made('list'), [
    'lines/0/devices/2/variables device',
    'lines/1/devices/1/variables device',
    'lines/2/devices/0/variables line',
  ]);
  assert.deepEqual(made('devices'), ['lines/2/devices line']);
  assert.deepEqual(made('served'), ['servers/1/units/0/variables server']);
  const line = (transport: Parameters<typeof lineOf>[1]['transport'], port = '', host = '') =>
    lineOf(document.lines, { transport, port, host, tcp_port: '' }, { line: 'north', simulated: 'toy' });
  assert.equal(line('serial', ' ', 'plc'), undefined);
  assert.deepEqual(line('serial', 'COM3'), {
    name: 'north 2',
    transport: 'serial',
    port: 'COM3',
    devices: [],
  });
  assert.deepEqual(line('tcp', 'COM3', 'plc'), {
    name: 'north 2',
    transport: 'tcp',
    host: 'plc',
    devices: [],
  });
  assert.deepEqual(line('simulated', 'COM3'), { name: 'toy', transport: 'simulated', devices: [] });
});

test('imported rows overwrite those with the same name, or replace all', () => {
  const list = [
    { name: 'A', register: '1', comment: 'kept', $from: 0 },
    { name: 'B', register: '2', $from: 1 },
  ];
  const items = [itemOf({ name: 'B', register: '7', tags: 'x, y' }, 'variable'), { name: 'C' }];
  assert.deepEqual(merged(list, items, false), [
    list[0],
    { name: 'B', register: '7', tags: ['x', 'y'], $from: 1 },
    { name: 'C' },
  ]);
  assert.deepEqual(merged(list, items, true), [
    { name: 'B', register: '7', tags: ['x', 'y'], $from: 1 },
    { name: 'C' },
  ]);
});

test('the window of a device goes to its line, in place of a new device', () => {
  const targets = targetsFor(document, 'devices', { locals: 'Standard', devices: 'Devices' });
  const at = (path: Parameters<typeof targetAt>[1]) => targetAt(targets, path)?.path.join('/');
  assert.equal(at(['lines', 1, 'devices', 0, 'variables']), 'lines/1/devices');
  assert.equal(at(null), 'lines/0/devices');
  const row = { name: 'Устройство', address: '16', protocol: 'Modbus ASCII' };
  assert.deepEqual(itemOf(row, 'variable'), { name: 'Устройство', address: '16' });
  const lacking = [
    { attempts: '3', variables: [{ name: 'A', type: 'int16' }] },
    { address: '2', name: 'X' },
  ];
  const whole = completed(lacking, [{ name: 'Device', address: '1' }], 'Device');
  assert.deepEqual(
    whole.map((its) => [its.name, its.address]),
    [
      ['Device 2', '3'],
      ['X', '2'],
    ],
  );
  assert.deepEqual(itemOf(whole[0]!, 'variable').variables, [{ name: 'A', type: 'int16' }]);
  const twins = ['16', '17'].map((address) => ({ name: 'Устройство', address }));
  assert.deepEqual(merged([], twins, false, 'address'), twins);
  assert.equal(framingIn([row], { transport: 'serial' }), 'ascii');
  assert.equal(framingIn([row], { transport: 'tcp' }), undefined);
  const fresh = [{ name: 'Device 1', variables: [] }];
  assert.deepEqual(itemsBefore(fresh, 'devices', ['lines', 0, 'devices', 0, 'variables']), []);
  assert.deepEqual(itemsBefore(fresh, 'variables', ['lines', 0, 'devices', 0, 'variables']), fresh);
  const saved = [{ name: 'Device 1', variables: [], $from: 0 }];
  assert.deepEqual(itemsBefore(saved, 'devices', ['lines', 0, 'devices', 0, 'variables']), saved);
  const pasted = [{ name: 'Device 1', period: '100ms', variables: [] }];
  assert.deepEqual(itemsBefore(pasted, 'devices', ['lines', 0, 'devices', 0, 'variables']), pasted);
});
