import assert from 'node:assert/strict';
import test from 'node:test';
import { itemPath, severities, treeOf } from '../src/views/project/tree';

const document = {
  lines: [
    {
      name: 'a',
      devices: [
        { name: 'Device', address: '16', variables: [{}, {}] },
        { name: 'Table', variables: 'x.csv' },
      ],
    },
    { name: 'b', host: '10.0.0.1' },
    { name: 'c', transport: 'simulated' },
  ],
  servers: [{ name: 'gate', units: [{ address: '1' }] }],
  outputs: [{ name: 'mqtt' }],
};

test('the tree is that of the source', () => {
  const items = treeOf(document, () => true);
  assert.deepEqual(
    items.map((its) => [its.kind, its.id, its.name, its.medium, its.slot]),
    [
      ['project', 'project', '', '', 0],
      ['line', 'lines[0]', 'a', 'RS485', 1],
      ['device', 'lines[0].devices[0]', 'Device, 16', '', 0],
      ['device', 'lines[0].devices[1]', 'Table', '', 0],
      ['line', 'lines[1]', 'b', 'TCP', 2],
      ['line', 'lines[2]', 'c', 'simulated', 3],
      ['locals', 'locals', '', '', 0],
      ['server', 'servers[0]', 'gate', 'TCP', 4],
      ['unit', 'servers[0].units[0]', '1', '', 0],
      ['output', 'outputs[0]', 'mqtt', '', 0],
    ],
  );
  assert.deepEqual(
    treeOf(document, () => false).map((its) => its.kind),
    ['project', 'line', 'line', 'line', 'locals', 'server', 'output'],
  );
});

test('a finding belongs to an item of the tree', () => {
  assert.deepEqual(itemPath('lines[0].devices[2].variables[1].register'), ['lines', 0, 'devices', 2]);
  assert.deepEqual(itemPath('locals[3].default'), ['locals']);
  assert.deepEqual(itemPath('profile'), []);
});

test('the worst severity is known for each path above a finding', () => {
  const worst = severities([
    { path: 'lines[0].devices[0].variables[1].register', severity: 'error', code: 'field' },
    { path: 'lines[0].devices[1].name', severity: 'warning', code: 'field' },
    { path: 'lines[1]', severity: 'note', code: 'field' },
    { path: 'servers[0]', severity: 'error', code: 'guarantee.late' },
  ]);
  assert.equal(worst.get('lines[0].devices[0]'), 'error');
  assert.equal(worst.get('lines[0].devices[1]'), 'warning');
  assert.equal(worst.get('lines[0]'), 'error');
  assert.equal(worst.get('lines[1]'), undefined);
  assert.equal(worst.get('servers[0]'), 'warning');
});
