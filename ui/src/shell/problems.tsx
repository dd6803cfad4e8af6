// Why the project is not in order: the list behind the health in the bar, and the findings of a device.
import type { Problem } from '../api/types';
import { formatDuration, formatNumber, t } from '../i18n';
import { status } from '../store/info';
import { Dialog } from './dialog';
import { go } from './route';

const DOTS = { error: 'bad', warning: 'warn', note: '' } as const;
const MOST_NAMES = 12;

/** The view with more about a problem. */
export function openProblem(its: Problem): void {
  if (its.device) go('devices', { line: its.line ?? '', device: its.device });
  else if (its.variables[0]) go('live', { filter: its.variables[0] });
  else go('devices');
}

function Names({ names }: { names: string[] }) {
  const texts = t.value.shell.problems;
  if (names.length === 0) return null;
  const left = names.length - MOST_NAMES;
  return (
    <p class="muted">
      {texts.notGood} {names.slice(0, MOST_NAMES).join(', ')}
      {left > 0 && ` ${texts.more(formatNumber(left))}`}
    </p>
  );
}

function Item({ its, onOpen }: { its: Problem; onOpen: ((its: Problem) => void) | undefined }) {
  const texts = t.value.shell.problems;
  const facts = [
    its.since_ms !== undefined && texts.since(formatDuration(its.since_ms)),
    its.count !== undefined &&
      (its.of === undefined
        ? texts.count(formatNumber(its.count))
        : texts.countOf(
            formatNumber(its.count),
            formatNumber(its.of),
            formatNumber((100 * its.count) / Math.max(its.of, 1), 1),
          )),
  ].filter(Boolean);
  return (
    <li>
      <i class={`dot ${DOTS[its.severity]}`} title={texts.severity[its.severity]} />
      <div>
        <p>
          <b>{its.text}</b>
        </p>
        {facts.length > 0 && <p class="muted">{facts.join(' · ')}</p>}
        <Names names={its.variables} />
        {its.tried && <p>{its.tried}</p>}
        {its.advice && <p>{its.advice}</p>}
        {onOpen && (
          <button type="button" class="button quiet" onClick={() => onOpen(its)}>
            {texts.open}
          </button>
        )}
      </div>
    </li>
  );
}

export function ProblemList(props: { problems: Problem[]; onOpen?: (its: Problem) => void }) {
  if (props.problems.length === 0) return <p class="muted">{t.value.shell.problems.none}</p>;
  return (
    <ul class="reasons">
      {props.problems.map((its) => (
        <Item
          key={`${its.kind} ${its.line} ${its.device} ${its.output} ${its.request} ${its.text}`}
          its={its}
          onOpen={props.onOpen}
        />
      ))}
    </ul>
  );
}

export function ProblemsDialog({ onClose }: { onClose: () => void }) {
  const its = status.value;
  return (
    <Dialog title={t.value.health[its?.health ?? 'unknown']} onClose={onClose}>
      <ProblemList
        problems={its?.problems ?? []}
        onOpen={(problem) => {
          onClose();
          openProblem(problem);
        }}
      />
    </Dialog>
  );
}
