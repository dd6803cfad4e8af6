// The findings of the draft as a list. A choice goes to the field.
import { computed } from '@preact/signals';
import { useState } from 'preact/hooks';
import type { Finding } from '../../api/types';
import { t } from '../../i18n';
import { Dialog } from '../../shell/dialog';
import { at, parsePath, textAt } from '../../store/document';
import { draft, evaluating, findings, isUnreadable } from '../../store/project';
import { keyText } from './rules';
import { reveal } from './selection';
import { isLate, markOf } from './tree';

export const lateValues = computed(
  () => findings.value.filter((its) => its.severity === 'error' && isLate(its)).length,
);
export const wrongValues = computed(
  () => findings.value.filter((its) => its.severity === 'error' && !isLate(its)).length,
);
const warnings = computed(() => findings.value.filter((its) => its.severity === 'warning').length);

const notes = computed(() => findings.value.filter((its) => its.severity === 'note').length);

const rank = (its: Finding) =>
  its.severity === 'error' ? (isLate(its) ? 1 : 0) : its.severity === 'warning' ? 2 : 3;
const DOTS = { error: 'bad', warning: 'warn' } as const;

const MOST_TEXTS = 8;

/** "Line · Boiler · Address": the objects on a path by their names, and the field. */
function fieldText(text: string): string {
  const path = parsePath(text);
  return path
    .map((step, i) => {
      if (typeof step === 'string') return i === path.length - 1 ? keyText(step) : '';
      const item = at(draft.value, path.slice(0, i + 1));
      return (
        textAt(item, ['name']) ?? textAt(item, ['address']) ?? `${keyText(String(path[i - 1]))} ${step + 1}`
      );
    })
    .filter((its) => its !== '')
    .join(' · ');
}

/** The field; of a file that is only shown, the line. A draft has no lines yet. */
const placeOf = (its: Finding) =>
  !isUnreadable.value && its.path ? fieldText(its.path) : its.line > 0 ? `${its.line}:${its.column}` : '';

/** The first error goes before those that only make a deadline late. */
export const firstWrong = () => findings.peek().find((its) => its.severity === 'error' && !isLate(its));

/** Errors as texts, with their places. */
export function FindingTexts(props: { findings: Finding[] }) {
  return (
    <ul class="finding-texts">
      {props.findings
        .filter((its) => its.severity === 'error')
        .slice(0, MOST_TEXTS)
        .map((its, i) => (
          <li key={i}>
            <code class="muted">{placeOf(its)}</code> {its.message}{' '}
            <span class="muted small">{its.advice}</span>
          </li>
        ))}
    </ul>
  );
}

function ProblemList({ onClose }: { onClose: () => void }) {
  const texts = t.value.project;
  const sorted = [...findings.value].sort((a, b) => rank(a) - rank(b));
  return (
    <Dialog title={texts.findings} onClose={onClose}>
      <p class="muted small">{texts.findingsHint}</p>
      <ul class="problems">
        {sorted.map((its, i) => (
          <li key={i}>
            <button
              type="button"
              onClick={() => {
                onClose();
                reveal(its.path);
              }}
            >
              <i class={`dot ${its.severity === 'note' ? '' : DOTS[markOf(its) ?? 'warning']}`} />
              <span>
                {its.message} <span class="muted small">{its.advice}</span>
              </span>
              <code class="muted small">{placeOf(its)}</code>
            </button>
          </li>
        ))}
      </ul>
    </Dialog>
  );
}

const capital = (text: string) => text.charAt(0).toUpperCase() + text.slice(1);

export function Problems() {
  const [open, setOpen] = useState(false);
  const texts = t.value.project;
  const errors = wrongValues.value;
  const late = lateValues.value;
  const parts = [
    errors > 0 ? texts.errors(errors) : '',
    late > 0 ? texts.late(late) : '',
    warnings.value > 0 ? texts.warnings(warnings.value) : '',
    notes.value > 0 ? texts.notes(notes.value) : '',
  ].filter((its) => its !== '');
  const calm = notes.value > 0 ? '' : 'good';
  const dot = errors > 0 ? 'bad' : late + warnings.value > 0 ? 'warn' : calm;
  return (
    <>
      <button
        type="button"
        class={`button quiet state ${errors > 0 ? 'bad' : ''}`}
        disabled={parts.length === 0}
        onClick={() => setOpen(true)}
      >
        <i class={`dot ${dot}`} />
        {capital(parts.join(', ')) || (evaluating.value ? texts.checking : texts.allGood)}
      </button>
      {open && <ProblemList onClose={() => setOpen(false)} />}
    </>
  );
}
