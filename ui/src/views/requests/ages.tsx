// The longest age of each variable against its deadline, the worst first.
import type { PlannedLine } from '../../api/types';
import { formatBound, t } from '../../i18n';
import { type Column, Grid } from '../../widgets/grid';
import { lightVariable, lit, revealVariable } from '../project/selection';
import { type Age, fullness } from './figures';
import { lineNumber } from './plan';
import { isEstimated } from './summary';
import { microseconds, percent, requestWords } from './words';

function Bar({ age }: { age: Age }) {
  const texts = t.value.requests.ages;
  if (age.unknown) return null;
  if (age.limit_us === null) return <span class="muted small">{texts.noDeadline}</span>;
  const full = fullness(age);
  const scale = Math.max(1, Number.isFinite(full) ? full : 1);
  return (
    <span class="age-bar" title={Number.isFinite(full) ? percent(full) : texts.unbounded}>
      <span
        class={age.holds ? 'ok' : 'late'}
        style={{ width: `${Number.isFinite(full) ? (full / scale) * 100 : 100}%` }}
      />
      {scale > 1 && <i style={{ left: `${100 / scale}%` }} />}
    </span>
  );
}

function columns(line: PlannedLine): Column<Age>[] {
  const texts = t.value.requests;
  return [
    {
      key: 'variable',
      title: texts.columns.variable,
      width: 'minmax(130px, 1.2fr)',
      cell: (its) => <span class="text">{its.variable}</span>,
    },
    {
      key: 'age',
      title: texts.columns.age,
      width: '140px',
      foldedWidth: '128px',
      align: 'right',
      cell: (its) => (
        <span class={its.unknown ? 'muted' : its.holds ? '' : 'bad'}>
          {its.age_us !== null
            ? formatBound(its.age_us / 1000)
            : its.unknown
              ? texts.ages.unknown
              : texts.ages.unbounded}
        </span>
      ),
    },
    {
      key: 'bar',
      title: texts.columns.share,
      width: 'minmax(110px, 1fr)',
      folds: 'text',
      cell: (its) => <Bar age={its} />,
    },
    {
      key: 'limit',
      title: texts.columns.limit,
      width: '84px',
      foldedWidth: '110px',
      align: 'right',
      cell: (its) => (its.limit_us === null ? '' : microseconds(its.limit_us)),
    },
    {
      key: 'request',
      title: texts.columns.function,
      width: '120px',
      folds: 'figure',
      cell: (its) => <span class="mono muted">{requestWords(line.requests[its.request]!)}</span>,
    },
  ];
}

export function Ages({ line, ages }: { line: PlannedLine; ages: Age[] }) {
  const texts = t.value.requests.ages;
  return (
    <>
      <Grid
        label={texts.label}
        columns={columns(line)}
        rows={ages}
        rowKey={(its) => its.variable}
        rowClass={(its) =>
          `${its.holds ? '' : 'too-late'} ${lit.value.variables.has(its.variable) ? 'lit' : ''}`
        }
        onCurrent={({ row }) => {
          const its = ages[row];
          if (!its) return;
          revealVariable(lineNumber.peek(), line.requests[its.request]!.device, its.variable);
          lightVariable(its.variable);
        }}
        empty={texts.none}
      />
      <p class="request-details muted small">
        {texts.legend} {!isEstimated(line) && t.value.requests.busyWorst(percent(line.worst_utilization))}
      </p>
    </>
  );
}
