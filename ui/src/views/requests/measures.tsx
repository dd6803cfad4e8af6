// Measures that would make the deadlines hold. One click applies all changes of a measure.
import type { Measure, PlannedLine } from '../../api/types';
import { formatBound, t } from '../../i18n';
import { parsePath } from '../../store/document';
import { seekingMeasures, setNodes } from '../../store/project';
import { readOnly } from '../project/edit';
import { keyText, wordText } from '../project/rules';
import { durationText } from '../project/cells';
import { unmeasured } from './figures';
import { isEstimated } from './summary';
import { percent } from './words';

const MOST_SHOWN = 6;

function apply(measure: Measure): void {
  setNodes(
    measure.changes.map((its) => ({
      path: [...parsePath(its.path), ...its.key.split('.')],
      value: its.to === '' ? undefined : its.to,
    })),
    'measure',
  );
}

const valueText = (text: string) => (/^\d/.test(text) ? durationText(text) : wordText(text));

/** What the measure changes, and what the proof then has. */
function Changes({ measure, estimated }: { measure: Measure; estimated: boolean }) {
  const texts = t.value.requests.measures;
  return (
    <details>
      <summary>{texts.changes(measure.changes.length)}</summary>
      <ul>
        {measure.changes.slice(0, MOST_SHOWN).map((its) => (
          <li key={its.path + its.key}>
            {its.name && `${its.name}: `}
            {keyText(its.key)} {its.from && `${valueText(its.from)} → `}
            <b>{its.to ? valueText(its.to) : texts.removed}</b>
          </li>
        ))}
        {measure.changes.length > MOST_SHOWN && (
          <li class="muted">{t.value.requests.details.more(measure.changes.length - MOST_SHOWN)}</li>
        )}
        {/* The load before would count the time-outs of devices that were not measured. */}
        <li class="muted">
          {estimated
            ? texts.afterOnly(`≈ ${percent(measure.utilization_after)}`)
            : texts.after(percent(measure.utilization_before), percent(measure.utilization_after))}
        </li>
      </ul>
    </details>
  );
}

export function Measures({ line }: { line: PlannedLine }) {
  const texts = t.value.requests.measures;
  // Their figures would rest on a turnaround that was not measured.
  if (unmeasured(line).length > 0) return null;
  if (line.measures.length === 0)
    return line.verdict !== 'holds' && seekingMeasures.value ? (
      <p class="measures muted">{texts.searching}</p>
    ) : null;
  const estimated = isEstimated(line);
  const calm = line.verdict === 'holds';
  const time = (us: number | null) =>
    us === null ? texts.unbounded : `${estimated ? '≈ ' : ''}${formatBound(us / 1000)}`;
  return (
    <details class={`measures ${calm ? 'calm' : ''}`} open={!calm}>
      <summary>{calm ? texts.titleFaults(line.measures.length) : texts.title}</summary>
      {estimated && <p class="muted small">{texts.estimated}</p>}
      <div class="list">
        {line.measures.map((its, i) => {
          const locked = its.changes.some((one) => readOnly(parsePath(one.path)) !== null);
          return (
            <div key={i} class="measure">
              <div>
                <b>{its.text}</b>
                <span class="muted small">
                  {texts.response(its.variable, time(its.response_before_us), time(its.response_after_us))}
                </span>
                <Changes measure={its} estimated={estimated} />
              </div>
              <button
                type="button"
                class="button"
                disabled={locked}
                title={locked ? texts.readOnly : undefined}
                aria-label={`${texts.apply}: ${its.text}`}
                onClick={() => apply(its)}
              >
                {texts.apply}
              </button>
            </div>
          );
        })}
      </div>
    </details>
  );
}
