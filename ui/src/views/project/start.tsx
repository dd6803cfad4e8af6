// An empty project: where its lines, devices and variables can come from.
import { computed } from '@preact/signals';
import { useEffect, useState } from 'preact/hooks';
import { t } from '../../i18n';
import { listAt } from '../../store/document';
import { mayEdit, status } from '../../store/info';
import { draft, setNode } from '../../store/project';
import { SearchPanel } from '../devices/search';
import { search } from '../devices/search_state';
import { importing } from './importing';
import { select } from './selection';
import '../../style/devices.css';

/** A line that needs no hardware: the program answers for its device. */
const EXAMPLE = {
  name: 'example',
  transport: 'simulated',
  framing: 'rtu',
  baud: '19200',
  devices: [
    {
      name: 'Boiler',
      address: '16',
      poll_period: '500ms',
      turnaround: '4ms',
      variables: [
        { name: 'Supply temperature', type: 'float', register: '0', read: '0x03', unit: '°C' },
        { name: 'Return temperature', type: 'float', register: '2', read: '0x03', unit: '°C' },
        { name: 'Setpoint', type: 'float', register: '4', read: '0x03', write: '0x10', unit: '°C' },
        { name: 'Pump runs', type: 'bool', coil: '0', read: '0x01', write: '0x05' },
      ],
    },
  ],
};

export const isEmpty = computed(
  () =>
    listAt(draft.value, ['lines']).length === 0 &&
    listAt(draft.value, ['servers']).length === 0 &&
    listAt(draft.value, ['instruments']).length === 0,
);

function example(): void {
  setNode(['lines'], [EXAMPLE]);
  select(['lines', 0, 'devices', 0]);
}

export function Start() {
  const texts = t.value.project.start;
  // The first device that is added leaves the others that were found in sight.
  const [began] = useState(isEmpty.peek());
  // The button that filled the project is gone, and the focus with it: saving is next.
  useEffect(() => {
    if (began && !isEmpty.value && document.activeElement?.matches('body, .tree'))
      document.querySelector<HTMLElement>('[aria-keyshortcuts="Control+S"]')?.focus();
  }, [isEmpty.value]);
  const finds = began && (search.value?.devices.length ?? 0) > 0;
  if ((!isEmpty.value && !finds) || !mayEdit.value) return null;
  const ways = [
    { name: texts.paste, hint: texts.pasteHint, act: () => (importing.value = { text: '', path: null }) },
    { name: texts.example, hint: texts.exampleHint, act: example },
  ];
  return (
    <div class="start">
      <SearchPanel lines={status.value?.lines ?? []} />
      {isEmpty.value && (
        <section class="panel" aria-label={texts.title}>
          <h2>{texts.title}</h2>
          <ul>
            {ways.map((its) => (
              <li key={its.name}>
                <button type="button" class="button" onClick={its.act}>
                  {its.name}
                </button>
                <span class="muted">{its.hint}</span>
              </li>
            ))}
          </ul>
        </section>
      )}
    </div>
  );
}
