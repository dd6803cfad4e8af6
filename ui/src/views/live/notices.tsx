import { formatClock, t } from '../../i18n';
import { notices } from '../../store/live';

const DOTS = { info: '', warning: 'warn', error: 'bad' } as const;

/** The messages since the page was opened, the newest first. */
export function Notices() {
  const texts = t.value.live;
  const all = [...notices.value].reverse();
  return (
    <section class="panel notices">
      <header>
        <h2>{texts.notices}</h2>
      </header>
      <ul tabIndex={0} aria-label={texts.notices}>
        {all.length === 0 && <li class="muted">{texts.noNotices}</li>}
        {all.map((its, i) => (
          <li key={all.length - i}>
            <time class="muted">{formatClock(its.time)}</time>
            <i class={`dot ${DOTS[its.severity]}`} />
            <span>{its.text}</span>
          </li>
        ))}
      </ul>
    </section>
  );
}
