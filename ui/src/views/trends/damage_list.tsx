// The damaged parts of the history file as a list, also those without times, which no chart has.
import { language, t } from '../../i18n';
import { damage } from './state';

const MOST = 200;

const timeText = (time: string) => new Date(time).toLocaleString(language.value, { hour12: false });

export function DamageList() {
  const texts = t.value.trends.damage;
  const all = damage.value;
  if (all.length === 0) return null;
  return (
    <details class="marks" open>
      <summary class="problem">{texts.title(all.length)}</summary>
      <ul>
        {all.slice(0, MOST).map((its, i) => (
          <li key={i}>
            <time>{its.from && its.to ? `${timeText(its.from)} – ${timeText(its.to)}` : '–'}</time>
            <span>{its.variable ?? texts.several}</span>
            <code class="muted small">{its.part}</code>
            {its.samples !== null && <span>{texts.lost(its.samples)}</span>}
          </li>
        ))}
      </ul>
    </details>
  );
}
