// Saving shows the difference of the file first. A file that changed on the disk is not overwritten unasked.
import { signal } from '@preact/signals';
import { useEffect, useState } from 'preact/hooks';
import { ApiError } from '../../api/client';
import type { Finding } from '../../api/types';
import { t } from '../../i18n';
import { Dialog } from '../../shell/dialog';
import { go } from '../../shell/route';
import { errorText, toast, toastError } from '../../shell/toasts';
import { mayEdit } from '../../store/info';
import { changedOnDisk, difference, isChanged, loadProject, mergeWithFile, save } from '../../store/project';
import { FindingTexts, firstWrong, lateValues } from './problems';
import { reveal } from './selection';

const MOST_CONFLICTS = 5; // that are named

/** The lines of a unified difference with what each of them is. */
export function diffLines(diff: string): { kind: 'add' | 'remove' | 'place' | 'same'; text: string }[] {
  return diff
    .replace(/\n$/, '')
    .split('\n')
    .filter((line) => !/^(---|\+\+\+) /.test(line))
    .map((line) => {
      if (line.startsWith('@@')) return { kind: 'place', text: line };
      if (line.startsWith('+')) return { kind: 'add', text: line };
      return line.startsWith('-') ? { kind: 'remove', text: line } : { kind: 'same', text: line };
    });
}

const asked = signal(false);

/** Opens the dialog where something can be saved. Wrong values come first: they are in the view Project. */
export function askToSave(): void {
  if (!mayEdit.peek() || !isChanged.peek()) return;
  const wrong = firstWrong();
  asked.value = wrong === undefined;
  if (!wrong) return;
  toast('bad', `${t.peek().project.cannotSave} ${wrong.message}`);
  go('project');
  reveal(wrong.path);
}

/** The dialog while it is open, in any view. */
export function Saving() {
  if (!asked.value) return null;
  return (
    <SaveDialog
      onClose={() => {
        asked.value = false;
      }}
    />
  );
}

function SaveDialog({ onClose }: { onClose: () => void }) {
  const texts = t.value.project.saving;
  const [diff, setDiff] = useState<string | null>(null);
  const [problem, setProblem] = useState('');
  const [findings, setFindings] = useState<Finding[]>([]);
  const [busy, setBusy] = useState(false);
  useEffect(() => {
    difference()
      .then(setDiff)
      .catch((failure) => {
        if (failure instanceof ApiError && failure.code === 'changed_on_disk') {
          changedOnDisk.value = true;
          onClose();
          go('project');
        } else setProblem(errorText(failure));
      });
  }, []);
  const accept = async () => {
    setBusy(true);
    try {
      const saved = await save(true);
      const backup = saved.backup?.replace(/^.*\//, '') ?? '';
      if (saved.apply_error) toast('bad', `${texts.notApplied(backup)} ${saved.apply_error}`);
      else toast('good', saved.applied ? texts.saved(backup) : texts.notApplied(backup));
      onClose();
    } catch (failure) {
      if (changedOnDisk.peek()) onClose();
      else setProblem(errorText(failure));
      if (failure instanceof ApiError)
        setFindings((failure.body as { findings?: Finding[] } | null)?.findings ?? []);
    }
    setBusy(false);
  };
  return (
    <Dialog
      title={texts.title}
      accept={texts.accept}
      focusAccept
      acceptDisabled={busy || diff === null || diff === ''}
      onAccept={() => void accept()}
      onClose={onClose}
    >
      <div class="saving">
        <p class="muted">{texts.keeps}</p>
        {lateValues.value > 0 && <p class="warning">{texts.deadlines}</p>}
        {problem && (
          <p class="bad" role="alert">
            {problem}
          </p>
        )}
        {findings.length > 0 && <FindingTexts findings={findings} />}
        {diff === '' && <p>{texts.nothing}</p>}
        {diff && (
          <pre class="diff" role="region" aria-label={texts.changes} tabIndex={0}>
            {diffLines(diff).map((line, i) => (
              <span key={i} class={line.kind}>
                {line.text}
              </span>
            ))}
          </pre>
        )}
      </div>
    </Dialog>
  );
}

/** Takes what changed in the file, and keeps what was edited here: the next save shows the difference. */
async function keepMine(): Promise<void> {
  const conflicts = await mergeWithFile();
  const texts = t.peek().project.conflict;
  if (conflicts.length === 0) toast('info', texts.kept);
  else toast('bad', texts.both(conflicts.length, conflicts.slice(0, MOST_CONFLICTS).join(', ')));
}

export function Conflict() {
  const texts = t.value.project.conflict;
  if (!changedOnDisk.value) return null;
  return (
    <div class="banner warning" role="alert">
      <div>
        <b>{texts.title}</b>
        <p>{texts.text}</p>
      </div>
      <button type="button" class="button" onClick={() => loadProject().catch(toastError)}>
        {texts.take}
      </button>
      <button
        type="button"
        class="button"
        title={texts.keepHint}
        onClick={() => keepMine().catch(toastError)}
      >
        {texts.keep}
      </button>
    </div>
  );
}
