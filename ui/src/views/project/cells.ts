// The cells of the tables: the kinds of their values, and their texts. Pure.
import type { Mapping, Node } from '../../api/types';
import { isMapping } from '../../store/document';

export type CellKind =
  | 'text'
  | 'number'
  | 'duration'
  | 'boolean'
  | 'type'
  | 'function'
  | 'word'
  | 'local'
  | 'source'
  | 'list'
  | 'words';

export const TYPES = [
  'bool',
  'int16',
  'uint16',
  'int32',
  'uint32',
  'int64',
  'uint64',
  'float',
  'double',
  'string',
];
const ALIASES: Record<string, string> = { int: 'int16', real: 'float' };
export const plainType = (type: string) => ALIASES[type] ?? type;

export const typeClass = (type: string | undefined): string => {
  const its = plainType(type ?? '');
  if (its === 'bool') return 'type-bool';
  if (its === 'float' || its === 'double') return 'type-float';
  return its === 'string' ? 'type-string' : its ? 'type-int' : '';
};

export function isYes(raw: string | null | undefined): boolean {
  return raw?.toLowerCase() === 'true';
}

/** The raw text for the file from what was typed. undefined: the key is left out. */
export function rawOf(kind: CellKind, typed: string): Node | undefined {
  const text = typed.trim();
  if (text === '') return undefined;
  switch (kind) {
    case 'number':
      return /^[-+]?\d+,\d+$/.test(text) ? text.replace(',', '.') : text;
    case 'duration':
      return durationFrom(text);
    case 'list':
      return listFrom(text);
    case 'words':
      return wordsFrom(text);
    default:
      return text;
  }
}

/** A plain number is milliseconds. */
export function durationFrom(text: string): string {
  const its = text.trim().replace(',', '.');
  return /^\d+(\.\d+)?$/.test(its) ? `${its}ms` : text.trim();
}

const UNITS: Record<string, number> = {
  ns: 1e-6,
  us: 1e-3,
  ms: 1,
  s: 1000,
  min: 60_000,
  h: 3_600_000,
  d: 86_400_000,
};
/** Milliseconds of "100ms", "1s"; null: it is no duration. */
export function milliseconds(raw: string | undefined): number | null {
  const match = /^\s*(\d+(?:\.\d+)?)\s*(ns|us|µs|ms|s|min|h|d)?\s*$/.exec(raw ?? '');
  if (!match) return null;
  const unit = UNITS[(match[2] ?? 'ms').replace('µ', 'u')];
  return unit === undefined ? null : Number((Number(match[1]) * unit).toPrecision(12));
}
/** A duration as the number of milliseconds that a form shows. */
export function durationText(raw: string): string {
  const ms = milliseconds(raw);
  return ms === null ? raw : String(ms);
}

function listFrom(text: string): Node {
  const items = text
    .split(',')
    .map((its) => its.trim())
    .filter((its) => its !== '');
  // `retain: true` of a bank holds for all of its items.
  return items.length === 1 && /^(true|false)$/.test(items[0]!) ? items[0]! : items;
}

function wordsFrom(text: string): Node {
  const pairs = text.split(',').map((its) => /^\s*(.+?)\s*[=:]\s*(.*?)\s*$/.exec(its));
  if (pairs.some((pair) => pair === null)) return text;
  return Object.fromEntries(pairs.map((pair) => [pair![1]!, pair![2]!]));
}

/** Any node as one line of text: lists with commas, mappings as key=value. */
export function nodeText(node: Node | number | undefined): string {
  if (node === null || node === undefined) return '';
  if (typeof node !== 'object') return String(node);
  if (Array.isArray(node))
    return node
      .map((its) => (Array.isArray(its) && its.length === 2 ? its.map(nodeText).join('..') : nodeText(its)))
      .join(', ');
  return Object.entries(node)
    .filter(([key]) => key !== '$from')
    .map(([key, value]) => `${key}=${nodeText(value as Node)}`)
    .join(', ');
}

/** A cell as it is edited and copied. */
export function cellText(row: Mapping, key: string, kind: CellKind): string {
  const node = row[key];
  if (kind === 'source') return sourceText(node as Node | undefined);
  const text = nodeText(node);
  return kind === 'duration' ? durationText(text) : text;
}

/** "variable: Level" of a source or destination. */
export function sourceText(node: Node | undefined): string {
  if (!isMapping(node)) return nodeText(node);
  const [kind, value] = Object.entries(node).find(([key]) => key !== '$from') ?? [];
  return kind ? `${kind}: ${nodeText(value as Node)}` : '';
}
