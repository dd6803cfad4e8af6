// Changes of the draft that the forms, the tree and the tables make.
import type { Mapping, Node } from '../../api/types';
import {
  at,
  asNew,
  formatPath,
  freeName,
  isMapping,
  listAt,
  type Path,
  withNode,
} from '../../store/document';
import { change, draft, isReadOnlyPart, setNodes } from '../../store/project';
import { mayEdit } from '../../store/info';
import { deviceOf, serverOf } from './importing';
import { namesIn } from './rows';
import { select } from './selection';

/** Why a part cannot be changed: the file it comes from, or that the page is read-only; null: it can. */
export function readOnly(path: Path): string | true | null {
  return isReadOnlyPart(formatPath(path)) ?? (mayEdit.value ? null : true);
}

// Keys that name commands or files of the computer: the program refuses to add or change them.
const PROTECTED = new Set([
  'audit',
  'ca_file',
  'certificate_file',
  'directory',
  'key_file',
  'password_env',
  'password_file',
  'state',
]);
export const isProtected = (key: string) => PROTECTED.has(key);

// New keys go before the long lists, so that a file stays readable.
const LISTS = [
  'devices',
  'variables',
  'units',
  'banks',
  'select',
  'relay',
  'access',
  'exchanges',
  'commands',
];

export function withKey(mapping: Mapping, key: string, value: Node | undefined): Mapping {
  if (value === undefined || key in mapping) return withNode(mapping, [key], value) as Mapping;
  const entries = Object.entries(mapping);
  const before = entries.findIndex(([name]) => LISTS.includes(name) || name === '$from');
  entries.splice(before < 0 ? entries.length : before, 0, [key, value]);
  return Object.fromEntries(entries);
}

/** Sets keys of one object as one step; quick changes of the same keys are undone together. */
export function setKeys(path: Path, values: Record<string, Node | undefined>): void {
  const node = at(draft.peek(), path);
  const before: Mapping = isMapping(node) ? node : {};
  let next = before;
  for (const [key, value] of Object.entries(values))
    if (next[key] !== value) next = withKey(next, key, value);
  if (next === before) return;
  // A group of the project without keys, such as `host: {}`, is left out.
  const isEmpty = path.length === 1 && Object.keys(next).length === 0;
  change(
    withNode(draft.peek(), path, isEmpty ? undefined : next) as Mapping,
    `${formatPath(path)}/${Object.keys(values).join(' ')}`,
  );
}
export const setKey = (path: Path, key: string, value: Node | undefined) => setKeys(path, { [key]: value });

export function setList(path: Path, list: Mapping[], label: string): void {
  setNodes([{ path, value: list }], label);
}

/** The names of the variables and locals except those of some devices. */
export function namesWithout(devices: (Mapping | undefined)[]): Set<string> {
  const names = takenNames();
  for (const its of devices) for (const name of namesIn(listAt(its, ['variables']))) names.delete(name);
  return names;
}

/** The names of all variables and locals: they are unique in the project. */
export function takenNames(): Set<string> {
  const document = draft.peek();
  const names = namesIn(listAt(document, ['locals']));
  for (const line of listAt(document, ['lines']))
    for (const device of listAt(line, ['devices']))
      for (const name of namesIn(listAt(device, ['variables']))) names.add(name);
  return names;
}

function append(path: Path, item: Mapping, label: string): void {
  const list = listAt(draft.peek(), path);
  setNodes([{ path, value: [...list, item] }], label);
  select([...path, list.length]);
}

export function addLine(name: string): void {
  const lines = listAt(draft.peek(), ['lines']);
  append(['lines'], { name: freeName(name, namesIn(lines)), transport: 'simulated', devices: [] }, 'line');
}

export function addDevice(line: number, name: string): void {
  const path: Path = ['lines', line, 'devices'];
  append(path, deviceOf(listAt(draft.peek(), path), name), 'device');
}

export function addServer(name: string): void {
  append(['servers'], serverOf(listAt(draft.peek(), ['servers']), name), 'server');
}

/** A free name of lower-case letters, digits and hyphens, as outputs and instruments have. */
function freeWord(wanted: string, taken: Set<string>): string {
  let word = wanted;
  for (let n = 2; taken.has(word); ++n) word = `${wanted}-${n}`;
  return word;
}

/** The history first: a project has at most one, and it needs nothing else. */
export function addOutput(): void {
  const outputs = listAt(draft.peek(), ['outputs']);
  const its: Mapping = outputs.some((one) => one.transport === 'history')
    ? { name: freeWord('broker', namesIn(outputs)), transport: 'mqtt', brokers: ['mqtt://127.0.0.1'] }
    : { name: freeWord('history', namesIn(outputs)), transport: 'history' };
  append(['outputs'], its, 'output');
}

export function addInstrument(): void {
  const path: Path = ['instruments'];
  append(
    path,
    {
      name: freeWord('instrument', namesIn(listAt(draft.peek(), path))),
      port: '/dev/ttyUSB0',
      exchanges: [{ request: '?\\r', answer: { until: '\\r', pattern: '{value}' } }],
    },
    'instrument',
  );
}

export function addLocal(name: string, type: string): void {
  const list = listAt(draft.peek(), ['locals']);
  setNodes([{ path: ['locals'], value: [...list, { name, type }] }], 'local');
}

export function removeAt(path: Path): void {
  setNodes([{ path, value: undefined }], `remove ${formatPath(path)}`);
  const index = path.at(-1) as number;
  const list = listAt(draft.peek(), path.slice(0, -1));
  select(list.length > 0 ? [...path.slice(0, -1), Math.min(index, list.length - 1)] : path.slice(0, -2));
}

/** A copy after the item, with the next free name and address. Names of its variables are made unique too. */
export function duplicateAt(path: Path): void {
  const node = at(draft.peek(), path);
  if (!isMapping(node)) return;
  const listPath = path.slice(0, -1);
  const list = listAt(draft.peek(), listPath);
  const copy = asNew(node) as Mapping;
  copy.name = freeName(String(copy.name ?? ''), namesIn(list));
  if (typeof copy.address === 'string') {
    const used = new Set(list.map((its) => its.address));
    let address = Number(copy.address);
    while (used.has(String(address))) ++address;
    copy.address = String(address);
  }
  const taken = takenNames();
  for (const holder of [copy, ...listAt(copy, ['devices'])])
    for (const its of listAt(holder, ['variables'])) {
      its.name = freeName(String(its.name), taken);
      taken.add(its.name);
    }
  const index = (path.at(-1) as number) + 1;
  setNodes(
    [{ path: listPath, value: [...list.slice(0, index), copy, ...list.slice(index)] }],
    `duplicate ${formatPath(path)}`,
  );
  select([...listPath, index]);
}
