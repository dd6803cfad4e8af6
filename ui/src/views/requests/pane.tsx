// What the settings do to the bus: the requests of the selected line, computed again on each edit.
import { signal } from '@preact/signals';
import { useMemo } from 'preact/hooks';
import { formatDuration, t } from '../../i18n';
import { listAt, textAt } from '../../store/document';
import { draft, evaluating, evaluation, evaluationError, exportRequests } from '../../store/project';
import { toastError } from '../../shell/toasts';
import { Icon } from '../../widgets/icon';
import { select } from '../project/selection';
import { TabBar } from '../project/tab_bar';
import { Ages } from './ages';
import { agesOf } from './figures';
import { Measures } from './measures';
import { lastChange, lineNumber, outdated, shownLine } from './plan';
import { RequestTable } from './request_table';
import { LastChange, Strategies, Utilisation, Verdict } from './summary';
import { Timeline } from './timeline_view';
import { Unmeasured } from './unmeasured';
import '../../style/requests.css';
import '../../style/timeline.css';

const tab = signal<'requests' | 'ages'>('requests');

function Lines() {
  const lines = listAt(draft.value, ['lines']);
  if (lines.length < 2) return null;
  return (
    <TabBar
      name="plan-line"
      label={t.value.requests.lines}
      value={String(lineNumber.value)}
      tabs={lines.map((line, i) => ({ value: String(i), title: textAt(line, ['name']) ?? String(i + 1) }))}
      onValue={(to) => select(['lines', Number(to)])}
    />
  );
}

function Content() {
  const texts = t.value.requests;
  const line = shownLine.value;
  const ages = useMemo(() => (line ? agesOf(line) : []), [line]);
  if (!line)
    return (
      <p class="muted nothing">
        {evaluation.value ? (outdated.value ? texts.outdated : texts.noLine) : texts.waiting}
      </p>
    );
  if (line.requests.length === 0) return <p class="muted nothing">{texts.noRequests}</p>;
  const late = ages.filter((its) => !its.holds).length;
  return (
    <>
      <div class="summary">
        <Verdict line={line} />
        <Unmeasured line={line} />
        <Utilisation line={line} />
        <Strategies line={line} />
        <Measures line={line} />
        <Timeline line={line} />
      </div>
      <TabBar
        name="plan"
        label={texts.tabs.label}
        value={tab.value}
        tabs={[
          { value: 'requests', title: texts.tabs.requests(line.requests.length) },
          {
            value: 'ages',
            title: late > 0 ? texts.tabs.agesLate(late) : texts.tabs.ages,
            class: late > 0 ? 'bad' : '',
          },
        ]}
        onValue={(to) => {
          tab.value = to as typeof tab.value;
        }}
      />
      <div class="plan-panel" role="tabpanel" id="plan-panel" aria-labelledby={`plan-${tab.value}`}>
        {tab.value === 'requests' ? <RequestTable line={line} /> : <Ages line={line} ages={ages} />}
      </div>
    </>
  );
}

const FORMATS = ['csv', 'json', 'svg'] as const;

/** The requests of all lines, and a round of each as a picture, as files. */
function Export() {
  const texts = t.value.requests;
  return (
    <div class="export" role="group" aria-label={texts.export} title={texts.export}>
      <Icon name="download" />
      {FORMATS.map((as) => (
        <button
          key={as}
          type="button"
          class="button quiet small"
          disabled={outdated.value || !shownLine.value}
          onClick={() => void exportRequests(as).catch(toastError)}
        >
          {as.toUpperCase()}
        </button>
      ))}
    </div>
  );
}

export function RequestsPane() {
  const texts = t.value.requests;
  const its = evaluation.value;
  return (
    <section class={`panel requests ${outdated.value ? 'outdated' : ''}`} aria-busy={evaluating.value}>
      <header>
        <h2>{texts.title}</h2>
        <LastChange />
        {its && !evaluationError.value && !lastChange.value && (
          <span class="muted small">{texts.took(formatDuration(its.took_ms))}</span>
        )}
        <Export />
      </header>
      <Lines />
      {evaluationError.value && <p class="banner bad">{texts.failed(evaluationError.value)}</p>}
      {outdated.value && shownLine.value && <p class="banner warning">{texts.outdated}</p>}
      <Content />
    </section>
  );
}
