// The damaged parts of the history file as a list, also those without times, which no chart has.
import { formatDate, t } from '../../i18n';
import { damage } from './state';

const MOST = 200;

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
            <time>{its.from && its.to ? `${formatDate(its.from)} – ${formatDate(its.to)}` : '–'}</time>
            <span>{its.variable ?? texts.several}</span>
            <code class="muted small">{its.part}</code>
            {its.samples !== null && <span>{texts.lost(its.samples)}</span>}
          </li>
        ))}
      </ul>
    </details>
  );
}
