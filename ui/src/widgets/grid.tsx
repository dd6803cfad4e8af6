// A table for thousands of rows: only the rows in sight are in the document. Arrow keys move the cursor.
import type { ComponentChildren } from 'preact';
import { useEffect, useId, useLayoutEffect, useRef, useState } from 'preact/hooks';
import { t } from '../i18n';

export interface Column<Row> {
  key: string;
  title: string;
  width: string; // of a CSS grid: "120px", "minmax(120px, 1fr)"
  align?: 'right';
  sortable?: boolean;
  /** In a narrow grid: in a further line of each row, `text` at its begin, `figure` at its end; or hidden. */
  folds?: 'text' | 'figure' | 'hidden';
  /** The line that it folds into; 2 if it is not given. */
  line?: 3;
  /** How many columns of the first line it takes where it folds; 1 if it is not given. */
  spans?: 2;
  /** In a very narrow grid its text has two lines. */
  wraps?: boolean;
  /** In the first line of a narrow grid. */
  foldedWidth?: string;
  /** Of a column that has the value of a hidden one too where it folds. */
  foldedTitle?: string;
  cell: (row: Row, index: number) => ComponentChildren;
  cellClass?: (row: Row, index: number) => string;
}

export interface GridCell {
  row: number;
  column: number;
}

export interface GridProps<Row> {
  label: string;
  columns: Column<Row>[];
  rows: Row[];
  rowKey: (row: Row, index: number) => string | number;
  rowClass?: (row: Row, index: number) => string;
  /** Where several rows can be selected: whether this one is. */
  rowSelected?: (row: Row, index: number) => boolean;
  empty?: ComponentChildren;
  height?: string;
  sort?: { key: string; down: boolean } | null;
  onSort?: (key: string) => void;
  /** The current cell, if the owner keeps it. */
  current?: GridCell | null;
  onCurrent?: (cell: GridCell, event: MouseEvent | KeyboardEvent) => void;
  /** Keys that the grid does not use. */
  onKey?: (event: KeyboardEvent, cell: GridCell) => void;
  onOpen?: (cell: GridCell) => void; // Enter, double click
}

const SPARE_ROWS = 12;

const USUAL_ROW = 28; // pixels: the widths of columns are for this size

/** Widths for a larger font. */
function scaled(width: string, factor: number): string {
  return factor === 1 ? width : width.replace(/([\d.]+)px/g, (_, px) => `${Math.round(px * factor)}px`);
}
const WRAPS_BELOW = 560; // pixels
const FURTHER_LINE = 0.65; // of the height of a row

/** The least width of a column: all rows of a table get the same widths. */
function leastWidth(width: string): number {
  return Number.parseFloat(width.replace(/^minmax\(/, '')) || 0;
}

export function Grid<Row>(props: GridProps<Row>) {
  const box = useRef<HTMLDivElement>(null);
  const id = useId();
  const [range, setRange] = useState({ first: 0, last: 60 });
  const [own, setOwn] = useState<GridCell | null>(null);
  const current = props.current === undefined ? own : props.current;
  const rowHeight = useRef(USUAL_ROW);
  const [factor, setFactor] = useState(1);
  const [width, setWidth] = useState(Number.POSITIVE_INFINITY);
  const widths = props.columns.map((its) => scaled(its.width, factor));
  const least = (its: string[]) => its.reduce((sum, one) => sum + leastWidth(one), 0);
  const foldBelow = props.columns.some((its) => its.folds) ? least(widths) : 0;
  const lineOf = (its: Column<Row>) => (its.folds === 'hidden' || !its.folds ? 1 : (its.line ?? 2));
  const folded = width < foldBelow;
  const wraps = folded && width < WRAPS_BELOW && props.columns.some((its) => its.wraps);
  const lines = (folded ? Math.max(...props.columns.map(lineOf)) : 1) + Number(wraps);

  const look = () => {
    const element = box.current;
    if (!element) return;
    setWidth(element.clientWidth);
    const first = Math.max(0, Math.floor(element.scrollTop / rowHeight.current) - SPARE_ROWS);
    const last = Math.ceil((element.scrollTop + element.clientHeight) / rowHeight.current) + SPARE_ROWS;
    setRange((before) => (before.first === first && before.last === last ? before : { first, last }));
  };
  useLayoutEffect(() => {
    const usual =
      Number.parseFloat(getComputedStyle(document.documentElement).getPropertyValue('--row')) || USUAL_ROW;
    rowHeight.current = Math.round(usual * (1 + (lines - 1) * FURTHER_LINE));
    setFactor(usual / USUAL_ROW);
    const { style } = box.current!;
    style.setProperty('--line', `${rowHeight.current}px`);
    style.setProperty('--head', `${box.current!.querySelector<HTMLElement>('.head')!.offsetHeight}px`);
    look();
    const observer = new ResizeObserver(look);
    observer.observe(box.current!);
    return () => observer.disconnect();
  }, [lines, foldBelow]);
  useEffect(look, [props.rows.length]);
  useEffect(() => {
    const element = box.current;
    if (!element || !current) return;
    const top = current.row * rowHeight.current;
    const head = element.querySelector<HTMLElement>('.head')?.offsetHeight ?? rowHeight.current;
    if (top < element.scrollTop) element.scrollTop = top;
    else if (top + head + rowHeight.current > element.scrollTop + element.clientHeight)
      element.scrollTop = top + head + rowHeight.current - element.clientHeight;
  }, [current?.row, current?.column]);

  const set = (cell: GridCell, event: MouseEvent | KeyboardEvent) => {
    setOwn(cell);
    props.onCurrent?.(cell, event);
  };
  const onKeyDown = (event: KeyboardEvent) => {
    if (event.target !== box.current) return; // an editor in a cell
    const cell = current ?? { row: 0, column: 0 };
    const page = Math.max(1, Math.floor((box.current?.clientHeight ?? 300) / rowHeight.current) - 2);
    const moves: Record<string, GridCell> = {
      ArrowUp: { ...cell, row: cell.row - 1 },
      ArrowDown: { ...cell, row: cell.row + 1 },
      ArrowLeft: { ...cell, column: cell.column - 1 },
      ArrowRight: { ...cell, column: cell.column + 1 },
      PageUp: { ...cell, row: cell.row - page },
      PageDown: { ...cell, row: cell.row + page },
      Home: event.ctrlKey ? { row: 0, column: cell.column } : { ...cell, column: 0 },
      End: event.ctrlKey
        ? { row: props.rows.length - 1, column: cell.column }
        : { ...cell, column: props.columns.length - 1 },
    };
    const to = moves[event.key];
    if (to && !event.altKey && !event.metaKey) {
      event.preventDefault();
      set(
        {
          row: Math.min(props.rows.length - 1, Math.max(0, to.row)),
          column: Math.min(props.columns.length - 1, Math.max(0, to.column)),
        },
        event,
      );
    } else if (event.key === 'Enter' && props.onOpen && current) {
      event.preventDefault();
      props.onOpen(current);
    } else {
      props.onKey?.(event, cell);
    }
  };

  const isBelow = (column: Column<Row>) => folded && column.folds !== undefined;
  const beside = props.columns
    .map((its, c) => (folded && its.foldedWidth ? scaled(its.foldedWidth, factor) : widths[c]!))
    .filter((_, c) => !isBelow(props.columns[c]!));
  const template = { gridTemplateColumns: beside.join(' '), minWidth: `${least(beside)}px` };
  /** The place of a cell in a further line. */
  const place = (column: Column<Row>) => {
    if (!isBelow(column)) return undefined;
    if (column.folds === 'hidden') return { display: 'none' };
    const gridRow = lineOf(column);
    const figures = props.columns.filter((its) => its.folds === 'figure' && lineOf(its) === gridRow);
    const width = (its: Column<Row>[]) => its.reduce((sum, one) => sum + (one.spans ?? 1), 0);
    const end = -1 - width(figures.slice(figures.indexOf(column) + 1));
    return {
      gridRow,
      gridColumn:
        column.folds === 'text' ? `1 / ${-1 - width(figures)}` : `${end - (column.spans ?? 1)} / ${end}`,
    };
  };
  const line = folded ? { ...template, height: `${rowHeight.current}px` } : template;
  const first = Math.min(range.first, props.rows.length);
  const last = Math.min(range.last, props.rows.length);
  const side = (column: Column<Row>) =>
    `${column.align === 'right' ? 'right' : ''} ${isBelow(column) ? 'below' : ''} ${
      wraps && column.wraps ? 'wraps' : ''
    }`;
  return (
    <div
      class={`grid ${folded ? 'folded' : ''}`}
      role="grid"
      tabIndex={0}
      ref={box}
      aria-label={props.label}
      aria-rowcount={props.rows.length + 1}
      aria-multiselectable={props.rowSelected ? true : undefined}
      aria-activedescendant={current ? `${id}-${current.row}-${current.column}` : undefined}
      style={props.height ? { height: props.height } : undefined}
      onScroll={look}
      onKeyDown={onKeyDown}
    >
      <div class="head" role="row" style={template}>
        {props.columns.map((column) => {
          const sorted = props.sort?.key === column.key;
          return (
            <div
              key={column.key}
              role="columnheader"
              class={side(column)}
              style={place(column)}
              {...(column.sortable && {
                'aria-sort': sorted ? (props.sort?.down ? 'descending' : 'ascending') : 'none',
                title: t.value.shell.sortBy(column.title),
                onClick: () => props.onSort?.(column.key),
              })}
            >
              {isBelow(column) && column.foldedTitle ? column.foldedTitle : column.title}
              {sorted && <span aria-hidden="true">{props.sort?.down ? '▾' : '▴'}</span>}
            </div>
          );
        })}
      </div>
      {props.rows.length === 0 && <div class="empty">{props.empty ?? t.value.shell.nothing}</div>}
      <div style={{ height: `${first * rowHeight.current}px` }} />
      {props.rows.slice(first, last).map((row, offset) => {
        const index = first + offset;
        return (
          <div
            key={props.rowKey(row, index)}
            class={`line ${props.rowClass?.(row, index) ?? ''}`}
            role="row"
            aria-rowindex={index + 2}
            aria-selected={props.rowSelected?.(row, index)}
            style={line}
          >
            {props.columns.map((column, c) => (
              // biome-ignore lint/a11y/useKeyWithClickEvents: the grid takes the keyboard
              <div
                key={column.key}
                id={`${id}-${index}-${c}`}
                role="gridcell"
                tabIndex={-1}
                style={place(column)}
                class={`${side(column)} ${column.cellClass?.(row, index) ?? ''} ${
                  current?.row === index && current.column === c ? 'current' : ''
                }`}
                onClick={(event) => {
                  set({ row: index, column: c }, event);
                  // A click into an editor of the cell stays there.
                  if (!(event.target as Element).closest('input, select, button, a')) box.current?.focus();
                }}
                onDblClick={() => props.onOpen?.({ row: index, column: c })}
              >
                {column.cell(row, index)}
              </div>
            ))}
          </div>
        );
      })}
      <div style={{ height: `${Math.max(0, props.rows.length - last) * rowHeight.current}px` }} />
    </div>
  );
}
