// The columns of the tables, in the order of the IDE's tables: what is copied there can be pasted here.
import type { Mapping } from '../../api/types';
import type { CellKind } from './cells';
import type { CellColumn } from './rows';

export type TableObject = 'variable' | 'local' | 'served_variable' | 'bank';
export interface TableColumn extends CellColumn {
  width: string;
  /** As in a Grid, while not all columns are shown. */
  folds?: 'text' | 'figure';
  foldedWidth?: string;
  /** Shown without "all columns". */
  main: boolean;
  right?: boolean;
  wants?: 'bool' | 'int';
  /** What a check box shows while the key is not in the file. */
  usual?: boolean;
}

const column = (
  key: string,
  kind: CellKind,
  width: string,
  rest: Partial<TableColumn> = {},
): TableColumn => ({ key, kind, width, main: false, ...rest });
const MAIN = { main: true };

/** In the second line of a narrow table. */
const FIGURE = { folds: 'figure' } as const;

const name = column('name', 'text', 'minmax(136px, 1.4fr)', {
  main: true,
  foldedWidth: 'minmax(82px, 1.2fr)',
});
const type = column('type', 'type', 'minmax(126px, 0.8fr)', {
  main: true,
  foldedWidth: 'minmax(93px, 1.2fr)',
});
const comment = column('comment', 'text', 'minmax(120px, 1fr)', { main: true, folds: 'text' });
const register = column('register', 'number', '84px', { main: true, right: true, foldedWidth: '64px' });
const bit = column('bit', 'number', '52px', { main: true, right: true, ...FIGURE });
const used = column('used', 'boolean', '112px', { usual: true, ...FIGURE });
const retain = column('retain', 'boolean', '128px', FIGURE);
const min_interval = column('min_interval', 'duration', '120px', { right: true });
const burst = column('burst', 'number', '70px', { right: true });
const value = column('default', 'text', '110px', { right: true });
const scaling = [
  column('scale', 'number', '80px', { right: true }),
  column('offset', 'number', '80px', { right: true }),
];
const area = column('area', 'word', '140px', FIGURE);
const words = [column('enumeration', 'words', '150px'), column('bits', 'words', '150px')];

export const COLUMNS: Record<TableObject, TableColumn[]> = {
  variable: [
    name,
    type,
    column('read', 'function', '84px', { main: true, foldedWidth: '66px' }),
    column('write', 'function', '84px', { main: true, foldedWidth: '66px' }),
    register,
    bit,
    comment,
    column('write_on_change', 'boolean', '100px', { main: true, ...FIGURE }),
    column('period', 'duration', '90px', { main: true, right: true, ...FIGURE }),
    column('unit', 'text', '72px', { main: true, ...FIGURE }),
    column('coil', 'number', '70px', { right: true }),
    column('reference', 'text', '110px', { right: true }),
    column('length', 'number', '90px', { right: true }),
    area,
    column('read_trigger', 'local', '130px', { wants: 'bool' }),
    column('write_trigger', 'local', '130px', { wants: 'bool' }),
    column('status', 'local', '120px', { wants: 'int' }),
    column('deadline', 'duration', '110px', { right: true }),
    min_interval,
    burst,
    column('max_age', 'duration', '120px', { right: true }),
    value,
    column('hold_last', 'boolean', '110px'),
    retain,
    used,
    ...scaling,
    column('dead_band', 'number', '90px', { right: true }),
    column('write_range', 'text', '110px', { right: true }),
    column('byte_order', 'text', '100px'),
    column('verify', 'boolean', '110px'),
    column('safe_to_repeat', 'boolean', '110px'),
    ...words,
    column('tags', 'list', '120px'),
  ],
  local: [
    name,
    type,
    { ...retain, main: true },
    { ...value, main: true },
    { ...used, main: true },
    comment,
    min_interval,
    burst,
  ],
  served_variable: [
    name,
    type,
    register,
    { ...used, main: true },
    comment,
    { ...area, main: true },
    bit,
    column('source', 'source', 'minmax(140px, 1fr)', MAIN),
    value,
    ...scaling,
    column('coil', 'number', '70px', { right: true }),
    column('length', 'number', '90px', { right: true }),
    column('writes_to', 'source', '150px'),
    column('max_age', 'duration', '120px', { right: true }),
    column('answer', 'word', '120px'),
    column('byte_order', 'text', '100px'),
    ...words,
  ],
  bank: [
    column('area', 'word', 'minmax(140px, 1fr)', MAIN),
    column('items', 'list', 'minmax(100px, 1fr)', MAIN),
    column('read_only', 'list', '110px', MAIN),
    column('retain', 'list', '110px', MAIN),
    column('overlay', 'word', '140px'),
    column('overlay_register', 'number', '120px', { right: true }),
  ],
};

/** The first row of an empty table. */
export function firstRow(object: TableObject, name: string): Mapping {
  switch (object) {
    case 'local':
      return { name, type: 'bool' };
    case 'bank':
      return { area: 'holding_register', items: ['0..99'] };
    case 'served_variable':
      return { name, type: 'int16', area: 'holding_register', register: '0' };
    default:
      return { name, type: 'int16', register: '0', read: '0x03' };
  }
}
