// The draft of the project: the document as edited, its undo steps, and what the program makes of it.
import { batch, computed, signal } from '@preact/signals';
import { ApiError, download, get, post, put } from '../api/client';
import type { Evaluation, FilePart, Finding, Mapping, Node, ProjectFile, Saved } from '../api/types';
import { language, t } from '../i18n';
import { type Path, parsePath, textAt, withNode } from './document';
import { merged, rebased } from './merge';

const MOST_STEPS = 200;
/** Keystrokes in one field within this time are one undo step. */
const SAME_STEP_MS = 800;
/** An edit is evaluated at once; one that follows another this quickly, when the edits pause. */
const EDITS_FOLLOW_MS = 250;
const EVALUATE_AFTER_MS = 40;
/** The search for measures takes longer: it begins when the edits pause. */
const MEASURES_AFTER_MS = 350;
/** A later evaluation of this page ends an earlier one; other pages have their own. */
const CLIENT = Math.random().toString(36).slice(2);
const EMPTY: Mapping = {};

interface Step {
  document: Mapping;
  label: string;
}

/** As on the disk when it was loaded; null: not loaded, or this run has no project file. */
export const loaded = signal<ProjectFile | null>(null);
export const draft = signal<Mapping>({});
export const evaluation = signal<Evaluation | null>(null);
export const evaluating = signal(false);
/** The evaluation is complete except for measures. */
export const seekingMeasures = signal(false);
export const evaluationError = signal<string | null>(null);
/** The file was changed by another program, or another browser, since it was loaded. */
export const changedOnDisk = signal(false);

const undone = signal<Step[]>([]);
const done = signal<Step[]>([]);
let lastEdit = { label: '', time: 0 };

export const canUndo = computed(() => done.value.length > 0);
export const canRedo = computed(() => undone.value.length > 0);
/** The file cannot be edited here: its faults come first. */
export const isUnreadable = computed(() => loaded.value !== null && loaded.value.document === null);
export const isChanged = computed(
  () => loaded.value !== null && !isUnreadable.value && draft.value !== loaded.value.document,
);
export const findings = computed<Finding[]>(() => evaluation.value?.findings ?? loaded.value?.findings ?? []);
export const findingsByPath = computed(() => {
  const map = new Map<string, Finding[]>();
  for (const its of findings.value) {
    const list = map.get(its.path);
    if (list) list.push(its);
    else map.set(its.path, [its]);
  }
  return map;
});
export const hasErrors = computed(() => findings.value.some((its) => its.severity === 'error'));

/** The parts of other files that the draft names where the file does. */
export const fileParts = computed<FilePart[]>(() =>
  (loaded.value?.read_only_parts ?? []).filter(({ path }) => {
    const name = textAt(draft.value, parsePath(path));
    return name !== undefined && name === textAt(loaded.value?.document ?? undefined, parsePath(path));
  }),
);

export function isReadOnlyPart(path: string): string | null {
  for (const part of fileParts.value)
    if (path === part.path || path.startsWith(`${part.path}.`) || path.startsWith(`${part.path}[`))
      return part.file;
  return null;
}

let timer = 0;
let running: AbortController | null = null;

/** @param measures  whether to search what would make the deadlines hold */
async function evaluateNow(measures: boolean): Promise<void> {
  running?.abort();
  const mine = new AbortController();
  running = mine;
  evaluating.value = !measures;
  try {
    const query = { client: CLIENT, measures: measures ? 1 : undefined };
    const answer = await post<Evaluation>('project/evaluate', { document: draft.peek() }, mine.signal, query);
    if (running !== mine) return;
    batch(() => {
      evaluation.value = answer;
      evaluationError.value = null;
      seekingMeasures.value = !measures && answer.lines.length > 0;
    });
    if (seekingMeasures.peek()) timer = window.setTimeout(() => void evaluateNow(true), MEASURES_AFTER_MS);
  } catch (failure) {
    if (running !== mine || (failure instanceof DOMException && failure.name === 'AbortError')) return;
    seekingMeasures.value = false;
    // Another evaluation of this page took its place, and answers.
    if (!(failure instanceof ApiError && failure.code === 'superseded'))
      evaluationError.value = failure instanceof Error ? failure.message : String(failure);
  }
  if (running === mine) evaluating.value = false;
}

let editedAt = Number.NEGATIVE_INFINITY;

function evaluateSoon(): void {
  window.clearTimeout(timer);
  const time = performance.now();
  const wait = time - editedAt < EDITS_FOLLOW_MS ? EVALUATE_AFTER_MS : 0;
  editedAt = time;
  if (!isUnreadable.peek()) timer = window.setTimeout(() => void evaluateNow(false), wait);
}
language.subscribe(() => {
  if (loaded.peek()) evaluateSoon();
});

function take(file: ProjectFile): void {
  batch(() => {
    loaded.value = file;
    draft.value = file.document ?? EMPTY;
    done.value = [];
    undone.value = [];
    changedOnDisk.value = false;
  });
  evaluateSoon();
}

export async function loadProject(): Promise<void> {
  take(await get<ProjectFile>('project'));
}

/** Another project runs: takes the file if nothing is edited here, else says that it changed. */
export async function refreshProject(): Promise<void> {
  if (!loaded.peek()) return;
  try {
    const file = await get<ProjectFile>('project');
    if (file.revision === loaded.peek()?.revision) return;
    if (isChanged.peek()) changedOnDisk.value = true;
    else take(file);
  } catch {
    // The next save reports what is wrong with the file.
  }
}

/**
 * Joins the draft with the file, which changed since it was loaded. The undo steps end: they have the places
 * of the old file. @returns the paths of values that both changed; those of the draft are kept
 */
export async function mergeWithFile(): Promise<string[]> {
  const file = await get<ProjectFile>('project');
  const base = loaded.peek()?.document;
  if (!base || !file.document) throw new Error(t.peek().project.unreadable);
  const { document, conflicts } = merged(base, draft.peek(), file.document);
  take(file);
  if (JSON.stringify(document) !== JSON.stringify(file.document)) draft.value = document;
  return conflicts;
}

/**
 * Changes the draft. Steps with the same label that follow each other quickly are undone together.
 * @param label  what was changed, as the path of a field
 */
export function change(document: Mapping, label: string): void {
  if (document === draft.peek()) return;
  const time = Date.now();
  const same = label === lastEdit.label && time - lastEdit.time < SAME_STEP_MS && done.peek().length > 0;
  lastEdit = { label, time };
  batch(() => {
    if (!same) done.value = [...done.peek(), { document: draft.peek(), label }].slice(-MOST_STEPS);
    undone.value = [];
    draft.value = document;
  });
  evaluateSoon();
}

export function setNode(path: Path, value: Node | undefined): void {
  change(withNode(draft.peek(), path, value) as Mapping, path.join('/'));
}

/** Several changes as one undo step. */
export function setNodes(changes: { path: Path; value: Node | undefined }[], label: string): void {
  let document: Node = draft.peek();
  for (const { path, value } of changes) document = withNode(document, path, value);
  lastEdit = { label: '', time: 0 };
  change(document as Mapping, label);
}

function move(from: typeof done, to: typeof done): void {
  const step = from.peek().at(-1);
  if (!step) return;
  lastEdit = { label: '', time: 0 };
  batch(() => {
    from.value = from.peek().slice(0, -1);
    to.value = [...to.peek(), { document: draft.peek(), label: step.label }];
    draft.value = step.document;
  });
  evaluateSoon();
}
export const undo = () => move(done, undone);
export const redo = () => move(undone, done);
export function revert(): void {
  const file = loaded.peek();
  if (file?.document) change(file.document, 'revert');
}

/**
 * Puts the rows of a table, or the settings and variables of a template, in place of its name. The draft has
 * to stay as it was asked for. @returns whether it did
 */
export async function takeOver(path: string): Promise<boolean> {
  const document = draft.peek();
  const taken = await post<{ path: string; value: Node }>('project/take_over', { document, path });
  if (draft.peek() !== document) return false;
  setNode(parsePath(taken.path), taken.value);
  return true;
}

/** Saves the formed requests of the draft as a file. */
export const exportRequests = (as: 'csv' | 'json' | 'svg') =>
  download('project/evaluate', { document: draft.peek() }, { as, client: `${CLIENT} export` });

/** What saving would change, as a unified difference. */
export async function difference(): Promise<string> {
  const answer = await post<{ diff: string }>('project/diff', body());
  return answer.diff;
}

/** The steps of before a file was saved can be undone after it, too. */
function keepSteps(before: Step[], after: Step[]): void {
  const file = loaded.peek()?.document;
  if (!file) return;
  const kept = (steps: Step[]) =>
    steps.map(({ document, label }) => ({ document: rebased(document, file), label }));
  batch(() => {
    done.value = kept(before);
    undone.value = kept(after);
  });
}

export async function save(apply: boolean): Promise<Saved> {
  try {
    const saved = await put<Saved>('project', { ...body(), apply });
    const steps = [done.peek(), undone.peek()];
    await loadProject();
    keepSteps(steps[0]!, steps[1]!);
    return saved;
  } catch (failure) {
    if (failure instanceof ApiError && failure.code === 'changed_on_disk') changedOnDisk.value = true;
    throw failure;
  }
}

const body = () => ({ document: draft.peek(), revision: loaded.peek()?.revision });
