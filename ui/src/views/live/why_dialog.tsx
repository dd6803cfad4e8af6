// "Why is this value old?": each hop on the way of a value, with its time.
import { useEffect, useState } from 'preact/hooks';
import { get } from '../../api/client';
import type { Why } from '../../api/types';
import { formatBound, formatDuration, t } from '../../i18n';
import { Dialog } from '../../shell/dialog';
import { errorText } from '../../shell/toasts';

const AGAIN_MS = 1000;
const DOTS = { ok: 'good', wait: 'warn', trouble: 'bad' } as const;

export function WhyDialog({ variable, onClose }: { variable: string; onClose: () => void }) {
  const texts = t.value.live;
  const [why, setWhy] = useState<Why | null>(null);
  const [problem, setProblem] = useState('');
  useEffect(() => {
    const ask = () =>
      get<Why>('why', { variable })
        .then((its) => {
          setWhy(its);
          setProblem('');
        })
        .catch((failure) => setProblem(errorText(failure)));
    void ask();
    const timer = setInterval(ask, AGAIN_MS);
    return () => clearInterval(timer);
  }, [variable]);

  return (
    <Dialog title={texts.whyTitle(variable)} onClose={onClose}>
      {problem && <p class="problem">{problem}</p>}
      {why && (
        <>
          <p>
            {texts.whyAge}: <b>{why.age_ms === null ? '–' : formatDuration(why.age_ms)}</b>
            {why.proved_age_ms !== null && (
              <>
                {' · '}
                {texts.whyProved}: <b>{formatBound(why.proved_age_ms)}</b>
              </>
            )}
          </p>
          <ol class="hops">
            {why.hops.map((hop) => (
              <li key={hop.hop + hop.text}>
                <i class={`dot ${DOTS[hop.state]}`} />
                <b>{texts.hops[hop.hop]}</b>
                <span>{hop.text}</span>
                <span class="muted">{hop.ms === undefined ? '' : formatDuration(hop.ms)}</span>
              </li>
            ))}
          </ol>
        </>
      )}
    </Dialog>
  );
}
