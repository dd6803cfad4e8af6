// What a search found as parts of the project document. Pure.
import type { FoundDevice, Mapping, Node, ProbedDevice } from '../../api/types';
import { asNew, freeName, isMapping, listAt, withNode } from '../../store/document';

const names = (list: Mapping[]) => list.map((its) => String(its.name ?? ''));

/** Every name of a value: a variable is known by its name in the whole project. */
function valueNames(document: Node): Set<string> {
  const all = names(listAt(document, ['locals']));
  for (const line of listAt(document, ['lines']))
    for (const device of listAt(line, ['devices'])) all.push(...names(listAt(device, ['variables'])));
  return new Set(all);
}

/** The line of the document that a found device is on; -1: it has none yet. */
export function lineIndex(document: Node, found: FoundDevice): number {
  const lines = listAt(document, ['lines']);
  if (found.line !== null) return lines.findIndex((its) => its.name === found.line);
  const node = found.line_node;
  if (!node) return -1;
  const same = (its: Mapping, key: string) => (its[key] ?? '') === (node[key] ?? '');
  return lines.findIndex((its) => ['transport', 'host', 'port', 'tcp_port'].every((key) => same(its, key)));
}

/** The device of the document at the address of a found one. */
export function draftDevice(document: Node, found: FoundDevice): Mapping | undefined {
  const line = lineIndex(document, found);
  if (line < 0) return undefined;
  return listAt(document, ['lines', line, 'devices']).find((its) => Number(its.address) === found.unit);
}

/** A device of the document with names that no other one has. */
function named(node: Mapping, taken: Set<string>, values: Set<string>, wanted: string): Mapping {
  const device = asNew(node) as Mapping;
  device.name = freeName(wanted || String(device.name), taken);
  if (Array.isArray(device.variables))
    device.variables = (device.variables as Mapping[]).map((its) => {
      const name = freeName(String(its.name), values);
      values.add(name);
      return { ...its, name };
    });
  return device;
}

/** @returns the document with the device; undefined: it cannot be added */
export function withFound(document: Mapping, found: FoundDevice): Mapping | undefined {
  if (!found.device_node || draftDevice(document, found)) return undefined;
  const lines = listAt(document, ['lines']);
  const index = lineIndex(document, found);
  const taken = new Set(lines.flatMap((its) => names(listAt(its, ['devices']))));
  const device = named(found.device_node, taken, valueNames(document), '');
  if (index >= 0) {
    const devices = listAt(document, ['lines', index, 'devices']);
    return withNode(document, ['lines', index, 'devices', devices.length], device) as Mapping;
  }
  if (!found.line_node) return undefined;
  const line = {
    ...(asNew(found.line_node) as Mapping),
    name: freeName(String(found.line_node.name), new Set(names(lines))),
    devices: [device],
  };
  return withNode(document, ['lines', lines.length], line) as Mapping;
}

/** Sets the keys that a probe gives a device: the ranges that can be read, and the longest request. */
export function withProbed(document: Mapping, probed: ProbedDevice): Mapping | undefined {
  const lines = listAt(document, ['lines']);
  for (const [l, line] of lines.entries())
    for (const [d, device] of listAt(line, ['devices']).entries())
      if (line.name === probed.line && device.name === probed.known_as && isMapping(device))
        return withNode(document, ['lines', l, 'devices', d], {
          ...probedKeys(probed),
          ...device,
          ...probedKeys(probed),
        }) as Mapping;
  return undefined;
}
const probedKeys = (probed: ProbedDevice) => asNew(probed.keys) as Mapping;
