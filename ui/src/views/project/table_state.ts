// The state of a table: what is shown, selected and edited, and its operations on the draft.
import { useMemo, useRef, useState } from 'preact/hooks';
import { post } from '../../api/client';
import type { Cells, Mapping, Node } from '../../api/types';
import { t } from '../../i18n';
import { formatPath, listAt, type Path } from '../../store/document';
import { draft, setNode } from '../../store/project';
import type { GridCell } from '../../widgets/grid';
import { isYes, rawOf } from './cells';
import { type CoilChoice, openRows, withChoice } from './coil_choice';
import { COLUMNS, firstRow, type TableColumn, type TableObject } from './columns';
import { readOnly, setKeys, setList, takenNames } from './edit';
import * as rows from './rows';
import { lightVariable } from './selection';
import { formatTable, parseTable } from './tsv';

export interface Editing extends GridCell {
  text: string | null; // null: the text of the cell
}

export interface TableState {
  object: TableObject;
  path: Path;
  list: Mapping[];
  order: number[];
  columns: TableColumn[];
  locked: boolean;
  filter: string;
  sort: { key: string; down: boolean } | null;
  allColumns: boolean;
  current: GridCell | null;
  editing: Editing | null;
  isSelected: (row: number) => boolean;
  isInRange: (row: number, column: number) => boolean;
  selectedRows: () => number[]; // indices of the list
  setFilter: (text: string) => void;
  onSort: (key: string) => void;
  setAllColumns: (all: boolean) => void;
  select: (cell: GridCell, event?: MouseEvent | KeyboardEvent) => void;
  selectAll: () => void;
  edit: (editing: Editing | null) => void;
  /** A typed character begins to edit a cell; one that comes before the editor is drawn is added. */
  type: (cell: GridCell, character: string) => void;
  setCell: (row: number, column: TableColumn, text: string) => void;
  setValue: (row: number, key: string, value: Node | undefined) => void;
  toggle: (row: number, column: TableColumn) => void;
  add: () => void;
  duplicate: () => void;
  remove: () => void;
  clear: () => void;
  fillDown: () => void;
  copyText: () => string;
  paste: (text: string) => Promise<void>;
  /** Pasted rows that leave open which coil they mean; null: there are none. */
  openPaste: Mapping[] | null;
  /** Stores the pasted rows with that meaning; null: leaves the list as it was. */
  settlePaste: (choice: CoilChoice | null) => void;
}

/** What the program understands of cells: the words of the file for those of IDE and spreadsheets. */
async function readCells(columns: TableColumn[], cells: string[][]): Promise<rows.PastedRow[]> {
  const rowsOf = cells.map((row) => row.slice(0, columns.length).map((its) => its.trim()));
  const keys = columns.map((its) => its.key);
  const answer = await post<{ rows: (Cells | null)[] }>('import', { keys, cells: rowsOf });
  return answer.rows.map((its, r) => ({ cells: its, columns: columns.slice(0, rowsOf[r]!.length) }));
}

export function useTable(path: Path, object: TableObject): TableState {
  const list = listAt(draft.value, path);
  const all = COLUMNS[object];
  const [allColumns, setAllColumns] = useState(false);
  const columns = allColumns ? all : all.filter((its) => its.main);
  const [filter, setFilter] = useState('');
  const [sort, setSort] = useState<{ key: string; down: boolean } | null>(null);
  const [current, setCurrent] = useState<GridCell | null>(null);
  const [anchor, setAnchor] = useState<GridCell | null>(null);
  const [extra, setExtra] = useState<ReadonlySet<number>>(new Set());
  const [editing, edit] = useState<Editing | null>(null);
  const [pending, setPending] = useState<{ list: Mapping[]; open: Mapping[] } | null>(null);
  // Rows keep their places while cells are edited; sorting again is a click.
  const order = useMemo(() => rows.ordered(list, filter, sort, all), [list.length, filter, sort, object]);
  const shown = useRef(order);
  shown.current = order;

  const from = anchor ?? current;
  const range = current && from && [Math.min(current.row, from.row), Math.max(current.row, from.row)];
  const isSelected = (row: number) =>
    extra.has(row) || (range !== null && row >= range[0]! && row <= range[1]!);
  const isInRange = (row: number, column: number) =>
    isSelected(row) &&
    current !== null &&
    from !== null &&
    column >= Math.min(current.column, from.column) &&
    column <= Math.max(current.column, from.column);
  const selectedRows = () => order.filter((_, row) => isSelected(row));
  const selectedColumns = () =>
    current && from
      ? columns.slice(Math.min(current.column, from.column), Math.max(current.column, from.column) + 1)
      : [];
  const label = (what: string) => `${what} ${formatPath(path)}`;
  const store = (next: Mapping[], what: string) => setList(path, next, label(what));
  const storePasted = (next: Mapping[]) => {
    const open = object === 'bank' ? [] : openRows(next, list);
    if (open.length > 0) setPending({ list: next, open });
    else store(next, 'paste');
  };
  const fresh = (last: Mapping | undefined, taken: Set<string>) => {
    const first = firstRow(object, t.peek().project.table.newName);
    return object === 'bank' ? first : rows.rowAfter(last, first, taken);
  };

  const select = (cell: GridCell, event?: MouseEvent | KeyboardEvent) => {
    const extend = event?.shiftKey ?? false;
    const toggle = event instanceof MouseEvent && (event.ctrlKey || event.metaKey);
    if (toggle) {
      const next = new Set(extra);
      for (let row = 0; row < order.length; ++row) if (isSelected(row)) next.add(row);
      if (!next.delete(cell.row)) next.add(cell.row);
      setExtra(next);
    } else if (!extend) setExtra(new Set());
    setAnchor(extend ? (anchor ?? current ?? cell) : cell);
    setCurrent(cell);
    if (object !== 'variable') return;
    const name = list[shown.current[cell.row] ?? -1]?.name;
    lightVariable(typeof name === 'string' ? name : undefined);
  };

  return {
    object,
    path,
    list,
    order,
    columns,
    locked: readOnly(path) !== null,
    filter,
    sort,
    allColumns,
    current,
    editing,
    isSelected,
    isInRange,
    selectedRows,
    setFilter: (text) => {
      setFilter(text);
      setCurrent(null);
      setAnchor(null);
      setExtra(new Set());
    },
    onSort: (key) =>
      setSort(sort?.key !== key ? { key, down: false } : sort.down ? null : { key, down: true }),
    setAllColumns,
    select,
    selectAll: () => {
      if (order.length === 0) return;
      setAnchor({ row: 0, column: 0 });
      setCurrent({ row: order.length - 1, column: columns.length - 1 });
    },
    edit,
    type: (cell, character) =>
      edit((before) => {
        const same = before?.row === cell.row && before.column === cell.column;
        return { ...cell, text: (same ? (before.text ?? '') : '') + character };
      }),
    setCell: (row, column, text) => {
      const index = order[row];
      if (index !== undefined) setKeys([...path, index], { [column.key]: rawOf(column.kind, text) });
    },
    setValue: (row, key, value) => {
      const index = order[row];
      if (index !== undefined) setKeys([...path, index], { [key]: value });
    },
    toggle: (row, column) => {
      const index = order[row];
      if (index === undefined) return;
      const raw = list[index]![column.key];
      const on = raw === undefined ? (column.usual ?? false) : isYes(String(raw));
      setNode([...path, index, column.key], !on === (column.usual ?? false) ? undefined : String(!on));
    },
    add: () => {
      setFilter('');
      setSort(null);
      const row = fresh(list.at(-1), takenNames());
      store([...list, row], 'add');
      if (object === 'variable') lightVariable(String(row.name));
      const cell = { row: list.length, column: 0 };
      setAnchor(cell);
      setCurrent(cell);
      setExtra(new Set());
    },
    duplicate: () => {
      const chosen = selectedRows();
      if (chosen.length > 0) store(rows.duplicated(list, chosen, takenNames()), 'duplicate');
    },
    remove: () => {
      const chosen = selectedRows();
      if (chosen.length === 0) return;
      const row = Math.min(...order.flatMap((index, at) => (chosen.includes(index) ? [at] : [])));
      store(rows.without(list, chosen), 'remove');
      const left = order.length - chosen.length;
      const cell = left > 0 ? { row: Math.min(row, left - 1), column: current?.column ?? 0 } : null;
      setCurrent(cell);
      setAnchor(cell);
      setExtra(new Set());
    },
    clear: () => store(rows.withCells(list, selectedRows(), selectedColumns(), {}), 'clear'),
    fillDown: () => store(rows.filledDown(list, selectedRows(), selectedColumns(), takenNames()), 'fill'),
    copyText: () => formatTable(rows.copied(list, selectedRows(), selectedColumns())),
    paste: async (text) => {
      const cells = parseTable(text);
      const only = cells.length === 1 && cells[0]!.length === 1 ? cells[0]![0]! : null;
      const chosen = selectedRows();
      const fill = only !== null && chosen.length > 0;
      const first = current && from && !fill ? Math.min(current.column, from.column) : 0;
      const start = range ? range[0]! : order.length;
      const into = fill ? selectedColumns() : columns.slice(first);
      const read = await readCells(into, fill ? [into.map(() => only)] : cells);
      // The list may have changed meanwhile.
      const now = listAt(draft.peek(), path);
      const make = (before: Mapping[]) => fresh(before.at(-1), rows.namesIn(before));
      storePasted(
        fill
          ? rows.withCells(now, chosen, into, read[0]!.cells ?? {})
          : rows.pasted(now, order, read, start, make),
      );
    },
    openPaste: pending?.open ?? null,
    settlePaste: (choice) => {
      if (pending && choice) store(withChoice(pending.list, pending.open, choice), 'paste');
      setPending(null);
    },
  };
}
