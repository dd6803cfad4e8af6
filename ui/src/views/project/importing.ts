// A table that is pasted: into which part of the project its rows go.
import { signal } from '@preact/signals';
import type { Cells, ImportedRow, ImportedRows, Mapping, Node } from '../../api/types';
import { formatPath, freeName, listAt, type Path, textAt } from '../../store/document';
import { rawOf } from './cells';
import { COLUMNS, type TableObject } from './columns';
import { namesIn } from './rows';
import { isNetwork, transportOf } from './tree';

/** The import dialog: the text so far and the table where it was pasted; null: it is closed. */
export const importing = signal<{ text: string; path: Path | null } | null>(null);

export interface Target {
  path: Path;
  title: string;
  object: TableObject;
  /** The line, or the device, that is made first. */
  makes?: 'line' | 'device' | 'server';
}

/** How a new line is connected. */
export interface Connection {
  transport: 'serial' | 'tcp' | 'simulated';
  port: string;
  host: string;
  tcp_port: string;
}

/** The tables of a project that take rows of a kind. */
export function targetsFor(
  document: Mapping,
  kind: ImportedRows['kind'],
  names: { locals: string; devices: string },
): Target[] {
  if (kind === 'locals') return [{ path: ['locals'], title: names.locals, object: 'local' }];
  const lines = listAt(document, ['lines']);
  const named = (node: Mapping) => textAt(node, ['name']) ?? '';
  if (kind === 'devices')
    return lines.map((line, i) => ({
      path: ['lines', i, 'devices'],
      title: `${named(line)}: ${names.devices}`,
      object: 'variable',
    }));
  if (kind === 'served')
    return listAt(document, ['servers']).flatMap((server, i) =>
      listAt(server, ['units']).map((unit, j) => ({
        path: ['servers', i, 'units', j, 'variables'],
        title: `${named(server)}, ${textAt(unit, ['address']) ?? ''}`,
        object: 'served_variable' as const,
      })),
    );
  return lines.flatMap((line, i) =>
    listAt(line, ['devices'])
      .map((device, j) => ({
        path: ['lines', i, 'devices', j, 'variables'] as Path,
        title: `${named(line)}: ${named(device)}, ${textAt(device, ['address']) ?? ''}`,
        object: 'variable' as const,
        table: device.variables,
      }))
      .filter((its) => typeof its.table !== 'string')
      .map(({ table: _, ...its }) => its),
  );
}

/** What a table can be put into besides: a new device of each line and a new line, or a new server. */
export function newTargets(
  document: Mapping,
  kind: ImportedRows['kind'],
  names: { device: (line: string) => string; line: string; server: string },
): Target[] {
  if (kind === 'locals') return [];
  if (kind === 'served') {
    const path: Path = ['servers', listAt(document, ['servers']).length, 'units', 0, 'variables'];
    return [{ path, title: names.server, makes: 'server', object: 'served_variable' }];
  }
  const lines = listAt(document, ['lines']);
  const made = (path: Path, title: string, makes: 'line' | 'device'): Target => ({
    path,
    title,
    makes,
    object: 'variable',
  });
  const line: Path = ['lines', lines.length, 'devices'];
  if (kind === 'devices') return [made(line, names.line, 'line')];
  const devices = lines.map((its, i) => {
    const path = ['lines', i, 'devices', listAt(its, ['devices']).length, 'variables'];
    return made(path, names.device(textAt(its, ['name']) ?? ''), 'device');
  });
  return [...devices, made([...line, 0, 'variables'], names.line, 'line')];
}

/** The line that a connection describes; undefined: its port or host is missing. */
export function lineOf(
  lines: Mapping[],
  its: Connection,
  names: { line: string; simulated: string },
): Mapping | undefined {
  const { transport } = its;
  const place = { serial: ['port'], tcp: ['host', 'tcp_port'], simulated: [] }[transport] as (
    | 'port'
    | 'host'
  )[];
  if (place[0] && its[place[0]].trim() === '') return undefined;
  return {
    name: freeName(transport === 'simulated' ? names.simulated : names.line, namesIn(lines)),
    transport,
    ...Object.fromEntries(place.map((key) => [key, its[key].trim()]).filter(([, text]) => text !== '')),
    devices: [],
  };
}

/** A server at a free port of this computer. */
export function serverOf(servers: Mapping[], name: string): Mapping {
  const used = new Set(servers.map((its) => Number(its.tcp_port)));
  let port = 1502;
  while (used.has(port)) ++port;
  return {
    name: freeName(name, namesIn(servers)),
    listen: '127.0.0.1',
    tcp_port: String(port),
    units: [{ address: '1', banks: [{ area: 'holding_register', items: ['0..99'] }], variables: [] }],
  };
}

/** A device with a free name and address. */
export function deviceOf(devices: Mapping[], name: string): Mapping {
  return { name: freeName(name, namesIn(devices)), address: freeAddress(devices), variables: [] };
}

/** The target where a table was pasted, else the one of that line, else the first one. */
export function targetAt(targets: Target[], path: Path | null): Target | undefined {
  const wanted = path === null ? '' : formatPath(path);
  const exact = targets.find((its) => formatPath(its.path) === wanted);
  return exact ?? targets.find((its) => wanted.startsWith(`${formatPath(its.path)}[`)) ?? targets[0];
}

/** The items of a list before an import. The window of a device takes the place of a new one. */
export function itemsBefore(list: Mapping[], kind: ImportedRows['kind'], path: Path | null): Mapping[] {
  if (kind !== 'devices' || path?.[2] !== 'devices') return list;
  const isNew = ({ name: _, address: __, variables, ...more }: Mapping) =>
    Object.keys(more).length === 0 && Array.isArray(variables) && variables.length === 0;
  return list.filter((its, i) => i !== path[3] || !isNew(its));
}

/** The variables below the window of a device. */
export function variablesOf(row: ImportedRow): Cells[] {
  return Array.isArray(row.variables) ? row.variables : [];
}

/** The next free address among devices. */
export function freeAddress(devices: { address?: unknown }[]): string {
  const used = new Set(devices.map((its) => Number(its.address)));
  let address = Math.max(0, ...[...used].filter((its) => its > 0 && its < 247)) + 1;
  while (used.has(address)) ++address;
  return String(address);
}

/** The windows of devices with the names and addresses that they lack. */
export function completed(rows: ImportedRow[], devices: Mapping[], name: string): ImportedRow[] {
  const all: { name?: Node | ImportedRow[string]; address?: unknown }[] = [...devices, ...rows];
  return rows.map((its) => {
    const row = { ...its };
    row.name ??= freeName(name, namesIn(all as Mapping[]));
    row.address ??= freeAddress(all);
    all.push(row);
    return row;
  });
}

/** The framing of the line that the windows of its devices call their protocol; undefined: none or TCP. */
export function framingIn(rows: ImportedRow[], line: Mapping): string | undefined {
  if (isNetwork(transportOf(line))) return undefined;
  const word = String(rows.find((its) => its.protocol)?.protocol ?? '').toLowerCase();
  return ['rtu', 'ascii'].find((its) => word.endsWith(its));
}

/** A row of the answer as an item of the document. */
export function itemOf(row: ImportedRow, object: TableObject): Mapping {
  const kinds = new Map(COLUMNS[object].map((its) => [its.key, its.kind]));
  const item: Mapping = {};
  for (const [key, text] of Object.entries(row)) {
    if (key === 'protocol') continue; // of the line
    if (typeof text !== 'string') {
      item[key] = text.map((its) => itemOf(its, 'variable'));
      continue;
    }
    // The program has understood the row: only lists and words are no texts in a document.
    const kind = kinds.get(key);
    const raw: Node | undefined = kind === 'words' || kind === 'list' ? rawOf(kind, text) : text;
    if (raw !== undefined && raw !== '') item[key] = raw;
  }
  return item;
}

/** The items of a list that an import overwrites or removes. */
export function replacedBy(list: Mapping[], items: Mapping[], replace: boolean, key: string): Mapping[] {
  const fresh = new Set(items.map((its) => its[key]));
  return list.filter((its) => replace || fresh.has(its[key]));
}

/**
 * The list with the imported items: rows with the same name are overwritten, or all are replaced.
 * @param key  of what is the same: every new device of an IDE has the same name
 */
export function merged(list: Mapping[], items: Mapping[], replace: boolean, key = 'name'): Mapping[] {
  const old = new Map(list.map((its) => [its[key], its]));
  if (replace)
    return items.map((its) => {
      const from = old.get(its[key])?.$from;
      return from === undefined ? its : { ...its, $from: from };
    });
  const fresh = new Map(items.map((its) => [its[key], its]));
  const kept = list.map((its) => {
    const next = fresh.get(its[key]);
    fresh.delete(its[key]);
    return next ? { ...its, ...next } : its;
  });
  return [...kept, ...fresh.values()];
}
