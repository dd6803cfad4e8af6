// A cell of a table as it is shown: texts for people, the type's colour, a mark for what is wrong.
import { t } from '../../i18n';
import { at, formatPath, textAt } from '../../store/document';
import { draft, findingsByPath } from '../../store/project';
import { cellText, durationText, isYes, plainType, typeClass } from './cells';
import type { TableColumn } from './columns';
import { keyText } from './rules';
import type { TableState } from './table_state';
import { markOf } from './tree';
import { functionChoice, wordsOf } from './words';

function shownText(state: TableState, column: TableColumn, index: number): { text: string; usual?: boolean } {
  const row = state.list[index]!;
  const text = cellText(row, column.key, column.kind);
  if (text === '') {
    if (column.key === 'period' && state.object === 'variable') {
      const device = textAt(at(draft.value, state.path.slice(0, -1)), ['poll_period']);
      return { text: durationText(device ?? ''), usual: true };
    }
    return { text: '' };
  }
  if (column.kind === 'source')
    return {
      text: text.replace(/^(variable|local): /, (_, kind: string) => (kind === 'local' ? '◇ ' : '← ')),
    };
  return { text: wordsOf(column.kind, text) };
}

export function CellView(props: { state: TableState; column: TableColumn; row: number; index: number }) {
  const { state, column, row, index } = props;
  const its = state.list[index];
  if (!its) return null;
  const path = formatPath([...state.path, index]);
  const own = findingsByPath.value.get(`${path}.${column.key}`) ?? [];
  // What is wrong with the whole row is marked at its first column.
  const all = state.columns[0] === column ? [...own, ...(findingsByPath.value.get(path) ?? [])] : own;
  const worst = all.find((one) => markOf(one) === 'error') ?? all.find((one) => markOf(one) === 'warning');
  const mark = worst && (
    <span class={`cell-mark ${markOf(worst)}`} title={worst.message} role="img" aria-label={worst.message}>
      !
    </span>
  );
  if (column.kind === 'boolean') {
    const raw = its[column.key];
    const on = raw === undefined ? (column.usual ?? false) : isYes(String(raw));
    return (
      <>
        <input
          type="checkbox"
          tabIndex={-1}
          checked={on}
          disabled={state.locked}
          aria-label={`${keyText(column.key)}: ${String(its.name ?? '')}`}
          onClick={(event) => {
            event.preventDefault();
            state.toggle(row, column);
          }}
        />
        {mark}
      </>
    );
  }
  const { text, usual } = shownText(state, column, index);
  const type = typeof its.type === 'string' ? plainType(its.type) : '';
  const title = column.kind === 'function' && text !== '' ? functionChoice(String(its[column.key])) : text;
  const coloured = column.key === 'name' || column.key === 'type';
  return (
    <>
      <span
        class={`text ${usual ? 'muted' : ''} ${coloured ? typeClass(type) : ''}`}
        title={usual ? t.value.project.defaultIs(text) : title}
      >
        {text}
      </span>
      {mark}
    </>
  );
}
