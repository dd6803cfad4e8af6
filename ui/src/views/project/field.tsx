// A labelled field of a form, bound to a key of the draft: the text, the permitted range, and its finding.
import type { ComponentChildren } from 'preact';
import { useState } from 'preact/hooks';
import type { FieldRule, Finding, Mapping, Node } from '../../api/types';
import { t } from '../../i18n';
import { at, formatPath, isMapping, type Path } from '../../store/document';
import { draft, findingsByPath } from '../../store/project';
import { Hint } from '../../widgets/hint';
import { Mark } from '../../widgets/mark';
import { type CellKind, durationText, isYes, milliseconds, nodeText, plainType, rawOf } from './cells';
import { isProtected, readOnly, setKey } from './edit';
import { LocalPick } from './local_pick';
import { boundText, hintText, keyText, rangeText, rulesAt, wordText } from './rules';
import { isNetwork, serverTransportOf, transportOf } from './tree';
import { functionChoice, protocolText, wordType } from './words';

const NO_FINDINGS: Finding[] = [];

export interface Bound {
  id: string;
  node: Node | undefined;
  text: string;
  findings: Finding[];
  locked: boolean;
  set: (value: Node | undefined) => void;
}

/** A key of an object of the draft. */
export function bound(path: Path, key: string): Bound {
  const id = formatPath([...path, key]);
  const object = at(draft.value, path);
  const node = isMapping(object) ? (object[key] as Node | undefined) : undefined;
  return {
    id,
    node,
    text: nodeText(node),
    findings: findingsByPath.value.get(id) ?? NO_FINDINGS,
    locked: isProtected(key) || readOnly([...path, key]) !== null,
    set: (value) => setKey(path, key, value),
  };
}

export const isWrong = (findings: Finding[]) => findings.some((its) => its.severity === 'error');

/** A text box that keeps what is typed while the file has another notation of it: "200" is "200ms". */
export function TextBox(props: {
  id: string;
  text: string;
  findings: Finding[];
  disabled?: boolean;
  placeholder?: string;
  numeric?: boolean;
  label?: string;
  /** Returns the text that the draft has then. */
  onText: (text: string) => string;
}) {
  const [typed, setTyped] = useState<{ text: string; of: string } | null>(null);
  // After an undo the draft has another text than the one that was typed.
  const shown = typed && typed.of === props.text ? typed.text : props.text;
  return (
    <input
      id={props.id}
      type="text"
      value={shown}
      inputMode={props.numeric ? 'numeric' : undefined}
      placeholder={props.placeholder}
      disabled={props.disabled}
      aria-label={props.label}
      aria-invalid={isWrong(props.findings)}
      aria-describedby={props.findings.length > 0 ? `${props.id}-tip` : undefined}
      spellcheck={false}
      autocomplete="off"
      onInput={(event) => {
        const text = event.currentTarget.value;
        setTyped({ text, of: props.onText(text) });
      }}
      onBlur={() => setTyped(null)}
    />
  );
}

export function Row(props: {
  id: string;
  label: ComponentChildren;
  hint?: string | undefined;
  findings?: Finding[];
  note?: ComponentChildren;
  /** What the label means. */
  help?: string | undefined;
  wide?: boolean;
  children: ComponentChildren;
}) {
  return (
    <div class={`field ${props.wide ? 'wide' : ''}`}>
      <label for={props.id}>{props.label}</label>
      <div class="control">
        {props.children}
        {props.hint && <span class="range muted small">{props.hint}</span>}
        {props.help && <Hint text={props.help} />}
        <Mark id={`${props.id}-tip`} findings={props.findings ?? NO_FINDINGS} />
      </div>
      {props.note && <p class="note muted small">{props.note}</p>}
    </div>
  );
}

const CELL_KINDS: Record<string, CellKind> = {
  duration: 'duration',
  number: 'number',
  integer: 'number',
  ranges: 'list',
  list: 'list',
  words: 'words',
};
/** Nested mappings and lists of mappings have no field: they are shown as text. */
const isNested = (node: Node | undefined, rule: FieldRule | undefined) =>
  (isMapping(node) && rule?.kind !== 'words') || (Array.isArray(node) && node.some(isMapping));

function defaultText(rule: FieldRule | undefined): string {
  const its = rule?.default;
  if (its === undefined || its === null) return '';
  if (rule?.kind === 'boolean') return t.value.shell[isYes(its) ? 'yes' : 'no'];
  return rule?.kind === 'word'
    ? wordText(its)
    : rule?.kind === 'duration'
      ? boundText(milliseconds(its) ?? 0)
      : its;
}

// The values of keys that are not in the file, where the rule does not name them.
const USUAL: Record<string, string> = {
  used: 'true',
  derive_timeouts: 'true',
  high_byte_first: 'true',
  write: 'none',
};

function wordName(rule: FieldRule, word: string, path: Path, name: string): string {
  if (name === 'framing') return protocolText(transportAt(path), word);
  if (rule.kind === 'boolean') return t.value.shell[word === 'true' ? 'yes' : 'no'];
  if (rule.kind === 'function') return functionChoice(word);
  return rule.words?.includes('uint16') ? wordType(word) : wordText(word);
}

const transportAt = (path: Path) =>
  path[0] === 'servers' ? serverTransportOf(objectAt(path)) : transportOf(objectAt(path));

/** What counts while the key is not in the file. */
function fallbackText(path: Path, name: string, rule: FieldRule): string {
  if (name === 'transport' && path[0] !== 'outputs') return wordText(transportAt(path));
  if (name === 'framing') {
    const transport = transportAt(path);
    return protocolText(transport, isNetwork(transport) ? 'tcp' : 'rtu');
  }
  return defaultText(rule);
}

function Choice(props: { its: Bound; rule: FieldRule; path: Path; name: string; label: string }) {
  const { its, rule, name, label } = props;
  const boolean = rule.kind === 'boolean';
  const allowed = rule.allowed ? rule.allowed.split(/,\s*/) : (rule.words ?? []);
  const words = boolean
    ? ['true', 'false']
    : (rule.words ?? allowed).filter((one) => allowed.includes(one) && plainType(one) === one);
  // The default of `on_change` depends on the period of the output.
  const fixed = boolean && name !== 'on_change';
  const usual = USUAL[name] ?? (fixed ? (rule.default ?? 'false') : undefined);
  const text = (boolean && its.text ? String(isYes(its.text)) : plainType(its.text)) || (usual ?? '');
  return (
    <select
      id={its.id}
      value={text}
      disabled={its.locked}
      aria-label={label}
      aria-invalid={isWrong(its.findings)}
      onChange={(event) => {
        const value = event.currentTarget.value;
        its.set(value === '' || value === usual ? undefined : value);
      }}
    >
      {usual === undefined && (!rule.required || text === '') && (
        <option value="">{t.value.project.notSet(fallbackText(props.path, name, rule))}</option>
      )}
      {text !== '' && !words.includes(text) && (
        <option value={text}>{wordName(rule, text, props.path, name)}</option>
      )}
      {words.map((word) => (
        <option key={word} value={word}>
          {wordName(rule, word, props.path, name)}
        </option>
      ))}
    </select>
  );
}

/** The control for a key, by the kind of its rule. */
function Control(props: {
  its: Bound;
  path: Path;
  name: string;
  rule?: FieldRule;
  label: string;
  hint?: string;
}) {
  const { its, rule, label, hint } = props;
  if (isNested(its.node, rule))
    return (
      <span class="nested small" title={t.value.project.inFile}>
        {its.text}
      </span>
    );
  if (rule?.kind === 'boolean' || rule?.kind === 'word' || (rule?.kind === 'function' && rule.words))
    return <Choice its={its} rule={rule} path={props.path} name={props.name} label={label} />;
  if (rule?.kind === 'local_bool' || rule?.kind === 'local_integer')
    return <LocalPick its={its} wants={rule.kind === 'local_bool' ? 'bool' : 'int'} label={label} />;
  const kind = CELL_KINDS[rule?.kind ?? ''] ?? 'text';
  const shown = (node: Node | undefined) =>
    kind === 'duration' ? durationText(nodeText(node)) : nodeText(node);
  return (
    <TextBox
      id={its.id}
      text={shown(its.node)}
      findings={its.findings}
      disabled={its.locked}
      numeric={kind === 'number' || kind === 'duration'}
      placeholder={hint ?? defaultText(rule)}
      onText={(text) => {
        const raw = rawOf(kind, text);
        its.set(raw);
        return shown(raw);
      }}
    />
  );
}

/** A field for a key of an object, as its rule says. */
export function KeyField(props: {
  path: Path;
  object: string;
  name: string;
  label?: string;
  disabled?: boolean;
  note?: ComponentChildren;
  wide?: boolean;
  placeholder?: string;
}) {
  const rule = rulesAt(props.path, props.object)[props.name];
  const its = bound(props.path, props.name);
  const label = props.label ?? keyText(props.name, props.object);
  const findings = props.disabled ? its.findings.filter((one) => one.severity === 'error') : its.findings;
  const state = { ...its, findings, locked: its.locked || (props.disabled ?? false) };
  return (
    <Row
      id={its.id}
      label={label}
      hint={rangeText(rule)}
      help={hintText(props.name, props.object)}
      findings={findings}
      note={props.note ?? (isProtected(props.name) ? t.value.project.onlyInFile : undefined)}
      wide={props.wide ?? false}
    >
      <Control
        path={props.path}
        name={props.name}
        its={state}
        label={label}
        {...(rule && { rule })}
        {...(props.placeholder && { hint: props.placeholder })}
      />
    </Row>
  );
}

export function objectAt(path: Path): Mapping {
  const node = at(draft.value, path);
  return isMapping(node) ? node : {};
}
