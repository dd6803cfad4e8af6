// The formed requests of a line. A selected request lights up its variables, and the other way round.
import { useEffect, useMemo, useState } from 'preact/hooks';
import type { PlannedLine, PlannedRequest } from '../../api/types';
import { t } from '../../i18n';
import { type Column, Grid, type GridCell } from '../../widgets/grid';
import { lightRequest, lit, revealVariable } from '../project/selection';
import { bytesOf, gapsOf, variablesOf } from './figures';
import { lineNode, lineNumber } from './plan';
import { functionName, functionsOf, hex, microseconds, requestKey, requestWords, whenWords } from './words';

const MOST_NAMES = 60;

function columns(line: PlannedLine, variables: ReturnType<typeof variablesOf>): Column<PlannedRequest>[] {
  const texts = t.value.requests.columns;
  const several = line.devices.length > 1;
  const readWrite = line.requests.some((its) => functionsOf(its).length > 1);
  const right = { align: 'right' as const };
  return [
    ...(several
      ? [
          {
            key: 'device',
            title: texts.device,
            width: 'minmax(91px, 0.6fr)',
            foldedWidth: `minmax(${readWrite ? 58 : 68}px, 1.6fr)`,
            cell: (its: PlannedRequest) => <span class="text">{its.device}</span>,
          },
        ]
      : []),
    {
      key: 'function',
      title: texts.function,
      width: readWrite ? '92px' : '74px',
      foldedWidth: readWrite ? '78px' : '58px',
      cell: (its) => (
        <span class="mono" title={functionsOf(its).map(functionName).join(', ')}>
          {functionsOf(its).map(hex).join(' ')}
        </span>
      ),
    },
    {
      key: 'start',
      title: texts.start,
      width: '66px',
      foldedWidth: 'minmax(50px, 0.3fr)',
      ...right,
      cell: (its) => its.start,
    },
    {
      key: 'quantity',
      title: texts.quantity,
      width: '52px',
      foldedWidth: '38px',
      ...right,
      cell: (its) => its.quantity,
    },
    {
      key: 'variables',
      title: texts.variables,
      width: 'minmax(260px, 1.6fr)',
      folds: 'text',
      cell: (its) => (
        <span class="text" title={its.variables.slice(0, MOST_NAMES).join('\n')}>
          {its.variables.length > 1 && <b class="count">{its.variables.length}</b>}
          {its.variables.slice(0, MOST_NAMES).join(', ')}
        </span>
      ),
    },
    {
      key: 'time',
      title: texts.time,
      width: '72px',
      foldedWidth: '62px',
      ...right,
      cell: (its) => microseconds(its.bus_time_us),
    },
    {
      key: 'period',
      title: texts.period,
      width: '92px',
      foldedWidth: `minmax(${readWrite ? 86 : 96}px, 1fr)`,
      ...right,
      cell: (its) => (
        <span class={`text ${its.period_ms === null ? 'small' : ''}`} title={whenWords(its)}>
          {whenWords(its)}
        </span>
      ),
    },
    {
      key: 'gaps',
      title: texts.gaps,
      width: '64px',
      folds: 'hidden',
      ...right,
      cell: (its) => <span title={its.bridged}>{gapsOf(its, variables) || ''}</span>,
    },
    {
      key: 'bytes',
      title: texts.bytes,
      width: '52px',
      folds: 'hidden',
      ...right,
      cell: (its) => bytesOf(line.framing, its),
    },
    {
      key: 'reason',
      title: texts.reason,
      width: 'minmax(260px, 2fr)',
      folds: 'text',
      line: 3,
      wraps: true,
      cell: (its) => (
        <span class="text muted small" title={its.why}>
          {its.why}
        </span>
      ),
    },
  ];
}

/** Everything about the request in words; its variables lead to the table. */
function Details({ its, line, gaps }: { its: PlannedRequest; line: PlannedLine; gaps: number }) {
  const texts = t.value.requests;
  return (
    <div class="request-details">
      <p>
        <b>{functionsOf(its).map(functionName).join(', ')}</b> <span class="mono">{requestWords(its)}</span>
        <span class="muted">
          {' · '}
          {its.device}, {its.unit}
          {' · '}
          {whenWords(its)}
          {' · '}
          {microseconds(its.bus_time_us)}
          {' · '}
          {bytesOf(line.framing, its)} {texts.columns.bytes.toLowerCase()}
        </span>
      </p>
      <p>
        {its.why}
        {gaps > 0 && `. ${its.bridged ?? texts.details.gaps(gaps)}`}
      </p>
      <p class="chips">
        {its.variables.slice(0, MOST_NAMES).map((name) => (
          <button
            key={name}
            type="button"
            class="chip"
            title={texts.details.show(name)}
            onClick={() => revealVariable(lineNumber.peek(), its.device, name)}
          >
            {name}
          </button>
        ))}
        {its.variables.length > MOST_NAMES && (
          <span class="muted small">{texts.details.more(its.variables.length - MOST_NAMES)}</span>
        )}
      </p>
    </div>
  );
}

export function RequestTable({ line }: { line: PlannedLine }) {
  const texts = t.value.requests;
  const node = lineNode.value;
  const variables = useMemo(() => variablesOf(node), [node]);
  const { variables: lights, request: chosen } = lit.value;
  const [cell, setCell] = useState<GridCell | null>(null);
  const isLit = (its: PlannedRequest) => its.variables.some((name) => lights.has(name));
  const isChosen = (its: PlannedRequest) =>
    chosen !== null ? requestKey(its) === chosen : lights.size > 0 && isLit(its);
  const index = line.requests.findIndex(isChosen);
  // A variable that is selected brings its request into sight.
  useEffect(() => {
    setCell(index < 0 ? null : { row: index, column: cell?.column ?? 0 });
  }, [index, lights]);
  const choose = ({ row }: GridCell) => {
    const its = line.requests[row];
    if (!its) return;
    lightRequest(requestKey(its), its.variables);
    revealVariable(lineNumber.peek(), its.device);
  };
  const its = line.requests[index];
  return (
    <>
      <Grid
        label={texts.title}
        columns={columns(line, variables)}
        rows={line.requests}
        rowKey={(_, row) => row}
        rowClass={(one) => (isChosen(one) ? 'selected lit' : isLit(one) ? 'lit' : '')}
        rowSelected={isChosen}
        current={cell}
        onCurrent={(to) => {
          setCell(to);
          choose(to);
        }}
      />
      {its ? (
        <Details its={its} line={line} gaps={gapsOf(its, variables)} />
      ) : (
        <p class="request-details muted small">{texts.details.choose}</p>
      )}
    </>
  );
}
