// The plan that is shown: the last one without wrong values, the line of the selection, and what the last
// edit changed.
import { batch, computed, effect, signal } from '@preact/signals';
import type { Course, PlannedLine } from '../../api/types';
import { at, isMapping, listAt } from '../../store/document';
import { draft, evaluation, loaded } from '../../store/project';
import { selected } from '../project/selection';
import { isLate } from '../project/tree';

const SHOWN_MS = 9000;
/** Evaluations that follow each other this quickly are one change. */
const TOGETHER_MS = 1200;

export type DrawnLine = PlannedLine & { course: Course };
export const plan = signal<DrawnLine[]>([]);
/** The values are wrong: the plan is that of before. */
export const outdated = signal(false);

export interface LineChange {
  line: string;
  requests: [number, number];
  busy: [number, number];
}
export const lastChange = signal<LineChange[] | null>(null);

let baseline: PlannedLine[] | null = null;
let baselineFile: unknown = null;
let changedAt = 0;
let timer = 0;

function note(before: PlannedLine[], after: PlannedLine[]): void {
  // The same plan once more, with measures.
  const now = plan.peek();
  const same = (its: PlannedLine, i: number) =>
    its.request_count === now[i]?.request_count && its.utilization === now[i].utilization;
  if (after.length === now.length && after.every(same)) return;
  const changes: LineChange[] = [];
  for (const [i, line] of after.entries()) {
    const old = before.find((its) => its.name === line.name) ?? before[i];
    if (!old) continue;
    if (old.request_count === line.request_count && Math.abs(old.utilization - line.utilization) < 5e-4)
      continue;
    changes.push({
      line: line.name,
      requests: [old.request_count, line.request_count],
      busy: [old.utilization, line.utilization],
    });
  }
  lastChange.value = changes.length > 0 ? changes : null;
  window.clearTimeout(timer);
  timer = window.setTimeout(() => {
    lastChange.value = null;
  }, SHOWN_MS);
}

effect(() => {
  const its = evaluation.value;
  if (!its) return;
  batch(() => {
    const wrong = its.findings.some((one) => one.severity === 'error' && !isLate(one));
    outdated.value = wrong && its.lines.length === 0;
    if (outdated.value) return;
    const file = loaded.peek();
    const now = Date.now();
    const before = plan.peek();
    const lines = its.lines.map((line, i) => ({ ...line, course: its.courses[i]! }));
    if (file !== baselineFile || baseline === null) {
      baselineFile = file;
      baseline = lines;
    } else {
      if (now - changedAt > TOGETHER_MS) baseline = before;
      note(baseline, lines);
    }
    changedAt = now;
    plan.value = lines;
  });
});

let lastLine = 0;
/** The number of the line that is shown: that of the selection, else the one before. */
export const lineNumber = computed(() => {
  const path = selected.value;
  if (path[0] === 'lines' && typeof path[1] === 'number') lastLine = path[1];
  const count = listAt(draft.value, ['lines']).length;
  return Math.min(lastLine, Math.max(0, count - 1));
});
export const lineNode = computed(() => {
  const node = at(draft.value, ['lines', lineNumber.value]);
  return isMapping(node) ? node : undefined;
});
export const shownLine = computed<DrawnLine | undefined>(
  () => plan.value.find((its) => its.name === lineNode.value?.name) ?? plan.value[lineNumber.value],
);
