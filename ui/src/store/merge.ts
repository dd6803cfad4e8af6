// Joins two edits of one document: those of this page, and those that another program or browser saved. Pure.
import type { Mapping, Node } from '../api/types';
import { asNew, formatPath, isMapping, type Path } from './document';

export interface Merged {
  document: Mapping;
  /** Values that both changed, each to another one. Those of this page are kept. */
  conflicts: string[];
}

type Part = Node | number | undefined;

const same = (a: Part, b: Part): boolean => {
  if (a === b) return true;
  if (Array.isArray(a) && Array.isArray(b))
    return a.length === b.length && a.every((its, i) => same(its, b[i]));
  if (!isMapping(a) || !isMapping(b)) return false;
  const keys = keysOf(a);
  return keys.length === keysOf(b).length && keys.every((key) => key in b && same(a[key], b[key]));
};
const keysOf = (node: Mapping) => Object.keys(node).filter((key) => key !== '$from');
const isList = (node: Part): node is Mapping[] => Array.isArray(node) && node.some(isMapping);

/** What an item is known by in its list. */
const identity = (item: Mapping): string =>
  String(item.name ?? item.address ?? item.id ?? item.area ?? JSON.stringify(asNew(item)));

/** The items of `theirs` that items of `base` became, by the index in `base`. */
function successors(base: Mapping[], theirs: Mapping[]): Map<number, Mapping> {
  const found = new Map<number, Mapping>();
  const left = new Set(theirs);
  for (const [i, item] of base.entries()) {
    const its = [...left].find((one) => identity(one) === identity(item));
    if (!its) continue;
    found.set(i, its);
    left.delete(its);
  }
  // Renamed: the same place in a list of the same length.
  if (base.length === theirs.length)
    for (const [i, its] of theirs.entries()) if (left.has(its) && !found.has(i)) found.set(i, its);
  return found;
}

class Merge {
  readonly conflicts: string[] = [];

  node(base: Part, mine: Part, theirs: Part, path: Path): Part {
    if (same(mine, base) || same(mine, theirs)) return theirs;
    if (same(theirs, base)) return withPlaces(mine, theirs);
    if (isMapping(mine) && isMapping(theirs))
      return this.mapping(isMapping(base) ? base : {}, mine, theirs, path);
    if (isList(mine) && isList(theirs)) return this.list(isList(base) ? base : [], mine, theirs, path);
    this.conflicts.push(formatPath(path));
    return mine === undefined ? undefined : (asNew(mine as Node) as Part);
  }

  private mapping(base: Mapping, mine: Mapping, theirs: Mapping, path: Path): Mapping {
    const result: Mapping = {};
    // The order of the file, then what is new here.
    for (const key of new Set([...keysOf(theirs), ...keysOf(mine)])) {
      const its = this.node(base[key], mine[key], theirs[key], [...path, key]);
      if (its !== undefined) result[key] = its as Node;
    }
    if (theirs.$from !== undefined) result.$from = theirs.$from;
    return result;
  }

  private list(base: Mapping[], mine: Mapping[], theirs: Mapping[], path: Path): Mapping[] {
    const became = successors(base, theirs);
    const known = new Set(became.values());
    const result: Mapping[] = [];
    // The order of this page; what is new in the file comes after the item that it follows there.
    for (const item of mine) {
      const from = typeof item.$from === 'number' ? item.$from : -1;
      const before = base[from];
      const after = became.get(from);
      if (!before) result.push(asNew(item) as Mapping);
      else if (after) result.push(this.node(before, item, after, [...path, result.length]) as Mapping);
      // It was removed in the file: it stays only if it was changed here.
      else if (!same(item, before)) result.push(asNew(item) as Mapping);
    }
    for (const [i, its] of theirs.entries()) {
      if (known.has(its)) continue;
      const previous = theirs[i - 1];
      const place = previous ? result.findIndex((one) => one.$from === previous.$from) : -1;
      result.splice(place < 0 && i > 0 ? result.length : place + 1, 0, its);
    }
    return result;
  }
}

/** A node of this page with the places that its items have in the new file. */
function withPlaces(mine: Part, theirs: Part): Part {
  if (isList(mine)) {
    const items = isList(theirs) ? theirs : [];
    // `theirs` has the same items as the base: the places are the same.
    return mine.map((item) => {
      const place = typeof item.$from === 'number' ? items[item.$from] : undefined;
      return place ? (withPlaces(item, place) as Mapping) : (asNew(item) as Mapping);
    });
  }
  if (!isMapping(mine)) return mine;
  const other = isMapping(theirs) ? theirs : {};
  const result: Mapping = {};
  for (const key of keysOf(mine)) result[key] = withPlaces(mine[key], other[key]) as Node;
  if (other.$from !== undefined) result.$from = other.$from;
  return result;
}

/**
 * @param base    the file as this page loaded it
 * @param mine    the same with the edits of this page
 * @param theirs  the file as it is now
 */
export function merged(base: Mapping, mine: Mapping, theirs: Mapping): Merged {
  const merge = new Merge();
  const document = merge.node(base, mine, theirs, []) as Mapping;
  return { document, conflicts: merge.conflicts };
}

/** A document of before, whose items have their places in the file as it is now. */
export function rebased(old: Mapping, file: Mapping): Mapping {
  return placed(old, file) as Mapping;
}

function placed(old: Part, file: Part): Part {
  if (isList(old)) {
    const items = isList(file) ? file : [];
    const became = successors(old, items);
    return old.map((item, i) => {
      const its = became.get(i);
      return its ? { ...(placed(item, its) as Mapping), $from: items.indexOf(its) } : asNew(item);
    }) as Node;
  }
  if (!isMapping(old)) return old;
  const there = isMapping(file) ? file : {};
  return Object.fromEntries(keysOf(old).map((key) => [key, placed(old[key], there[key])])) as Mapping;
}
