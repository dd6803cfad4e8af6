// Asks which coil the pasted rows of a bool mean that have a register and no bit.
import { useState } from 'preact/hooks';
import type { Mapping } from '../../api/types';
import { t } from '../../i18n';
import { Dialog } from '../../shell/dialog';
import { type CoilChoice, coilsOf } from './coil_choice';

/** @param rows  at least one; the first one is the example */
export function CoilQuestion(props: {
  rows: Mapping[];
  value: CoilChoice | null;
  onPick: (choice: CoilChoice) => void;
}) {
  const texts = t.value.project.coils;
  const first = props.rows[0]!;
  const coils = coilsOf(first);
  const register = String(first.register);
  return (
    <fieldset class="coil-question">
      <legend>{texts.question(String(first.name ?? ''), register, props.rows.length)}</legend>
      {(['coil', 'bit'] as const).map((choice) => (
        <label key={choice}>
          <input
            type="radio"
            name="coil-choice"
            checked={props.value === choice}
            onChange={() => props.onPick(choice)}
          />{' '}
          {texts[choice](coils[choice], register)}
        </label>
      ))}
    </fieldset>
  );
}

/** The question alone. @param onPick  gets null if the rows are not to be pasted */
export function CoilDialog(props: { rows: Mapping[]; onPick: (choice: CoilChoice | null) => void }) {
  const [choice, setChoice] = useState<CoilChoice | null>(null);
  return (
    <Dialog
      title={t.value.project.coils.title}
      acceptDisabled={choice === null}
      onAccept={() => props.onPick(choice)}
      onClose={() => props.onPick(null)}
    >
      <CoilQuestion rows={props.rows} value={choice} onPick={setChoice} />
    </Dialog>
  );
}
