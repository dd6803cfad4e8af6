import { useEffect } from 'preact/hooks';
import { openUrl } from '../../api/client';
import type { History } from '../../api/types';
import { formatDate, t } from '../../i18n';
import { toast } from '../../shell/toasts';
import { go } from '../../shell/route';
import { info, mayEdit } from '../../store/info';
import { Icon } from '../../widgets/icon';
import { addOutput } from '../project/edit';
import { Chart, drawnOf } from './chart';
import { DamageList } from './damage_list';
import { Marks } from './marks';
import { Pens } from './pens';
import * as state from './state';
import '../../style/trends.css';

const SPAN_KEYS = Object.keys(state.SPANS) as (keyof typeof state.SPANS)[];
const EXAMPLE = 'outputs:\n  - name: history\n    transport: history';

/** Of what is drawn. */
function csvUrl(): string {
  const { from, to } = state.picture.value ?? state.range();
  const parameters = new URLSearchParams();
  for (const name of state.pens.value) parameters.append('variable', name);
  return openUrl(`history.csv?${parameters}`, {
    from: new Date(from).toISOString(),
    to: new Date(to).toISOString(),
  });
}

function Tools() {
  const texts = t.value.trends;
  const frozen = state.frozen.value;
  const left = state.series.value.filter(
    (its) => its.type !== 'string' && !state.pens.value.includes(its.name),
  );
  return (
    <div class="tools">
      <select
        aria-label={texts.addPen}
        value=""
        onChange={(event) => {
          if (event.currentTarget.value) state.addPen(event.currentTarget.value);
          event.currentTarget.value = '';
        }}
      >
        <option value="">{texts.addPen}</option>
        {left.map((its) => (
          <option key={its.name} value={its.name}>
            {its.device ? `${its.device}: ` : ''}
            {its.name}
          </option>
        ))}
      </select>
      <span class="spans" role="group" aria-label={texts.live}>
        {SPAN_KEYS.map((key) => (
          <button
            key={key}
            type="button"
            class="button"
            aria-pressed={!frozen && state.span.value === state.SPANS[key]}
            onClick={() => state.goLive(state.SPANS[key])}
          >
            {texts.span[key]}
          </button>
        ))}
      </span>
      <button
        type="button"
        class="icon-button"
        aria-label={texts.earlier}
        title={texts.earlier}
        onClick={() => state.shiftBy(-0.5)}
      >
        <span class="turn">
          <Icon name="right" />
        </span>
      </button>
      <button
        type="button"
        class="icon-button"
        aria-label={texts.later}
        title={texts.later}
        onClick={() => state.shiftBy(0.5)}
      >
        <Icon name="right" />
      </button>
      <button
        type="button"
        class="icon-button"
        aria-label={texts.zoomIn}
        title={texts.zoomIn}
        onClick={() => state.zoomBy(0.5)}
      >
        <Icon name="add" />
      </button>
      <button
        type="button"
        class="icon-button"
        aria-label={texts.zoomOut}
        title={texts.zoomOut}
        onClick={() => state.zoomBy(2)}
      >
        <Icon name="remove" />
      </button>
      <button type="button" class="button" disabled={!state.canGoBack.value} onClick={state.back}>
        <Icon name="undo" />
        {texts.back}
      </button>
      <button
        type="button"
        class="button"
        aria-pressed={frozen === null}
        onClick={() => (frozen ? state.goLive() : state.zoomTo(state.range()))}
      >
        <Icon name={frozen ? 'play' : 'pause'} />
        {frozen ? texts.frozen : texts.live}
      </button>
      <span class="spring" />
      <a class="button" href={csvUrl()} download>
        <Icon name="download" />
        {texts.csv}
      </a>
      <button
        type="button"
        class="button"
        onClick={() => {
          // Without TLS a browser has a clipboard on loopback only.
          if (!navigator.clipboard) toast('info', texts.linkInAddress);
          else void navigator.clipboard.writeText(location.href).then(() => toast('good', texts.linkCopied));
        }}
      >
        <Icon name="link" />
        {texts.link}
      </button>
    </div>
  );
}

/** Of what is in the chart. */
function Legend({ history }: { history: History }) {
  const texts = t.value.trends.legend;
  const kinds = new Set(drawnOf(history).flatMap((its) => its.spans.map((span) => span.kind)));
  const marks = new Set(state.marks.value.map((its) => its.kind));
  return (
    <p class="legend small muted">
      {(['restart', 'replaced', 'lost', 'damaged', 'bad', 'uncertain'] as const)
        .filter((kind) => kinds.has(kind))
        .map((kind) => (
          <span key={kind}>
            <i class={`hatch ${kind}`} /> {texts[kind]}
          </span>
        ))}
      <span>
        <i class="age" /> {texts.age}
      </span>
      {marks.has('message') && (
        <span>
          <i class="mark-line" /> {texts.message}
        </span>
      )}
      {marks.has('command') && (
        <span>
          <i class="mark-line command" /> {texts.command}
        </span>
      )}
    </p>
  );
}

export function TrendsView() {
  const texts = t.value.trends;
  useEffect(() => (info.value?.history ? state.follow() : undefined), [info.value?.history]);
  if (info.value && !info.value.history)
    return (
      <section class="panel no-history">
        <h2>{texts.noHistory}</h2>
        <p>{texts.noHistoryHint}</p>
        <pre class="mono">{EXAMPLE}</pre>
        {mayEdit.value && (
          <button
            type="button"
            class="button"
            onClick={() => {
              addOutput();
              go('project');
            }}
          >
            {t.value.project.tree.addOutput}
          </button>
        )}
      </section>
    );
  const { a, b } = state.cursors.value;
  return (
    <section class="panel trends">
      <Tools />
      {state.problem.value && <p class="problem">{state.problem.value}</p>}
      {state.picture.value && state.pens.value.length > 0 ? (
        <Chart history={state.picture.value} />
      ) : (
        <p class="muted empty">{texts.choose}</p>
      )}
      <Pens />
      {state.pens.value.length > 0 && <Marks />}
      <DamageList />
      {state.picture.value && state.pens.value.length > 0 && (
        <footer>
          <Legend history={state.picture.value} />
          <p class="small muted">
            {texts.cursorHint}
            {(a !== null || b !== null) && (
              <button
                type="button"
                class="button quiet"
                onClick={() => {
                  state.cursors.value = { a: null, b: null };
                }}
              >
                {texts.clearCursors}
              </button>
            )}
            {state.frozen.value && (
              <>
                {' '}
                {formatDate(state.frozen.value.from)} – {formatDate(state.frozen.value.to)}
              </>
            )}
          </p>
        </footer>
      )}
    </section>
  );
}
