// What is selected: an item of the tree, a variable or a request. The variables of the selection light up in
// the table, and their requests in the plan.
import { computed, signal } from '@preact/signals';
import { at, formatPath, isMapping, listAt, type Path, parsePath, textAt } from '../../store/document';
import { draft } from '../../store/project';
import { itemPath } from './tree';

const path = signal<Path>(['lines', 0, 'devices', 0]);
export const tab = signal<'settings' | 'variables'>('settings');
/** Which half is shown on a narrow screen. */
export const half = signal<'edit' | 'effect'>('edit');
/** A cell or field to go to, as the path of a finding. */
export const wanted = signal<string | null>(null);

/** The selected item; the one above it where it does not exist any more. */
export const selected = computed<Path>(() => {
  const document = draft.value;
  let its = path.value;
  while (its.length > 0) {
    const node = at(document, its);
    if (isMapping(node) || (its.length === 1 && its[0] === 'locals')) return its;
    its = its.slice(0, -2);
  }
  return its;
});

export function select(to: Path): void {
  path.value = to;
}

export type Lit = { variables: ReadonlySet<string>; request: string | null };
const NOTHING: Lit = { variables: new Set(), request: null };
/** The variables that light up; `request` is the key of the request if it was selected itself. */
export const lit = signal<Lit>(NOTHING);

export function lightVariable(name: string | undefined): void {
  const before = lit.peek();
  if (name === undefined) lit.value = NOTHING;
  else if (before.request !== null || before.variables.size !== 1 || !before.variables.has(name))
    lit.value = { variables: new Set([name]), request: null };
}
export function lightRequest(key: string, variables: string[]): void {
  lit.value = { variables: new Set(variables), request: key };
}

/** Selects the item of a path and goes to the field or cell. */
export function reveal(text: string): void {
  const item = itemPath(text);
  select(item);
  half.value = 'edit';
  const rest = formatPath(parsePath(text).slice(item.length));
  tab.value = rest.startsWith('variables') ? 'variables' : 'settings';
  wanted.value = text;
  // Cells of a table look at `wanted`.
  const table = tab.peek() === 'variables' ? '.table .grid' : null;
  focusSoon(() => document.getElementById(text) ?? (table ? document.querySelector(table) : null));
}

const MOST_TRIES = 100;
/** Focuses an element as soon as its view shows it. */
function focusSoon(find: () => HTMLElement | null, tries = MOST_TRIES): void {
  setTimeout(() => {
    const element = find();
    if (element) element.focus();
    else if (tries > 1) focusSoon(find, tries - 1);
  }, 50);
}

/** Selects the device of a variable on a line, and its row in the table. */
export function revealVariable(line: number, device: string, variable?: string): void {
  const devices = listAt(draft.peek(), ['lines', line, 'devices']);
  const number = devices.findIndex(
    (its) =>
      textAt(its, ['name']) === device &&
      (variable === undefined || listAt(its, ['variables']).some((one) => one.name === variable)),
  );
  const index = number >= 0 ? number : devices.findIndex((its) => textAt(its, ['name']) === device);
  if (index < 0) return;
  select(['lines', line, 'devices', index]);
  tab.value = 'variables';
  if (variable === undefined) return;
  const row = listAt(devices[index], ['variables']).findIndex((its) => its.name === variable);
  if (row >= 0) wanted.value = formatPath(['lines', line, 'devices', index, 'variables', row, 'name']);
}
