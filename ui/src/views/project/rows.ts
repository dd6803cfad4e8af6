// What the tables do with their rows: pure functions on the list of a document.
import type { Cells, Mapping } from '../../api/types';
import { asNew } from '../../store/document';
import { type CellKind, cellText, plainType, rawOf } from './cells';

export interface CellColumn {
  key: string;
  kind: CellKind;
}

/** "Var1" → "Var2", "Pump" → "Pump 2": the next name that is free. */
export function nextName(name: string, taken: Set<string>): string {
  const match = /^(.*?)(\d+)$/.exec(name);
  const [stem, digits] = match ? [match[1]!, match[2]!] : [`${name} `, '1'];
  let n = Number(digits);
  let next = name;
  do {
    ++n;
    next = stem + String(n).padStart(digits.length, '0');
  } while (taken.has(next));
  return next;
}

/** How many registers, or coils, a variable takes. */
export function sizeOf(row: Mapping): number {
  const type = plainType(String(row.type ?? ''));
  if (type === 'string') return Math.max(1, Number(row.length) || 1);
  if (/64$|^double$/.test(type)) return 4;
  return /32$|^float$/.test(type) ? 2 : 1;
}

/** A decimal or hexadecimal number of the file; null for other texts. */
export const numberOf = (text: unknown) => {
  const its = typeof text === 'string' ? text.trim() : '';
  return /^(\d+|0x[0-9a-f]+)$/i.test(its) ? Number(its) : null;
};
const sameNotation = (like: unknown, value: number) =>
  typeof like === 'string' && /^0x/i.test(like) ? `0x${value.toString(16).toUpperCase()}` : String(value);

/** The address after a row, in the key that it uses: register, register and bit, coil or reference. */
export function nextAddress(row: Mapping): Mapping {
  const [register, bit, coil, reference] = [row.register, row.bit, row.coil, row.reference].map(numberOf);
  if (coil !== null && coil !== undefined) return { coil: sameNotation(row.coil, coil + 1) };
  if (reference !== null && reference !== undefined)
    return { reference: String(reference + sizeOf(row)).padStart(String(row.reference).length, '0') };
  if (register === null || register === undefined) return {};
  if (plainType(String(row.type)) === 'bool' && bit !== null && bit !== undefined)
    return bit < 15
      ? { register: row.register!, bit: String(bit + 1) }
      : { register: sameNotation(row.register, register + 1), bit: '0' };
  return { register: sameNotation(row.register, register + sizeOf(row)) };
}

export function namesIn(rows: Mapping[]): Set<string> {
  return new Set(rows.map((its) => its.name).filter((its): its is string => typeof its === 'string'));
}

/** A new row after another one: the same settings, the next name, the next address. */
export function rowAfter(last: Mapping | undefined, first: Mapping, taken: Set<string>): Mapping {
  if (!last) {
    const name = String(first.name);
    return { ...first, name: taken.has(name) ? nextName(name, taken) : name };
  }
  const { comment: _, status: _status, default: _default, ...kept } = asNew(last) as Mapping;
  return { ...kept, name: nextName(String(last.name ?? first.name), taken), ...nextAddress(last) };
}

/** Copies of some rows, after the last of them. */
export function duplicated(list: Mapping[], indices: number[], taken: Set<string>): Mapping[] {
  const names = new Set(taken);
  const copies = indices.map((index) => {
    const row = asNew(list[index]!) as Mapping;
    if (typeof row.name === 'string') row.name = nextName(row.name, names);
    names.add(String(row.name));
    return row;
  });
  const after = Math.max(...indices) + 1;
  return [...list.slice(0, after), ...copies, ...list.slice(after)];
}

export const without = (list: Mapping[], indices: number[]): Mapping[] => {
  const gone = new Set(indices);
  return list.filter((_, index) => !gone.has(index));
};

/** The cells of a row, in the words of the file, in place of those of some columns. */
function withRow(row: Mapping, columns: CellColumn[], cells: Cells): Mapping {
  const next = { ...row };
  for (const { key, kind } of columns) {
    if (kind === 'source') continue;
    const raw = rawOf(kind, cells[key] ?? '');
    if (raw === undefined) delete next[key];
    else next[key] = raw;
  }
  return next;
}

export function withCells(
  list: Mapping[],
  indices: number[],
  columns: CellColumn[],
  cells: Cells,
): Mapping[] {
  const next = [...list];
  for (const index of indices) next[index] = withRow(next[index]!, columns, cells);
  return next;
}

/** The first row's cells into the rows below. Names are counted on, and addresses go on. */
export function filledDown(
  list: Mapping[],
  indices: number[],
  columns: CellColumn[],
  taken: Set<string>,
): Mapping[] {
  const [first, ...below] = indices;
  if (first === undefined) return list;
  const next = [...list];
  const names = new Set(taken);
  let above = next[first]!;
  for (const index of below) {
    let row = { ...next[index]! };
    for (const { key } of columns) {
      if (key === 'name') {
        names.delete(String(row.name));
        row.name = nextName(String(above.name ?? ''), names);
        names.add(String(row.name));
      } else if (key === 'register' || key === 'coil' || key === 'reference') {
        const address = nextAddress(above);
        if (address[key] !== undefined) row[key] = address[key];
        if (key === 'register' && address.bit !== undefined) row.bit = address.bit;
      } else if (key === 'bit' && columns.some((its) => its.key === 'register')) {
        // The register has set it.
      } else if (above[key] === undefined) {
        const { [key]: _, ...rest } = row;
        row = rest;
      } else {
        row[key] = asNew(above[key] as never) as never;
      }
    }
    next[index] = row;
    above = row;
  }
  return next;
}

/** A pasted row, as the program reads it. */
export interface PastedRow {
  cells: Cells | null; // null: the IDE's empty choice
  columns: CellColumn[];
}

/**
 * A pasted table, from a row down. Rows that are missing are made; those of the IDE's empty choice are left
 * out.
 * @param order  the rows as they are shown, as indices of the list
 * @param fresh  makes a row for the end of the list
 */
export function pasted(
  list: Mapping[],
  order: number[],
  read: PastedRow[],
  start: number,
  fresh: (list: Mapping[]) => Mapping,
): Mapping[] {
  const next = [...list];
  const kept = read.filter((its) => its.cells !== null);
  for (const [r, { cells, columns }] of kept.entries()) {
    const index = order[start + r] ?? next.length;
    next[index] = withRow(next[index] ?? fresh(next), columns, cells!);
  }
  return next;
}

export function copied(list: Mapping[], indices: number[], columns: CellColumn[]): string[][] {
  return indices.map((index) => columns.map(({ key, kind }) => cellText(list[index]!, key, kind)));
}

const collator = new Intl.Collator(undefined, { numeric: true });
/** The rows to show, as indices of the list: filtered by a text, sorted by a column. */
export function ordered(
  list: Mapping[],
  filter: string,
  sort: { key: string; down: boolean } | null,
  columns: CellColumn[],
): number[] {
  const wanted = filter.trim().toLowerCase();
  let order = list.map((_, index) => index);
  if (wanted)
    order = order.filter((index) =>
      columns.some(({ key, kind }) => cellText(list[index]!, key, kind).toLowerCase().includes(wanted)),
    );
  const by = sort && columns.find((its) => its.key === sort.key);
  if (by) {
    const texts = new Map(order.map((index) => [index, cellText(list[index]!, by.key, by.kind)]));
    order.sort((a, b) => collator.compare(texts.get(a)!, texts.get(b)!) * (sort.down ? -1 : 1) || a - b);
  }
  return order;
}
