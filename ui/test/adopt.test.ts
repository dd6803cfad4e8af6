// Found devices in the draft.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { FoundDevice, Mapping, ProbedDevice } from '../src/api/types';
import { draftDevice, withFound, withProbed } from '../src/views/devices/adopt';

const found = (its: Partial<FoundDevice>): FoundDevice => ({
  target: 'tcp://10.0.0.5:502',
  unit: 7,
  identity: '',
  response_ms: 1,
  exception: null,
  garbled: false,
  doubled: false,
  line: null,
  known_as: null,
  line_node: { name: 'line 1', transport: 'tcp', host: '10.0.0.5', tcp_port: '502' },
  device_node: { name: 'unit 7', address: '7', variables: [{ name: 'a' }, { name: 'b' }] },
  ...its,
});
const project: Mapping = {
  locals: [{ name: 'b' }],
  lines: [
    { name: 'line 1', devices: [{ $from: 0, name: 'unit 7', address: '1', variables: [{ name: 'a' }] }] },
  ],
};

test('a device of a new host gets a line, and names that no other one has', () => {
  const next = withFound(project, found({}))!;
  const line = (next.lines as Mapping[])[1]!;
  assert.equal(line.name, 'line 2');
  assert.equal(line.host, '10.0.0.5');
  assert.deepEqual(line.devices, [
    { name: 'unit 2', address: '7', variables: [{ name: 'a 2' }, { name: 'b 2' }] },
  ]);
  assert.equal((project.lines as Mapping[]).length, 1, 'the draft before is kept for undo');
});

test('a device of a line of the project goes into that line, once', () => {
  const its = found({ line: 'line 1', line_node: null });
  const next = withFound(project, its)!;
  assert.equal(((next.lines as Mapping[])[0]!.devices as Mapping[]).length, 2);
  assert.equal(draftDevice(next, its)?.address, '7');
  assert.equal(withFound(next, its), undefined);
});

test('a second device of the same new host goes into its line', () => {
  const next = withFound(
    withFound(project, found({}))!,
    found({ unit: 8, device_node: { name: 'unit 8', address: '8' } }),
  )!;
  assert.equal((next.lines as Mapping[]).length, 2);
  assert.equal(((next.lines as Mapping[])[1]!.devices as Mapping[]).length, 2);
});

test('a probe changes its keys of a device only', () => {
  const probed = {
    line: 'line 1',
    known_as: 'unit 7',
    keys: { readable: { holding_register: '[0..9]' }, registers_per_request: '10' },
  } as unknown as ProbedDevice;
  const device = ((withProbed(project, probed)!.lines as Mapping[])[0]!.devices as Mapping[])[0]!;
  assert.deepEqual(device.readable, { holding_register: '[0..9]' });
  assert.equal(device.address, '1');
  assert.equal(device.$from, 0);
  assert.equal(withProbed(project, { ...probed, known_as: 'other' }), undefined);
});
