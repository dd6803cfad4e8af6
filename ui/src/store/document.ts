// Pure functions on the project document: reading, and changes that share what is unchanged.
import type { Mapping, Node } from '../api/types';

export type Path = (string | number)[];

/** "lines[0].devices[2].name" as its steps. */
export function parsePath(text: string): Path {
  return [...text.matchAll(/([^.[\]]+)|\[(\d+)\]/g)].map((m) => (m[2] === undefined ? m[1]! : Number(m[2])));
}
export function formatPath(path: Path): string {
  return path
    .map((step) => (typeof step === 'number' ? `[${step}]` : `.${step}`))
    .join('')
    .replace(/^\./, '');
}

export const isMapping = (node: unknown): node is Mapping =>
  typeof node === 'object' && node !== null && !Array.isArray(node);

export function at(node: Node | undefined, path: Path): Node | undefined {
  let its: Node | number | undefined = node;
  for (const step of path) {
    if (Array.isArray(its)) its = its[step as number];
    else if (isMapping(its)) its = its[step as string];
    else return undefined;
  }
  return its as Node | undefined;
}
export function textAt(node: Node | undefined, path: Path): string | undefined {
  const its = at(node, path);
  return typeof its === 'string' ? its : undefined;
}
export function listAt(node: Node | undefined, path: Path): Mapping[] {
  const its = at(node, path);
  return Array.isArray(its) ? (its as Mapping[]) : [];
}

/** Replaces the node at a path; undefined removes it. Missing mappings and lists on the way are made. */
export function withNode(node: Node | undefined, path: Path, value: Node | undefined): Node {
  const [step, ...rest] = path;
  if (step === undefined) return value ?? null;
  if (typeof step === 'number') {
    const list = Array.isArray(node) ? [...node] : [];
    if (rest.length === 0 && value === undefined) list.splice(step, 1);
    else list[step] = withNode(list[step], rest, value);
    return list;
  }
  const mapping: Mapping = isMapping(node) ? { ...node } : {};
  if (rest.length === 0 && value === undefined) delete mapping[step];
  else mapping[step] = withNode(mapping[step] as Node | undefined, rest, value);
  return mapping;
}

/** A copy that is new to the file: without the places that its parts have in it. */
export function asNew(node: Node): Node {
  if (Array.isArray(node)) return node.map(asNew);
  if (!isMapping(node)) return node;
  return Object.fromEntries(
    Object.entries(node)
      .filter(([key]) => key !== '$from')
      .map(([key, value]) => [key, asNew(value as Node)]),
  );
}

/** A name that is not taken: "Pump", "Pump 2", "Pump 3". */
export function freeName(wanted: string, taken: Set<string>): string {
  if (!taken.has(wanted)) return wanted;
  const base = wanted.replace(/ \d+$/, '');
  let n = 2;
  while (taken.has(`${base} ${n}`)) ++n;
  return `${base} ${n}`;
}
