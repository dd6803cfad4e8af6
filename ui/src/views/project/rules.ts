// The permitted ranges of fields, from the table that the messages of the program use too (/fields).
import { signal } from '@preact/signals';
import { ApiError, get } from '../../api/client';
import type { FieldRule, FieldTable, Mapping } from '../../api/types';
import { formatDuration, formatNumber, t } from '../../i18n';
import { at, isMapping, type Path, textAt } from '../../store/document';
import { draft } from '../../store/project';
import { milliseconds } from './cells';
import { framingOf, isNetwork, serverTransportOf, transportOf } from './tree';

const tables = signal<Record<string, FieldTable>>({});
const asked = new Set<string>();

function tableFor(profile: string, transport: string, framing: string): FieldTable {
  const key = `${profile} ${transport} ${framing}`;
  if (!asked.has(key)) {
    asked.add(key);
    get<{ objects: FieldTable }>('fields', { profile, transport, framing })
      .then((answer) => {
        tables.value = { ...tables.peek(), [key]: answer.objects };
      })
      .catch((error) => {
        // A word of the draft is none: the ranges of the usual words are shown.
        if (error instanceof ApiError && error.status === 400) tableFor('generic', 'serial', 'rtu');
        else asked.delete(key);
      });
  }
  const all = tables.value;
  // Until the ranges of a new protocol are here, those of another one have the same keys.
  return all[key] ?? Object.values(all)[0] ?? {};
}

export const profileOf = (document: Mapping): string => textAt(document, ['profile']) ?? 'generic';

/** The rules of an object of the draft: those of the line or server that it belongs to. */
export function rulesAt(path: Path, object: string): Record<string, FieldRule> {
  const document = draft.value;
  const owner = at(document, path.slice(0, 2));
  let [transport, framing] = ['serial', 'rtu'];
  if (path[0] === 'lines' && isMapping(owner)) [transport, framing] = [transportOf(owner), framingOf(owner)];
  if (path[0] === 'servers' && isMapping(owner)) {
    transport = serverTransportOf(owner);
    framing = textAt(owner, ['framing']) ?? (isNetwork(transport) ? 'tcp' : 'rtu');
  }
  return tableFor(profileOf(document), transport, framing)[object] ?? {};
}

const UNITS = { s: 1000, min: 60_000, h: 3_600_000, d: 86_400_000 } as const;
/** Milliseconds as a number, or with a longer unit where they would be hard to read. */
export function boundText(ms: number): string {
  const u = t.value.units;
  for (const unit of ['d', 'h', 'min'] as const)
    if (ms >= (unit === 'd' ? 2 : 1) * UNITS[unit] && ms % UNITS[unit] === 0 && ms > 65_535)
      return `${formatNumber(ms / UNITS[unit])} ${unit === 'd' ? t.value.project.days : u[unit]}`;
  return String(ms);
}

/** The permitted range for people: "1…247", "1…65535", "0…24 h". */
export function rangeText(rule: FieldRule | undefined): string {
  if (!rule || rule.kind === 'boolean' || rule.kind === 'word' || rule.kind === 'function') return '';
  const match = /^(-?[\w.]+?)\.\.(-?[\w.]+)/.exec(rule.allowed);
  if (!match) return '';
  if (rule.kind !== 'duration') {
    // More than the frame carries is cut: the limit of the frame is what people need to see.
    const most = rule.greatest !== undefined && rule.kind === 'integer' ? String(rule.greatest) : match[2]!;
    return `${match[1]}…${most}`;
  }
  const bounds = [match[1], match[2]].map((its) => milliseconds(its));
  // "1..65535ms": the unit of the second bound counts for both.
  const [least, most] = bounds;
  if (least === null || least === undefined || most === null || most === undefined) return rule.allowed;
  const words = boundText(most);
  // Both ends with their units, if one of them has one: "1 s…24 h".
  return words === String(most) || least === 0
    ? `${boundText(least)}…${words}`
    : `${formatDuration(least)}…${words}`;
}

/** A word of the file for people. */
export const wordText = (word: string): string => (t.value.words as Record<string, string>)[word] ?? word;
/** @param object  whose key it is, if some objects have another meaning for it */
export const keyText = (key: string, object = ''): string =>
  (t.value.objectKeys as Record<string, string>)[`${object}.${key}`] ??
  (t.value.keys as Record<string, string>)[key] ??
  key;

/** Objects whose keys mean what those of a project, line, device or variable mean. */
const EXPLAINED = ['project', 'line', 'server', 'device', 'variable', 'local', 'served_variable'];
/** What a key means; undefined: its name says it. */
export function hintText(key: string, object: string): string | undefined {
  const hints: Record<string, string> = t.value.hints;
  return hints[`${object}.${key}`] ?? (EXPLAINED.includes(object) ? hints[key] : undefined);
}
