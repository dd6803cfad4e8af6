// What a line does in one look: the verdict, how busy it is, and the three ways to form its requests.
import type { PlannedLine, Strategy } from '../../api/types';
import { t } from '../../i18n';
import { toast } from '../../shell/toasts';
import { listAt } from '../../store/document';
import { draft, setNodes } from '../../store/project';
import { Hint } from '../../widgets/hint';
import { readOnly, withKey } from '../project/edit';
import { profileOf } from '../project/rules';
import { lineStrategy, strategyOf } from './figures';
import { lastChange, lineNode, lineNumber } from './plan';
import { microseconds, percent } from './words';

export const TONES = { holds: 'good', response_unknown: '', not_proved: 'warn', cannot_hold: 'bad' } as const;
const STRATEGIES: Strategy[] = ['single', 'classic', 'optimal'];

export function Verdict({ line }: { line: PlannedLine }) {
  const texts = t.value.requests;
  const over = line.verdict === 'cannot_hold' && line.utilization > 1;
  return (
    <div class={`verdict ${TONES[line.verdict]}`}>
      <i class={`dot ${TONES[line.verdict]}`} />
      <p>
        <b>{over ? texts.verdict.cannot_hold_over : texts.verdict[line.verdict]}</b>{' '}
        <span>
          {texts.summary(line.compare.grouped.requests, line.compare.ungrouped.requests)}
          {line.cycle_us > 0 && `; ${texts.round(microseconds(line.cycle_us))}`}.
        </span>
      </p>
    </div>
  );
}

/** How a load is coloured: red is more than the line has. */
export function loadTone(line: PlannedLine): 'bad' | 'warn' | 'good' {
  if (line.utilization > 1) return 'bad';
  return line.verdict !== 'holds' && line.utilization > 0.8 ? 'warn' : 'good';
}
/** Without a turnaround the load is an estimate. */
export const isEstimated = (line: PlannedLine) => line.devices.some((its) => its.turnaround_us === null);
/** "34.4 %", "≈ 6.0 %" */
export const loadText = (line: PlannedLine, share = line.utilization) =>
  `${isEstimated(line) ? '≈ ' : ''}${percent(share)}`;

/** Parts of the line's time; the whole bar is all of it, or what is more than that. */
export function LoadMeter(props: { label: string; load: number; tone: string; text: string; title: string }) {
  const scale = Math.max(1, props.load);
  const width = (share: number) => `${Math.min(100, (share / scale) * 100)}%`;
  return (
    <div
      class="meter"
      role="meter"
      aria-label={props.label}
      aria-valuemin={0}
      aria-valuemax={100}
      aria-valuenow={Math.min(100, Math.round(props.load * 100))}
      aria-valuetext={props.text}
      title={props.title}
    >
      <span class={`now ${props.tone}`} style={{ width: width(props.load) }} />
      {scale > 1 && <span class="full" style={{ left: width(1) }} />}
    </div>
  );
}

export function Utilisation({ line }: { line: PlannedLine }) {
  const texts = t.value.requests;
  const estimated = isEstimated(line);
  const tone = loadTone(line);
  const text = loadText(line);
  return (
    <div class="utilisation">
      <span class="muted">{texts.busy}</span>
      <LoadMeter
        label={texts.busy}
        load={line.utilization}
        tone={`${tone} ${estimated ? 'estimate' : ''}`}
        text={text}
        title={estimated ? texts.estimate : texts.busyHint}
      />
      <b class={tone === 'bad' ? 'bad' : ''}>{text}</b>
    </div>
  );
}

/** Sets the strategy of every device of the line, as one step. */
function applyStrategy(strategy: Strategy): void {
  const number = lineNumber.peek();
  const profile = profileOf(draft.peek());
  const devices = listAt(draft.peek(), ['lines', number, 'devices']);
  const changes = devices.flatMap((device, i) => {
    if (strategyOf(device, profile) === strategy) return [];
    const { group_requests: _, ...rest } = device;
    return [{ path: ['lines', number, 'devices', i], value: withKey(rest, 'strategy', strategy) }];
  });
  if (changes.length === 0) return;
  setNodes(changes, 'strategy');
  const texts = t.peek().requests.strategies;
  toast('good', texts.applied(texts[strategy]));
}

export function Strategies({ line }: { line: PlannedLine }) {
  const texts = t.value.requests.strategies;
  const costs = line.compare?.strategies;
  if (!costs) return null;
  const current = lineStrategy(lineNode.value, profileOf(draft.value));
  const scale = Math.max(1, ...STRATEGIES.map((its) => costs[its]?.utilization ?? 0));
  const locked = readOnly(['lines', lineNumber.value]) !== null;
  return (
    <section class="strategies" aria-label={texts.title}>
      {STRATEGIES.map((name) => {
        const cost = costs[name];
        if (!cost) return null;
        // The others are only what would be.
        const bad = cost.utilization > 1 && current === name;
        return (
          <div key={name} class={`strategy ${current === name ? 'current' : ''}`}>
            <b>
              {texts[name]} <Hint text={texts[`${name}Hint`]} />
            </b>
            <span>{texts.requests(cost.requests)}</span>
            <div class="meter" aria-hidden="true">
              <span
                class={`now ${bad ? 'bad' : 'plain'}`}
                style={{ width: `${(cost.utilization / scale) * 100}%` }}
              />
            </div>
            <span class={`figure ${bad ? 'bad' : ''}`}>{loadText(line, cost.utilization)}</span>
            {current === name ? (
              <span class="muted small in-use">{texts.current}</span>
            ) : (
              <button
                type="button"
                class="button small"
                disabled={locked}
                aria-label={`${texts.apply}: ${texts.applyHint(texts[name])}`}
                title={texts.applyHint(texts[name])}
                onClick={() => applyStrategy(name)}
              >
                {texts.apply}
              </button>
            )}
          </div>
        );
      })}
    </section>
  );
}

/** Before and after of the last edit, for a moment. */
export function LastChange() {
  const texts = t.value.requests.change;
  const changes = lastChange.value;
  return (
    <div class="last-change" role="status" aria-label={texts.label}>
      {changes?.map((its) => {
        const [before, after] = its.busy;
        const [was, is] = its.requests;
        const worse = after > before + 5e-4;
        const better = after < before - 5e-4;
        return (
          <p key={its.line} class={worse ? 'worse' : better ? 'better' : ''}>
            {changes.length > 1 && <b>{its.line}: </b>}
            {texts.requests} {was} → <b>{is}</b>, {texts.busy} {percent(before)} → <b>{percent(after)}</b>
          </p>
        );
      })}
    </div>
  );
}
