// The picker of the IDE: standard, service and network variables, a search, and a new variable.
import { useMemo, useRef, useState } from 'preact/hooks';
import { t } from '../../i18n';
import { Dialog } from '../../shell/dialog';
import { draft } from '../../store/project';
import { Icon } from '../../widgets/icon';
import { TabBar } from './tab_bar';
import { typeClass } from './cells';
import {
  type Choice,
  type ChoiceKind,
  type ChoiceTab,
  choicesOf,
  fitsType,
  searched,
  type Wanted,
} from './choices';
import { addLocal, takenNames } from './edit';
import { nextName } from './rows';
import { keyText } from './rules';
import { wordType } from './words';

const MOST_SHOWN = 400;
/** As in the IDE. */
const COLUMNS = ['name', 'type', 'retain', 'default', 'used', 'comment'];

export interface PickerProps {
  wants: Wanted;
  kinds: ChoiceKind[];
  value: string;
  newName: string;
  onPick: (name: string | undefined, kind: ChoiceKind) => void;
  onClose: () => void;
}

function tabTitle(its: ChoiceTab, count: number): string {
  const texts = t.value.project.picker;
  return its.kind === 'network' ? texts.network(its.slot, its.line, count) : texts[its.kind](count);
}

function List(props: {
  choices: Choice[];
  program: string;
  value: string;
  allowed: (its: Choice) => boolean;
  onValue: (name: string) => void;
  onAccept: () => void;
}) {
  const box = useRef<HTMLDivElement>(null);
  const shown = props.choices.slice(0, MOST_SHOWN);
  const move = (event: KeyboardEvent) => {
    const open = shown.filter(props.allowed);
    const now = open.findIndex((its) => its.name === props.value);
    const steps: Record<string, number> = { ArrowDown: 1, ArrowUp: -1, PageDown: 10, PageUp: -10 };
    const step = steps[event.key];
    if (step === undefined || open.length === 0) return;
    event.preventDefault();
    const next = Math.min(open.length - 1, Math.max(0, now < 0 ? 0 : now + step));
    props.onValue(open[next]!.name);
    box.current
      ?.querySelector(`[data-name="${CSS.escape(open[next]!.name)}"]`)
      ?.scrollIntoView({ block: 'nearest' });
  };
  let group: string | null = null;
  return (
    <div
      class="choices"
      role="listbox"
      tabIndex={0}
      ref={box}
      aria-label={t.value.project.picker.title}
      onKeyDown={move}
    >
      {shown.length === 0 && <p class="muted">{t.value.project.picker.nothing}</p>}
      {shown.map((its) => {
        const heading = its.group !== group && (its.group !== '' || props.program !== '');
        group = its.group;
        const open = props.allowed(its);
        return (
          <>
            {heading && (
              <div class="group" role="presentation">
                {its.group || props.program}
              </div>
            )}
            {/* biome-ignore lint/a11y/useKeyWithClickEvents: the list box takes the keyboard */}
            <div
              key={its.name}
              role="option"
              data-name={its.name}
              aria-selected={its.name === props.value}
              aria-disabled={!open}
              class="choice"
              onClick={() => open && props.onValue(its.name)}
              onDblClick={() => open && props.onAccept()}
            >
              <span class={typeClass(its.type)}>{its.name}</span>
              <span class="muted small">{wordType(its.type)}</span>
              <span class={`small ${its.retain ? '' : 'usual'}`} data-title={keyText('retain')}>
                {its.retain ? '☑' : '☐'}
              </span>
              <span class="small" data-title={keyText('default')}>
                {its.initial}
              </span>
              <span class={`small ${its.used ? 'usual' : ''}`} data-title={keyText('used')}>
                {its.used ? t.value.shell.yes : t.value.shell.no}
              </span>
              <span class="muted small comment">{its.comment}</span>
            </div>
          </>
        );
      })}
    </div>
  );
}

export function Picker(props: PickerProps) {
  const texts = t.value.project.picker;
  const tabs = useMemo(() => choicesOf(draft.value), [draft.value]);
  const holding = tabs.findIndex((its) => its.choices.some((one) => one.name === props.value));
  const [tab, setTab] = useState(Math.max(0, holding));
  const [search, setSearch] = useState('');
  const [value, setValue] = useState(props.value);
  const [creating, setCreating] = useState<string | null>(null);
  const its = tabs[tab] ?? tabs[0]!;
  const usable = props.kinds.includes(its.kind);
  const allowed = (one: Choice) => usable && fitsType(one.type, props.wants);
  const accept = () => {
    if (creating !== null) {
      addLocal(creating, props.wants === 'int' ? 'int' : 'bool');
      props.onPick(creating, 'standard');
    } else {
      const kind = tabs.find((one) => one.choices.some((choice) => choice.name === value))?.kind;
      props.onPick(value || undefined, kind ?? 'standard');
    }
    props.onClose();
  };
  const taken = creating !== null && (creating.trim() === '' || takenNames().has(creating));
  const hint = usable
    ? texts.fits[props.wants]
    : its.kind === 'network'
      ? texts.notNetwork
      : texts.notService;
  return (
    <Dialog title={texts.title} onAccept={accept} acceptDisabled={taken} onClose={props.onClose}>
      <div class="picker">
        <TabBar
          name="picker"
          label={texts.tabs}
          value={String(tab)}
          tabs={tabs.map((one, i) => ({
            value: String(i),
            title: tabTitle(one, searched(one.choices, search).length),
          }))}
          onValue={(to) => setTab(Number(to))}
        />
        <p class="muted small">{texts.kinds[its.kind]}</p>
        <div class="tools">
          <label class="search">
            <Icon name="search" />
            <input
              type="search"
              autofocus
              placeholder={texts.search}
              aria-label={texts.search}
              value={search}
              onInput={(event) => setSearch(event.currentTarget.value)}
            />
          </label>
          <button type="button" class="button" onClick={() => setValue('')} aria-pressed={value === ''}>
            {texts.clear}
          </button>
          <button
            type="button"
            class="button"
            onClick={() =>
              setCreating(
                takenNames().has(props.newName) ? nextName(props.newName, takenNames()) : props.newName,
              )
            }
          >
            <Icon name="add" />
            {texts.create}
          </button>
        </div>
        {creating !== null && (
          <div class="creating">
            <label for="picker-new">{texts.created}</label>
            <input
              id="picker-new"
              type="text"
              value={creating}
              aria-invalid={taken}
              ref={(element) => {
                if (element && !element.dataset.shown) {
                  element.dataset.shown = '1';
                  element.focus();
                  element.select();
                }
              }}
              onInput={(event) => setCreating(event.currentTarget.value)}
            />
            {taken && <span class="bad small">{texts.taken}</span>}
            <button
              type="button"
              class="icon-button"
              aria-label={t.value.shell.cancel}
              onClick={() => setCreating(null)}
            >
              <Icon name="close" />
            </button>
          </div>
        )}
        <div role="tabpanel" id="picker-panel" aria-labelledby={`picker-${tab}`}>
          <div class="headings" aria-hidden="true">
            {COLUMNS.map((key) => (
              <span key={key} class="muted small">
                {keyText(key)}
              </span>
            ))}
          </div>
          <List
            choices={searched(its.choices, search)}
            program={its.kind === 'service' ? texts.program : ''}
            value={value}
            allowed={allowed}
            onValue={(name) => {
              setCreating(null);
              setValue(name);
            }}
            onAccept={accept}
          />
        </div>
        {hint && <p class="muted small">{hint}</p>}
      </div>
    </Dialog>
  );
}
