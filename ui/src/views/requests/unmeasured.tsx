// Devices whose turnaround is not known: the ages of their line are not computed yet.
import type { PlannedLine } from '../../api/types';
import { t } from '../../i18n';
import { listAt, textAt } from '../../store/document';
import { status } from '../../store/info';
import { draft, setNode } from '../../store/project';
import { measuredText } from '../devices/state';
import { readOnly } from '../project/edit';
import { unmeasured } from './figures';
import { lineNumber } from './plan';

const MOST_SHOWN = 6;

/** The running program has measured it: that figure. Else the program is to measure it. */
function Action({ line, device }: { line: string; device: string }) {
  const texts = t.value.requests.unmeasured;
  const number = lineNumber.value;
  const devices = listAt(draft.value, ['lines', number, 'devices']);
  const index = devices.findIndex((its) => textAt(its, ['name']) === device);
  if (index < 0) return null;
  const path = ['lines', number, 'devices', index, 'turnaround'];
  const running = status.value?.lines.find((its) => its.name === line);
  const measured = running?.devices.find((its) => its.name === device)?.turnaround;
  const learns = textAt(devices[index]!, ['turnaround']) === 'learn';
  if (learns && !measured?.advised) return <span class="muted">{texts.measuring}</span>;
  const value = measured?.advised ?? 'learn';
  return (
    <>
      <button
        type="button"
        class="button small"
        disabled={readOnly(path) !== null}
        title={measured?.advised ? undefined : texts.measureHint}
        onClick={() => setNode(path, value)}
      >
        {measured?.advised ? texts.use(value) : texts.measure}
      </button>
      {measured?.advised && (
        <span class="muted small">
          {texts.measured} {measuredText(measured)}
        </span>
      )}
    </>
  );
}

export function Unmeasured({ line }: { line: PlannedLine }) {
  const texts = t.value.requests.unmeasured;
  const names = unmeasured(line);
  if (names.length === 0) return null;
  return (
    <ul class="unmeasured">
      {names.slice(0, MOST_SHOWN).map((name) => (
        <li key={name}>
          <span>{texts.text(name)}</span> <Action line={line.name} device={name} />
        </li>
      ))}
      {names.length > MOST_SHOWN && (
        <li class="muted">{t.value.requests.details.more(names.length - MOST_SHOWN)}</li>
      )}
    </ul>
  );
}
