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
  'ім.я( змінної)?',
  'тип змінної',
  'адреса регістра',
  'функція (читання|запису)',
  'name',
  'type',
  'register',
  'coil',
  'variable name',
  'variable type',
  'register address',
  'read function',
];
/** The names of the fields in the windows of the IDE, at the begin of a line. */
const FIELDS = [
  'имя',
  'тип',
  'адрес',
  'регистр',
  'бит',
  'период( опроса)?(, мс)?',
  'таймаут ответа(, мс)?',
  'кол-во попыток',
  'кол-во регистров в запросе',
  'группировать запросы',
  'протокол',
  'функция (чтения|записи)',
  'запись по изменению',
  'порядок байт',
];
const whole = (words: string[]) => new RegExp(`^(${words.join('|')})$`, 'i');
const HEADING = whole(HEADINGS);
const FIELD = whole(FIELDS);

/**
 * Whether a text is a table or a window of the IDE, which the import understands: a line has headings, or
 * lines consist of the name of a field and its value.
 */
export function isImport(text: string): boolean {
  const separator = text.includes(';') ? ';' : ',';
  const rows = text.includes('\t')
    ? parseTable(text)
    : text.split(/\r?\n/).map((line) => line.split(separator));
  const headings = (row: string[]) => row.filter((its) => HEADING.test(its.trim())).length;
  const fields = new Set(text.split(/\r?\n/).map(fieldOf));
  fields.delete('');
  return rows.some((row) => headings(row) >= 2) || fields.size >= 2;
}

/** The name of the field in a line of a window; empty: it is none. */
function fieldOf(line: string): string {
  const parts = /^([^;:\t]+)[;:\t](.+)$/.exec(line) ?? /^([^,]+),([^,]+)$/.exec(line);
  if (parts === null) return '';
  const name = parts[1]!.trim().toLowerCase();
  const values = parts[2]!.split('\t').filter((its) => its.trim() !== '');
  return FIELD.test(name) && values.length === 1 ? name : '';
}
