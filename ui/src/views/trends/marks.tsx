// The marks of the range as a list: the same as the lines of the chart, to be read.
import { formatClock, t } from '../../i18n';
import { cursors, marks } from './state';

const MOST = 200;
const DOTS = { info: '', warning: 'warn', error: 'bad' } as const;

function dotOf(its: (typeof marks.value)[number]): string {
  return its.kind === 'command' && its.severity === 'info' ? 'good' : DOTS[its.severity];
}

export function Marks() {
  const texts = t.value.trends.marks;
  const all = marks.value;
  if (all.length === 0) return null;
  return (
    <details class="marks">
      <summary>{texts.title(all.length)}</summary>
      <ul>
        {all
          .slice(-MOST)
          .reverse()
          .map((its, i) => (
            <li key={all.length - i}>
              <button
                type="button"
                class="button quiet"
                title={texts.go}
                onClick={() => {
                  cursors.value = { ...cursors.peek(), a: its.time };
                }}
              >
                <time>{formatClock(its.time, true)}</time>
              </button>
              <i class={`dot ${dotOf(its)}`} />
              <span>{its.text}</span>
              {its.kind === 'command' && (
                <span class="muted small">{its.origin ? texts.browser(its.origin) : texts.program}</span>
              )}
            </li>
          ))}
      </ul>
    </details>
  );
}
