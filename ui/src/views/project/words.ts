// Words of types and protocols in the current language.
import { t } from '../../i18n';
import { functionName } from '../requests/words';
import { type CellKind, durationText, isYes, plainType } from './cells';
import { wordText } from './rules';

export function wordType(type: string): string {
  return (t.value.project.types as Record<string, string>)[plainType(type)] ?? type;
}

/** Names of protocols: framings, on their transport. */
export function protocolText(transport: string, framing: string): string {
  const texts = t.value.project.protocol;
  if (framing === 'rtu' && transport === 'tcp') return texts.rtuOverTcp;
  return (texts as unknown as Record<string, string>)[framing] ?? framing;
}

export function functionText(word: string): string {
  return word === 'none' ? t.value.project.functions.none : word;
}
/** The text of a cell for people. */
export function wordsOf(kind: CellKind | undefined, text: string): string {
  if (text === '') return text;
  if (kind === 'type') return wordType(text);
  if (kind === 'function') return functionText(text);
  if (kind === 'word') return wordText(text);
  if (kind === 'duration') return durationText(text);
  return kind === 'boolean' ? t.value.live.boolean[isYes(text) ? 'on' : 'off'] : text;
}
/** "0x03: Read holding registers" */
export function functionChoice(word: string): string {
  return word === 'none' ? functionText(word) : `${word}: ${functionName(Number(word))}`;
}
