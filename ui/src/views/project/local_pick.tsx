// A field for the name of a variable, with the button `…` that opens the picker.
import { useState } from 'preact/hooks';
import { t } from '../../i18n';
import type { Wanted } from './choices';
import { type Bound, TextBox } from './field';
import { Picker } from './picker';

const NEW_NAMES: Record<Wanted, string> = { bool: 'enable', int: 'status', any: 'Var1' };

export function LocalPick({ its, wants, label }: { its: Bound; wants: Wanted; label: string }) {
  const [open, setOpen] = useState(false);
  return (
    <>
      <TextBox
        id={its.id}
        text={its.text}
        findings={its.findings}
        disabled={its.locked}
        placeholder={t.value.project.none}
        onText={(text) => {
          const name = text.trim() === '' ? undefined : text;
          its.set(name);
          return name ?? '';
        }}
      />
      <button
        type="button"
        class="button dots"
        disabled={its.locked}
        title={t.value.project.choose}
        aria-label={`${label}: ${t.value.project.choose}`}
        aria-haspopup="dialog"
        onClick={() => setOpen(true)}
      >
        …
      </button>
      {open && (
        <Picker
          wants={wants}
          kinds={wants === 'bool' ? ['standard', 'service'] : ['standard']}
          value={its.text}
          newName={NEW_NAMES[wants]}
          onPick={(name) => its.set(name)}
          onClose={() => setOpen(false)}
        />
      )}
    </>
  );
}
