// The connection of a line that a pasted table makes.
import { t } from '../../i18n';
import type { Connection } from './importing';
import { keyText, wordText } from './rules';

const PLACES = {
  serial: [['port', '/dev/ttyUSB0']],
  tcp: [
    ['host', '192.168.0.10'],
    ['tcp_port', '502'],
  ],
  simulated: [],
} as const;

export function NewLine({ value, onValue }: { value: Connection; onValue: (its: Connection) => void }) {
  return (
    <>
      <label>
        <span class="muted">{keyText('transport')}</span>
        <select
          value={value.transport}
          onChange={(event) =>
            onValue({ ...value, transport: event.currentTarget.value as Connection['transport'] })
          }
        >
          {Object.keys(PLACES).map((its) => (
            <option key={its} value={its}>
              {wordText(its)}
            </option>
          ))}
        </select>
      </label>
      {PLACES[value.transport].map(([key, example]) => (
        <label key={key}>
          <span class="muted">{keyText(key)}</span>
          <input
            type="text"
            spellcheck={false}
            placeholder={example}
            value={value[key]}
            onInput={(event) => onValue({ ...value, [key]: event.currentTarget.value })}
          />
        </label>
      ))}
      {value.transport === 'simulated' && <p class="muted small">{t.value.project.importing.simulated}</p>}
    </>
  );
}
