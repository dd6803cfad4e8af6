// A table of variables like that of a spreadsheet: edited in place, by keyboard, with the clipboard.
import { useEffect, useRef, useState } from 'preact/hooks';
import type { Finding } from '../../api/types';
import { t } from '../../i18n';
import { formatPath, type Path, parsePath } from '../../store/document';
import { findingsByPath } from '../../store/project';
import { toast, toastError } from '../../shell/toasts';
import { type Column, Grid, type GridCell } from '../../widgets/grid';
import { cellText } from './cells';
import { CellEditor, cellChoices } from './cell_editor';
import { CoilDialog } from './coil_question';
import type { TableColumn, TableObject } from './columns';
import { importing } from './importing';
import { Picker } from './picker';
import { hintText, keyText } from './rules';
import { lit, wanted } from './selection';
import { CellView } from './table_cell';
import { type TableState, useTable } from './table_state';
import { TableTools } from './table_tools';
import { markOf } from './tree';
import { isImport } from './tsv';

const inEditor = (event: Event) =>
  (event.target as Element).closest('input, select, textarea, dialog') !== null;

/** Returns whether the key did something. */
function onKey(state: TableState, event: KeyboardEvent, cell: GridCell): boolean {
  const column = state.columns[cell.column];
  const command = event.ctrlKey || event.metaKey;
  const key = event.key.toLowerCase();
  const act = (run: () => void): true => {
    event.preventDefault();
    run();
    return true;
  };
  if (command && key === 'a') return act(state.selectAll);
  if (event.key === 'Escape' && state.current) return act(() => state.select(state.current!));
  if (state.locked || !column) return false;
  if (command && key === 'd') return act(state.fillDown);
  if (command && event.key === 'Delete') return act(state.remove);
  if (command || event.altKey) return false;
  if (event.key === 'Insert') return act(state.add);
  if (!state.current) return false;
  if (event.key === 'F2') return act(() => state.edit({ ...cell, text: null }));
  if (event.key === 'Delete' || event.key === 'Backspace') return act(state.clear);
  if (column.kind === 'boolean') {
    return event.key === ' ' && act(() => state.toggle(cell.row, column));
  }
  if (event.key.length !== 1 || column.kind === 'source') return false;
  // A list is chosen from; a typed character replaces the text of other cells.
  return act(() => (cellChoices(column) ? state.edit({ ...cell, text: null }) : state.type(cell, event.key)));
}

/** What is wrong with the current cell, or else with its row. */
function currentFindings(state: TableState): Finding[] {
  const index = state.current ? state.order[state.current.row] : undefined;
  if (index === undefined || !state.current) return [];
  const row = formatPath([...state.path, index]);
  const cell = findingsByPath.value.get(`${row}.${state.columns[state.current.column]?.key}`);
  return (cell ?? findingsByPath.value.get(row) ?? []).filter((its) => its.severity !== 'note');
}

function goTo(state: TableState, text: string): void {
  const steps = parsePath(text).slice(state.path.length);
  const row = state.order.indexOf(steps[0] as number);
  if (row < 0) return;
  const column = state.columns.findIndex((its) => its.key === steps[1]);
  if (column < 0 && steps[1] !== undefined && !state.allColumns) {
    state.setAllColumns(true);
    return;
  }
  state.select({ row, column: Math.max(0, column) });
  wanted.value = null;
}

const foldOf = ({ folds, foldedWidth }: TableColumn) => ({
  ...(folds && { folds }),
  ...(foldedWidth && { foldedWidth }),
});

function gridColumns(
  state: TableState,
  leave: (then: 'down' | 'right' | 'left' | 'stay') => void,
): Column<number>[] {
  return state.columns.map((column, c) => ({
    key: column.key,
    title: keyText(column.key),
    width: column.width,
    sortable: true,
    ...(column.right && { align: 'right' as const }),
    ...(!state.allColumns && foldOf(column)),
    cellClass: (_, row) => (state.isInRange(row, c) ? 'in-range' : ''),
    cell: (index, row) =>
      state.editing?.row === row && state.editing.column === c ? (
        <CellEditor
          column={column}
          text={state.editing.text ?? cellText(state.list[index]!, column.key, column.kind)}
          onCommit={(text, then) => {
            if (text !== cellText(state.list[index]!, column.key, column.kind))
              state.setCell(row, column, text);
            leave(then);
          }}
          onCancel={() => leave('stay')}
        />
      ) : (
        <CellView state={state} column={column} row={row} index={index} />
      ),
  }));
}

export function VariableTable({ path, object, label }: { path: Path; object: TableObject; label: string }) {
  const texts = t.value.project.table;
  const state = useTable(path, object);
  const box = useRef<HTMLDivElement>(null);
  const [picking, setPicking] = useState<{ row: number; column: TableColumn } | null>(null);
  const base = formatPath(path);
  const target = wanted.value;
  useEffect(() => {
    if (target?.startsWith(`${base}[`)) goTo(state, target);
  }, [target, base, state.allColumns]);

  const focus = () => box.current?.querySelector<HTMLElement>('.grid')?.focus();
  const leave = (then: 'down' | 'right' | 'left' | 'stay') => {
    const cell = state.editing;
    state.edit(null);
    if (!cell) return;
    if (then !== 'stay' || document.activeElement?.closest('.grid')) focus();
    const row = Math.min(state.order.length - 1, cell.row + (then === 'down' ? 1 : 0));
    const step = then === 'right' ? 1 : then === 'left' ? -1 : 0;
    if (then !== 'stay')
      state.select({ row, column: Math.max(0, Math.min(state.columns.length - 1, cell.column + step)) });
  };
  const open = (cell: GridCell) => {
    const column = state.columns[cell.column];
    if (state.locked || !column) return;
    if (column.kind === 'boolean') state.toggle(cell.row, column);
    else if (column.kind === 'local' || column.kind === 'source') setPicking({ row: cell.row, column });
    else state.edit({ ...cell, text: null });
  };
  const paste = (text: string) => {
    if (state.locked || text.trim() === '') return;
    if (object !== 'bank' && isImport(text)) importing.value = { text, path };
    else state.paste(text).catch(toastError);
  };
  const findings = currentFindings(state);
  const column = state.current && state.columns[state.current.column];
  const help = column && hintText(column.key, object);
  const lights = object === 'variable' ? lit.value.variables : null;
  return (
    <div
      class="table"
      ref={box}
      onCopy={(event) => {
        if (inEditor(event) || !state.current) return;
        event.preventDefault();
        event.clipboardData?.setData('text/plain', state.copyText());
      }}
      onCut={(event) => {
        if (inEditor(event) || !state.current || state.locked) return;
        event.preventDefault();
        event.clipboardData?.setData('text/plain', state.copyText());
        state.clear();
      }}
      onPaste={(event) => {
        if (inEditor(event)) return;
        event.preventDefault();
        paste(event.clipboardData?.getData('text/plain') ?? '');
      }}
    >
      <TableTools
        state={state}
        onAdd={() => {
          state.add();
          focus();
        }}
        onPaste={() => {
          focus();
          navigator.clipboard
            ?.readText()
            .then(paste)
            .catch(() => toast('info', texts.pasteHint));
          if (!navigator.clipboard) toast('info', texts.pasteHint);
        }}
      />
      <Grid
        label={label}
        columns={gridColumns(state, leave)}
        rows={state.order}
        rowKey={(index) => index}
        rowClass={(index, row) => {
          const name = state.list[index]?.name;
          const light = typeof name === 'string' && lights?.has(name);
          return `${state.isSelected(row) ? 'selected' : ''} ${light ? 'lit' : ''}`;
        }}
        rowSelected={(_, row) => state.isSelected(row)}
        empty={state.filter ? texts.emptyFilter : texts.empty}
        sort={state.sort}
        onSort={state.onSort}
        current={state.current}
        onCurrent={(cell, event) => {
          if (!state.editing || event instanceof KeyboardEvent) state.select(cell, event);
        }}
        onOpen={open}
        onKey={(event, cell) => onKey(state, event, cell)}
      />
      <div class="message" aria-live="polite">
        {findings.map((its) => (
          <p key={its.code + its.path} class={markOf(its) ?? ''}>
            <b aria-hidden="true">!</b> {its.message} <span class="muted">{its.advice}</span>
          </p>
        ))}
        {findings.length === 0 && help && (
          <p class="small">
            <b>{keyText(column.key)}.</b> <span class="muted">{help}</span>
          </p>
        )}
        {findings.length === 0 && !help && !state.locked && <p class="muted small hint">{texts.hint}</p>}
      </div>
      {state.openPaste && (
        <CoilDialog
          rows={state.openPaste}
          onPick={(choice) => {
            state.settlePaste(choice);
            setTimeout(focus);
          }}
        />
      )}
      {picking && (
        <Picker
          wants={picking.column.wants ?? 'any'}
          kinds={
            picking.column.kind === 'source'
              ? ['standard', 'service', 'network']
              : picking.column.wants === 'bool'
                ? ['standard', 'service']
                : ['standard']
          }
          value={cellText(
            state.list[state.order[picking.row]!]!,
            picking.column.key,
            picking.column.kind,
          ).replace(/^(variable|local): /, '')}
          newName={picking.column.wants === 'int' ? 'status' : 'trigger'}
          onPick={(name, kind) => {
            const { key } = picking.column;
            if (name === undefined || picking.column.kind === 'local') state.setValue(picking.row, key, name);
            else state.setValue(picking.row, key, kind === 'standard' ? { local: name } : { variable: name });
          }}
          onClose={() => {
            setPicking(null);
            setTimeout(focus);
          }}
        />
      )}
    </div>
  );
}
