// The tree of lines, devices and servers, with the keyboard of the ARIA pattern.
import { computed, signal } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { t } from '../../i18n';
import { toast } from '../../shell/toasts';
import { formatPath, type Path } from '../../store/document';
import { draft, findings } from '../../store/project';
import { Icon } from '../../widgets/icon';
import {
  addDevice,
  addInstrument,
  addLine,
  addOutput,
  addServer,
  duplicateAt,
  readOnly,
  removeAt,
} from './edit';
import { wordText } from './rules';
import { select, selected } from './selection';
import { severities, type TreeItem, treeOf } from './tree';

const closed = signal<ReadonlySet<string>>(new Set());
const worst = computed(() => severities(findings.value));

function toggle(id: string): void {
  const next = new Set(closed.peek());
  if (!next.delete(id)) next.add(id);
  closed.value = next;
}

function titleOf(its: TreeItem): string {
  const texts = t.value.project.tree;
  const name = its.name || texts.unnamed;
  switch (its.kind) {
    case 'project':
      return texts.settings;
    case 'locals':
      return texts.locals;
    case 'unit':
      return texts.unit(name);
    case 'output':
      return texts.output(name);
    case 'instrument':
      return texts.instrument(name);
    default:
      return name;
  }
}

function Item(props: { its: TreeItem; current: boolean; open: boolean }) {
  const { its, current, open } = props;
  const texts = t.value.project.tree;
  const severity = worst.value.get(formatPath(its.path));
  const role = its.kind === 'line' ? texts.master : its.kind === 'server' ? texts.slave : '';
  return (
    // biome-ignore lint/a11y/useKeyWithClickEvents: the tree takes the keyboard
    <div
      role="treeitem"
      id={`tree-${its.id}`}
      aria-level={its.level}
      aria-selected={current}
      aria-expanded={its.children ? open : undefined}
      class={`item ${its.kind}`}
      style={{ '--level': its.level }}
      onClick={() => select(its.path)}
    >
      {its.children ? (
        <span
          class="twist"
          aria-hidden="true"
          onClick={(event) => {
            event.stopPropagation();
            toggle(its.id);
          }}
        >
          <Icon name={open ? 'down' : 'right'} />
        </span>
      ) : (
        <span class="twist" />
      )}
      <span class="title">
        {titleOf(its)}
        {role && <span class="muted small slot">{texts.slot(wordText(its.medium), its.slot, role)}</span>}
      </span>
      {its.count !== null && its.kind !== 'locals' && <span class="muted small">{its.count}</span>}
      {its.kind === 'locals' && <span class="muted small">{its.count}</span>}
      {severity && its.kind !== 'project' && (
        <span class={`cell-mark ${severity}`} aria-hidden="true">
          !
        </span>
      )}
    </div>
  );
}

const isRemovable = (path: Path) =>
  path.length >= 2 && ['lines', 'servers', 'outputs', 'instruments'].includes(String(path[0]));

function removeSelected(): void {
  const path = selected.peek();
  const its = treeOf(draft.peek(), () => true).find((one) => formatPath(one.path) === formatPath(path));
  removeAt(path);
  toast('info', t.peek().project.tree.removed(its ? titleOf(its) : ''));
}

function Tools() {
  const texts = t.value.project;
  const path = selected.value;
  const line = path[0] === 'lines' ? (path[1] as number) : null;
  const item = isRemovable(path);
  const locked = readOnly(path) !== null;
  return (
    <div class="tools">
      <button
        type="button"
        class="button"
        title={texts.tree.addDevice}
        disabled={locked || line === null}
        onClick={() => line !== null && addDevice(line, texts.tree.newDevice)}
      >
        <Icon name="add" />
        {texts.groups.device}
      </button>
      <span class="spring" />
      <button
        type="button"
        class="icon-button"
        title={texts.duplicate}
        aria-label={texts.duplicate}
        disabled={locked || !item}
        onClick={() => duplicateAt(path)}
      >
        <Icon name="copy" />
      </button>
      <button
        type="button"
        class="icon-button"
        title={texts.remove}
        aria-label={texts.remove}
        disabled={locked || !item}
        onClick={removeSelected}
      >
        <Icon name="delete" />
      </button>
    </div>
  );
}

export function Tree() {
  const box = useRef<HTMLDivElement>(null);
  const texts = t.value.project.tree;
  const items = treeOf(draft.value, (id) => !closed.value.has(id));
  const id = formatPath(selected.value) || 'project';
  const locked = readOnly([]) !== null;
  const groups = t.value.project.groups;
  const adders = [
    { name: groups.line, title: texts.addLine, add: () => addLine(texts.newLine) },
    { name: groups.server, title: texts.addServer, add: () => addServer(texts.newServer) },
    { name: groups.output, title: texts.addOutput, add: addOutput },
    { name: groups.instrument, title: texts.addInstrument, add: addInstrument },
  ];
  const go = (its: TreeItem | undefined) => {
    if (!its) return;
    select(its.path);
    document.getElementById(`tree-${its.id}`)?.scrollIntoView({ block: 'nearest' });
  };
  const onKeyDown = (event: KeyboardEvent) => {
    const now = items.findIndex((its) => its.id === id);
    const its = items[now];
    const open = its?.children && !closed.peek().has(its.id);
    const keys: Record<string, () => void> = {
      ArrowDown: () => go(items[now + 1]),
      ArrowUp: () => go(items[now - 1]),
      Home: () => go(items[0]),
      End: () => go(items.at(-1)),
      Delete: () => {
        if (isRemovable(selected.peek()) && readOnly(selected.peek()) === null) removeSelected();
      },
      ArrowRight: () => {
        if (its?.children && !open) toggle(its.id);
        else if (open) go(items[now + 1]);
      },
      ArrowLeft: () => {
        if (open) toggle(its.id);
        else if (its && its.level > 1) go(items.find((one) => one.id === formatPath(its.path.slice(0, 2))));
      },
    };
    const run = keys[event.key];
    if (!run) return;
    event.preventDefault();
    run();
  };
  return (
    <section class="tree-pane">
      <Tools />
      <div
        class="tree"
        role="tree"
        ref={box}
        tabIndex={0}
        aria-label={texts.label}
        aria-activedescendant={`tree-${id}`}
        onKeyDown={onKeyDown}
      >
        {items.map((its) => (
          <Item key={its.id} its={its} current={its.id === id} open={!closed.value.has(its.id)} />
        ))}
      </div>
      <div class="tools bottom">
        {adders.map((its) => (
          <button
            key={its.name}
            type="button"
            class="button quiet"
            title={its.title}
            disabled={locked}
            onClick={its.add}
          >
            <Icon name="add" />
            {its.name}
          </button>
        ))}
      </div>
    </section>
  );
}
