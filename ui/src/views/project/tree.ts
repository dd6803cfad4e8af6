// The tree of a project: lines with their devices as masters, servers with their units as slaves. Pure.
import type { Mapping, Node } from '../../api/types';
import { formatPath, isMapping, listAt, type Path, parsePath } from '../../store/document';

export type TreeKind = 'project' | 'line' | 'device' | 'locals' | 'server' | 'unit' | 'output' | 'instrument';

export interface TreeItem {
  kind: TreeKind;
  path: Path;
  id: string;
  level: number; // 1 for the roots
  name: string;
  /** Of lines and servers: RS485 or TCP, and the number of the slot. */
  medium: string;
  slot: number;
  count: number | null; // of variables
  children: boolean;
}

/** A connection to a host. */
export const isNetwork = (transport: string) => transport === 'tcp' || transport === 'tls';

export function transportOf(line: Mapping): string {
  if (typeof line.transport === 'string') return line.transport;
  return line.host !== undefined && line.port === undefined ? 'tcp' : 'serial';
}
export function framingOf(line: Mapping): string {
  if (typeof line.framing === 'string') return line.framing;
  return isNetwork(transportOf(line)) ? 'tcp' : 'rtu';
}
export const serverTransportOf = (server: Mapping): string =>
  typeof server.transport === 'string' ? server.transport : server.port === undefined ? 'tcp' : 'serial';

/** The word of a simulated line is translated where it is shown. */
const medium = (transport: string) =>
  transport === 'simulated' ? transport : isNetwork(transport) ? 'TCP' : 'RS485';
const textOf = (node: Node | number | undefined) => (typeof node === 'string' ? node : '');

/** All items in the order they are shown. `isOpen` says whether the children of an item are shown. */
export function treeOf(document: Mapping, isOpen: (id: string) => boolean): TreeItem[] {
  const items: TreeItem[] = [];
  const add = (kind: TreeKind, path: Path, level: number, rest: Partial<TreeItem> = {}) => {
    items.push({
      kind,
      path,
      level,
      id: formatPath(path) || 'project',
      name: '',
      medium: '',
      slot: 0,
      count: null,
      children: false,
      ...rest,
    });
  };
  const lines = listAt(document, ['lines']);
  add('project', [], 1);
  for (const [i, line] of lines.entries()) {
    if (!isMapping(line)) continue;
    const path: Path = ['lines', i];
    const devices = listAt(line, ['devices']);
    add('line', path, 1, {
      name: textOf(line.name),
      medium: medium(transportOf(line)),
      slot: i + 1,
      children: devices.length > 0,
    });
    if (!isOpen(formatPath(path))) continue;
    for (const [j, device] of devices.entries())
      add('device', [...path, 'devices', j], 2, {
        name: [textOf(device?.name), textOf(device?.address)].filter((its) => its !== '').join(', '),
        count: Array.isArray(device?.variables) ? device.variables.length : null,
      });
  }
  add('locals', ['locals'], 1, { count: listAt(document, ['locals']).length });
  for (const [i, server] of listAt(document, ['servers']).entries()) {
    const path: Path = ['servers', i];
    const units = listAt(server, ['units']);
    add('server', path, 1, {
      name: textOf(server?.name),
      medium: medium(serverTransportOf(server)),
      slot: lines.length + i + 1,
      children: units.length > 0,
    });
    if (!isOpen(formatPath(path))) continue;
    for (const [j, unit] of units.entries())
      add('unit', [...path, 'units', j], 2, {
        name: textOf(unit?.address),
        count: Array.isArray(unit?.variables) ? unit.variables.length : null,
      });
  }
  for (const [i, its] of listAt(document, ['instruments']).entries())
    add('instrument', ['instruments', i], 1, { name: textOf(its?.name) });
  for (const [i, its] of listAt(document, ['outputs']).entries())
    add('output', ['outputs', i], 1, { name: textOf(its?.name) });
  return items;
}

const ITEM =
  /^(lines\[\d+\](\.devices\[\d+\])?|locals|servers\[\d+\](\.units\[\d+\])?|(instruments|outputs)\[\d+\])/;
/** The item of the tree that a path of a finding belongs to. */
export function itemPath(path: string): Path {
  const match = ITEM.exec(path);
  return match ? parsePath(match[0]) : [];
}

export type Severity = 'error' | 'warning';
interface Judged {
  path: string;
  severity: string;
  code: string;
}
/** A deadline that does not hold is no wrong value: the project runs, and can be saved. */
export const isLate = (its: { code: string }) => its.code.startsWith('guarantee.');
/** How a finding is marked; null: not at all. */
export function markOf(its: Judged): Severity | null {
  if (its.severity === 'error') return isLate(its) ? 'warning' : 'error';
  return its.severity === 'warning' ? 'warning' : null;
}
/** For each path and all paths above it the worst severity of its findings. Notes do not count. */
export function severities(findings: Judged[]): Map<string, Severity> {
  const worst = new Map<string, Severity>();
  for (const its of findings) {
    const severity = markOf(its);
    if (severity === null) continue;
    const steps = parsePath(its.path);
    for (let length = steps.length; length >= 0; --length) {
      const key = formatPath(steps.slice(0, length));
      if (worst.get(key) === 'error') break;
      worst.set(key, severity);
    }
  }
  return worst;
}
