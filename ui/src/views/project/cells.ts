// The cells of the tables: the kinds of their values, and the words of IDE and spreadsheets for them. Pure.
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

const TYPE_WORDS: [RegExp, string][] = [
  [/^(бул|лог|boolean|bit|біт|бит)/, 'bool'],
  [/^(с плав|з плав|вещ|real|float)/, 'float'],
  [/^(цел|ціл|integer|word$|int$).*(2 рег|dword|32)/, 'int32'],
  [/^(цел|ціл|integer|word$|int$)/, 'int16'],
  [/^(строк|рядок|рядк|text|string)/, 'string'],
];
const YES = /^(true|yes|on|1|да|так|вкл|☑|☒|✓|✔|x)$/i;
const NO = /^(false|no|off|0|нет|ні|выкл|☐)$/i;
/** The IDE's empty choice, in any brackets, also cut. */
const PLACEHOLDER = /^[‹<«(]?\s*(не выб|не виб|none chosen|not chosen)[^›>»)]*(…|\.\.\.)?\s*[›>»)]?$/i;

export const isPlaceholder = (text: string) => PLACEHOLDER.test(text.trim());

export function isYes(raw: string | null | undefined): boolean {
  return raw !== null && raw !== undefined && YES.test(raw.trim());
}

/** "0x03" of "3", "03 (0x03) Read Holding Registers", "0x3"; undefined: it is no function. */
export function functionOf(text: string): string | undefined {
  const its = text.trim();
  if (/^(none|нет|ні|no|-|–|—)$/i.test(its)) return 'none';
  const inside = /0x([0-9a-f]{1,2})\b/i.exec(its)?.[1];
  const number = inside ? Number.parseInt(inside, 16) : /^\d{1,2}$/.test(its) ? Number(its) : Number.NaN;
  if (Number.isNaN(number)) return undefined;
  return `0x${number.toString(16).toUpperCase().padStart(2, '0')}`;
}

function typeOf(text: string): string {
  const its = text.trim().toLowerCase();
  if (TYPES.includes(its) || ALIASES[its]) return its;
  return TYPE_WORDS.find(([pattern]) => pattern.test(its))?.[1] ?? text.trim();
}

/**
 * The raw text for the file from what was typed or pasted. undefined: the key is left out. Texts that are not
 * understood stay as they are, so that the check names them.
 */
export function rawOf(kind: CellKind, typed: string): Node | undefined {
  const text = typed.trim();
  if (text === '' || isPlaceholder(text)) return undefined;
  switch (kind) {
    case 'boolean':
      return YES.test(text) ? 'true' : NO.test(text) ? 'false' : text;
    case 'type':
      return typeOf(text);
    case 'function':
      return functionOf(text) ?? text;
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
