// Parts within parts: lists of objects and single objects, edited by the rules of the program, to any depth.
import type { FieldRule, Mapping, Node } from '../../api/types';
import { t } from '../../i18n';
import { at, formatPath, isMapping, type Path } from '../../store/document';
import { draft, findings } from '../../store/project';
import { Icon } from '../../widgets/icon';
import { readOnly, setKey } from './edit';
import { KeyField } from './field';
import { keyText, rulesAt } from './rules';
import { markOf } from './tree';

const LONGEST_TITLE = 60;

/** Whether a key has a part with fields of its own, and not one value. */
export const isPart = (rule: FieldRule | undefined) =>
  rule?.object !== undefined && (rule.kind === 'list' || rule.kind === 'mapping');

/** A new part: with the parts that it must have, so that their fields are shown. */
function newPart(path: Path, object: string): Mapping {
  const parts: Mapping = {};
  for (const [key, rule] of Object.entries(rulesAt(path, object)))
    if (rule.required && rule.object)
      parts[key] = rule.kind === 'list' ? [newPart(path, rule.object)] : newPart(path, rule.object);
  return parts;
}

/** The values of a node without their keys. */
function valuesOf(node: Node | undefined): string[] {
  if (Array.isArray(node)) return node.flatMap(valuesOf);
  if (!isMapping(node)) return typeof node === 'string' ? [node] : [];
  return Object.entries(node).flatMap(([key, value]) => (key === '$from' ? [] : valuesOf(value as Node)));
}

/** The title of an item: its name, or else its first values. */
function titleOf(item: Node | undefined): string {
  const its = isMapping(item) && typeof item.name === 'string' ? item.name : valuesOf(item).join(' · ');
  return its.length > LONGEST_TITLE ? `${its.slice(0, LONGEST_TITLE)}…` : its;
}

function worstIn(path: Path): string {
  const base = formatPath(path);
  const marks = findings.value.filter((its) => its.path.startsWith(base)).map(markOf);
  return marks.includes('error') ? 'error' : marks.includes('warning') ? 'warning' : '';
}

function Remove({ label, onClick }: { label: string; onClick: () => void }) {
  return (
    <button type="button" class="icon-button" title={label} aria-label={label} onClick={onClick}>
      <Icon name="delete" />
    </button>
  );
}

function OnePart(props: {
  path: Path;
  object: string;
  title: string;
  locked: boolean;
  onRemove?: () => void;
}) {
  const worst = worstIn(props.path);
  return (
    <div class="part">
      <details open={worst === 'error'}>
        <summary>
          <span class="title">{props.title}</span>
          {worst && (
            <span class={`cell-mark ${worst}`} aria-hidden="true">
              !
            </span>
          )}
        </summary>
        <PartFields path={props.path} object={props.object} />
      </details>
      {!props.locked && props.onRemove && (
        <Remove label={`${t.value.project.remove}: ${props.title}`} onClick={props.onRemove} />
      )}
    </div>
  );
}

/** All fields of an object, its own parts after them. */
function PartFields({ path, object }: { path: Path; object: string }) {
  const rules = Object.entries(rulesAt(path, object));
  return (
    <div class="part-fields">
      <div class="fields">
        {rules
          .filter(([, rule]) => !isPart(rule))
          .map(([key]) => (
            <KeyField key={key} path={path} object={object} name={key} />
          ))}
      </div>
      {rules
        .filter(([, rule]) => isPart(rule))
        .map(([key]) => (
          <Part key={key} path={path} object={object} name={key} />
        ))}
    </div>
  );
}

/** A key of an object whose value is a list of objects, or an object. */
export function Part({ path, object, name }: { path: Path; object: string; name: string }) {
  const rule = rulesAt(path, object)[name];
  if (!isPart(rule) || !rule?.object) return null;
  const inner = rule.object;
  const node = at(draft.value, [...path, name]);
  const locked = readOnly([...path, name]) !== null;
  // Where one object is expected, some keys take a list too.
  const listed = rule.kind === 'list' || Array.isArray(node);
  const items: Node[] = Array.isArray(node) ? node : isMapping(node) ? [node] : [];
  const set = (list: Node[]) => setKey(path, name, list.length > 0 || rule.required ? list : undefined);
  const add = () => {
    const part = newPart(path, inner);
    if (listed) set([...items, part]);
    else setKey(path, name, part);
  };
  const label = keyText(name, object);
  return (
    <section class="part-list" aria-label={label}>
      <h3>
        {label}
        {listed && items.length > 0 && <span class="muted"> ({items.length})</span>}
        {!locked && (listed || items.length === 0) && (
          <button type="button" class="button quiet small" onClick={add}>
            <Icon name="add" />
            {t.value.project.table.add}
          </button>
        )}
      </h3>
      {items.map((item, i) => {
        const its = listed ? [...path, name, i] : [...path, name];
        return (
          <OnePart
            key={i}
            path={its}
            object={inner}
            title={listed ? [i + 1, titleOf(item)].filter(Boolean).join(': ') : titleOf(item) || label}
            locked={locked}
            {...((listed || !rule.required) && {
              onRemove: () =>
                listed ? set(items.filter((_, one) => one !== i)) : setKey(path, name, undefined),
            })}
          />
        );
      })}
    </section>
  );
}
