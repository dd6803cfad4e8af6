// Documents as the program sends them.
import type { Mapping, Node } from '../src/api/types';
import { isMapping } from '../src/store/document';

/** Each mapping of a list gets its place in it. */
export function asInFile(node: Mapping): Mapping {
  const placed = (its: Node): Node => {
    if (Array.isArray(its))
      return its.map((item, i) => (isMapping(item) ? { ...(placed(item) as Mapping), $from: i } : item));
    if (!isMapping(its)) return its;
    return Object.fromEntries(Object.entries(its).map(([key, value]) => [key, placed(value as Node)]));
  };
  return placed(node) as Mapping;
}
