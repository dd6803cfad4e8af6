// What a device with `gaps: learn` was found to answer and to refuse between its groups.
import { useEffect, useState } from 'preact/hooks';
import { get } from '../../api/client';
import type { DeviceStatus, ItemRange, Learnt, LearntGaps, LineStatus } from '../../api/types';
import { formatDuration, t } from '../../i18n';

const AGAIN_MS = 3000;
/** What the functions 1 to 4 read. */
const AREAS = ['coil', 'discrete_input', 'holding_register', 'input_register'] as const;

const rangeText = ({ first, last }: ItemRange) => (first === last ? String(first) : `${first}–${last}`);

function Gaps({ its }: { its: LearntGaps }) {
  const texts = t.value.devices.learnt;
  return (
    <ul class="gaps">
      {its.confirmed.length > 0 && (
        <li>
          <i class="dot good" /> {texts.answers}: <b>{its.confirmed.map(rangeText).join(', ')}</b>
        </li>
      )}
      {its.refused.map((range) => (
        <li key={range.first}>
          <i class="dot" /> {texts.refuses}: <b>{rangeText(range)}</b>{' '}
          <span class="muted">
            {texts.exception(range.exception, formatDuration(1000 * range.checked_s))}
          </span>
        </li>
      ))}
      {its.untried.length > 0 && (
        <li>
          <i class="dot" /> {texts.untried}: {its.untried.map(rangeText).join(', ')}
        </li>
      )}
      {its.most_items !== null && <li class="muted">{texts.most(its.most_items)}</li>}
    </ul>
  );
}

export function LearntBlock({ line, device }: { line: LineStatus; device: DeviceStatus }) {
  const texts = t.value.devices.learnt;
  const [learnt, setLearnt] = useState<Learnt | null>(null);
  useEffect(() => {
    const ask = () =>
      get<Learnt>('devices/learnt')
        .then(setLearnt)
        .catch(() => {});
    void ask();
    const timer = setInterval(ask, AGAIN_MS);
    return () => clearInterval(timer);
  }, []);
  const of = learnt?.lines.find((its) => its.name === line.name);
  if (!of) return null;
  const all = of.learnt.filter((its) => its.device === device.name);
  return (
    <>
      <dt>{texts.title}</dt>
      <dd>
        {all.length === 0 && <span class="muted">{of.learns ? texts.nothing : texts.off}</span>}
        {all.map((its) => (
          <div key={its.function}>
            <span class="muted">{t.value.words[AREAS[its.function - 1]!]}</span>
            <Gaps its={its} />
          </div>
        ))}
      </dd>
    </>
  );
}
