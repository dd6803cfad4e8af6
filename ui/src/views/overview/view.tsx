// The whole project on one screen: load of the lines, devices by state, ages against their proof, problems.
import { useMemo } from 'preact/hooks';
import type { LineStatus } from '../../api/types';
import { formatBound, formatDuration, formatNumber, t } from '../../i18n';
import { openProblem, ProblemList } from '../../shell/problems';
import { go } from '../../shell/route';
import { second, tick } from '../../store/clock';
import { listAt } from '../../store/document';
import { status } from '../../store/info';
import { values } from '../../store/live';
import { draft, isChanged, loaded } from '../../store/project';
import { half, select } from '../project/selection';
import { plan } from '../requests/plan';
import { LoadMeter, loadText, loadTone, TONES } from '../requests/summary';
import { percent } from '../requests/words';
import { type DeviceAge, deviceAges } from './ages';
import { counted, DeviceMap, mapped } from './device_map';
import '../../style/overview.css';
import '../../style/requests.css';

const MOST_LINES = 6;
const MOST_AGES = 12;

/** The formed requests of a line. */
function openRequests(name: string): void {
  const line = listAt(draft.peek(), ['lines']).findIndex((its) => its.name === name);
  if (line >= 0) select(['lines', line]);
  half.value = 'effect';
  go('project');
}

function LineLoad({ line }: { line: LineStatus }) {
  const texts = t.value.overview;
  // The plan is that of the draft, which runs where nothing is edited.
  const planned = isChanged.value ? undefined : plan.value.find((its) => its.name === line.name);
  const word = t.value.devices.lineState[line.state as keyof typeof t.value.devices.lineState] ?? line.state;
  const text = texts.now(percent(line.load));
  return (
    <li>
      <p>
        <i class={`dot ${line.state === 'connected' ? 'good' : 'bad'}`} title={word} />
        <b>{line.name}</b>
        {line.state !== 'connected' && <span class="bad">{word}</span>}
        <span class="spring" />
        <b>{text}</b>
        {planned && (
          <span class="muted" title={t.value.requests.busyHint}>
            {texts.planned(loadText(planned))}
          </span>
        )}
      </p>
      <LoadMeter
        label={`${t.value.requests.busy}: ${line.name}`}
        load={line.load}
        tone={planned ? loadTone(planned) : 'good'}
        text={text}
        title={text}
      />
      {planned && planned.verdict !== 'holds' && (
        <p class="small">
          <i class={`dot ${TONES[planned.verdict]}`} /> {t.value.requests.verdict[planned.verdict]}
        </p>
      )}
    </li>
  );
}

function Lines({ lines }: { lines: LineStatus[] }) {
  const texts = t.value.overview;
  const rank = (its: LineStatus) => (its.state === 'connected' ? its.load : 2);
  const shown = [...lines].sort((a, b) => rank(b) - rank(a)).slice(0, MOST_LINES);
  return (
    <section class="panel" aria-labelledby="overview-lines">
      <header>
        <h2 id="overview-lines">{texts.lines}</h2>
        {loaded.value && (
          <button type="button" class="button quiet small" onClick={() => openRequests(shown[0]?.name ?? '')}>
            {t.value.requests.title}
          </button>
        )}
      </header>
      <ul class="loads">
        {shown.map((its) => (
          <LineLoad key={its.name} line={its} />
        ))}
      </ul>
      {lines.length > shown.length && (
        <p class="muted small">{texts.moreLines(lines.length - shown.length)}</p>
      )}
    </section>
  );
}

function AgeRow({ its }: { its: DeviceAge }) {
  const full = its.age_ms / its.proved_ms;
  return (
    <li>
      <a href={`#/live?${new URLSearchParams({ filter: its.variable })}`}>
        {its.device}
        <span class="muted">{its.variable}</span>
      </a>
      <span class="age-bar" aria-hidden="true">
        <span class={its.late ? 'late' : 'ok'} style={{ width: `${Math.min(1, full) * 100}%` }} />
      </span>
      <span class={`figure ${its.late ? 'bad' : ''}`}>
        {formatDuration(its.age_ms)}
        {' / '}
        {formatBound(its.proved_ms)}
      </span>
    </li>
  );
}

function Ages() {
  const texts = t.value.overview;
  const now = second.value;
  const live = values.value;
  const ages = useMemo(
    () =>
      deviceAges(
        live.map((its) => its.peek()),
        tick.peek() ?? now * 1000,
      ),
    [live, now],
  );
  const counts = status.value?.values;
  return (
    <section class="panel ages-panel" aria-labelledby="overview-ages">
      <header>
        <h2 id="overview-ages" title={texts.agesHint}>
          {texts.ages}
        </h2>
        {counts && (
          <span class="values">
            <a href="#/live">
              {t.value.devices.allGood(counts.good)}
              {counts.bad + counts.uncertain > 0 && (
                <b class="warn">{t.value.devices.notGood(counts.bad + counts.uncertain)}</b>
              )}
            </a>
          </span>
        )}
      </header>
      {ages.length === 0 ? (
        <p class="muted pad">{live.length === 0 ? t.value.live.waiting : texts.noAges}</p>
      ) : (
        <ul class="ages">
          {ages.slice(0, MOST_AGES).map((its) => (
            <AgeRow key={`${its.line}/${its.device}`} its={its} />
          ))}
        </ul>
      )}
    </section>
  );
}

export function OverviewView() {
  const texts = t.value.overview;
  const its = status.value;
  if (!its) return <p class="muted">{t.value.shell.loading}</p>;
  const devices = mapped(its.lines);
  if (devices.length === 0)
    return (
      <p class="muted">
        {texts.empty} <a href="#/project">{t.value.nav.project}</a>
      </p>
    );
  return (
    <div class="overview">
      <section class="panel map-panel" aria-labelledby="overview-devices">
        <header>
          <h2 id="overview-devices">
            <a href="#/devices">{t.value.devices.title}</a>{' '}
            <span class="muted">{formatNumber(devices.length)}</span>
          </h2>
          <ul class="states">
            {counted(devices).map((one) => (
              <li key={one.text}>
                <i class={`dot ${one.tone}`} /> {one.text}: <b>{formatNumber(one.count)}</b>
              </li>
            ))}
          </ul>
        </header>
        <DeviceMap />
      </section>
      <Lines lines={its.lines} />
      <Ages />
      <section class="panel problems-panel" aria-labelledby="overview-problems">
        <header>
          <h2 id="overview-problems">{texts.problems}</h2>
          <span class="muted">{t.value.health[its.health]}</span>
        </header>
        <div class="scroll" tabIndex={0} role="region" aria-labelledby="overview-problems">
          <ProblemList problems={its.problems} onOpen={openProblem} />
        </div>
      </section>
    </div>
  );
}
