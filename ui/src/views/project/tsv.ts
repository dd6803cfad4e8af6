// Tables on the clipboard, as spreadsheets write them: tabs between cells, quotes around cells with tabs,
// line ends or quotes. Pure.

/** The cells of a pasted text. The line end after the last row makes no row of its own. */
export function parseTable(text: string): string[][] {
  const rows: string[][] = [];
  let row: string[] = [];
  let cell = '';
  let quoted = false;
  let fresh = true; // at the begin of a cell
  const endCell = () => {
    row.push(cell);
    cell = '';
    fresh = true;
  };
  const endRow = () => {
    endCell();
    rows.push(row);
    row = [];
  };
  for (let i = 0; i < text.length; ++i) {
    const c = text[i]!;
    if (quoted) {
      if (c !== '"') cell += c;
      else if (text[i + 1] === '"') {
        cell += '"';
        ++i;
      } else quoted = false;
    } else if (c === '"' && fresh && closes(text, i)) {
      quoted = true;
      fresh = false;
    } else if (c === '\t') {
      endCell();
    } else if (c === '\n' || c === '\r') {
      if (c === '\r' && text[i + 1] === '\n') ++i;
      endRow();
    } else {
      cell += c;
      fresh = false;
    }
  }
  if (cell !== '' || row.length > 0 || !fresh) endRow();
  return rows;
}

/** Whether the quote that opens a cell has a quote that ends it; a name may begin with a quote too. */
function closes(text: string, open: number): boolean {
  for (let i = open + 1; i < text.length; ++i) {
    if (text[i] !== '"') continue;
    if (text[i + 1] === '"') ++i;
    else return i + 1 === text.length || /[\t\r\n]/.test(text[i + 1]!);
  }
  return false;
}

export function formatTable(rows: string[][]): string {
  return rows.map((row) => row.map(formatCell).join('\t')).join('\n');
}
const formatCell = (cell: string) => (/[\t\r\n"]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell);

const HEADINGS = [
  'имя( переменной)?',
  'тип( переменной)?',
  'адрес регистра',
  'функция (чтения|записи)',
  'ім.я змінної',
  'тип змінної',
  'variable name',
  'variable type',
  'register address',
  'read function',
];
const HEADING = new RegExp(`^(${HEADINGS.join('|')})$`, 'i');
/** Whether the first row has headings of the IDE: then the table is imported by them. */
export function hasHeadings(cells: string[][]): boolean {
  return (cells[0] ?? []).filter((its) => HEADING.test(its.trim())).length >= 2;
}
