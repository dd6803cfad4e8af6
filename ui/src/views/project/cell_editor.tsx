// The editor in a cell of a table. Enter and Tab take the text over, Escape leaves the cell as it was.
import { useLayoutEffect, useRef } from 'preact/hooks';
import { t } from '../../i18n';
import { plainType, TYPES } from './cells';
import type { TableColumn } from './columns';
import { keyText, wordText } from './rules';
import { functionChoice, wordType } from './words';

const FUNCTIONS = {
  read: ['none', '0x01', '0x02', '0x03', '0x04'],
  write: ['none', '0x05', '0x06', '0x0F', '0x10'],
};
const WORDS: Record<string, string[]> = {
  area: ['coil', 'discrete_input', 'input_register', 'holding_register'],
  overlay: ['input_register', 'holding_register'],
  answer: ['when_done', 'at_once'],
};

/** The words of a cell that is chosen from a list, with their texts; undefined: it is typed. */
export function cellChoices(column: TableColumn): [string, string][] | undefined {
  if (column.kind === 'type') return TYPES.map((its) => [its, wordType(its)]);
  if (column.kind === 'function')
    return FUNCTIONS[column.key === 'write' ? 'write' : 'read'].map((its) => [its, functionChoice(its)]);
  if (column.kind === 'word') return WORDS[column.key]?.map((its) => [its, wordText(its)]);
  return undefined;
}

export function CellEditor(props: {
  column: TableColumn;
  text: string;
  /** Where the editor goes after the text is taken over. */
  onCommit: (text: string, then: 'down' | 'right' | 'left' | 'stay') => void;
  onCancel: () => void;
}) {
  const element = useRef<HTMLInputElement & HTMLSelectElement>(null);
  const choices = cellChoices(props.column);
  const value = props.column.kind === 'type' ? plainType(props.text) : props.text;
  const done = useRef(false);
  // The next key already belongs to the editor. Its value is set once and is no property: each evaluation
  // draws the table again, which must not undo what was typed or chosen meanwhile.
  useLayoutEffect(() => {
    element.current!.value = value;
    element.current?.focus();
    const end = props.text.length;
    if (element.current instanceof HTMLInputElement) element.current.setSelectionRange(end, end);
  }, []);
  const commit = (then: 'down' | 'right' | 'left' | 'stay') => {
    if (done.current) return;
    done.current = true;
    props.onCommit(element.current?.value ?? '', then);
  };
  const onKeyDown = (event: KeyboardEvent) => {
    if (event.key === 'Escape') {
      done.current = true;
      props.onCancel();
    } else if (event.key === 'Enter') commit('down');
    else if (event.key === 'Tab') commit(event.shiftKey ? 'left' : 'right');
    else return;
    event.preventDefault();
    event.stopPropagation();
  };
  const common = {
    ref: element,
    class: 'cell-editor',
    'aria-label': t.value.project.table.edit(keyText(props.column.key)),
    onKeyDown,
    onBlur: () => commit('stay'),
  };
  if (!choices) return <input type="text" spellcheck={false} autocomplete="off" {...common} />;
  return (
    <select {...common}>
      {props.column.kind !== 'type' && <option value="">{t.value.project.notSet('')}</option>}
      {value !== '' && !choices.some(([word]) => word === value) && <option value={value}>{value}</option>}
      {choices.map(([word, text]) => (
        <option key={word} value={word}>
          {text}
        </option>
      ))}
    </select>
  );
}
