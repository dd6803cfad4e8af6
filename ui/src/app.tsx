import { computed, effect, signal } from '@preact/signals';
import type { ComponentType } from 'preact';
import { LANGUAGES, type Language, language, setLanguage, t } from './i18n';
import { keepFocus } from './shell/focus';
import { ProblemsDialog } from './shell/problems';
import { go, VIEWS, type View, view, isViewNamed, show } from './shell/route';
import { theme, toggleTheme } from './shell/theme';
import { Toasts } from './shell/toasts';
import { connected, info, mayWrite, status } from './store/info';
import { listAt } from './store/document';
import { loaded, redo, undo } from './store/project';
import { DevicesView } from './views/devices/view';
import { LiveView } from './views/live/view';
import { OverviewView } from './views/overview/view';
import { askToSave, Saving } from './views/project/save_dialog';
import { ProjectView } from './views/project/view';
import { TrafficView } from './views/traffic/view';
import { TrendsView } from './views/trends/view';
import { Icon } from './widgets/icon';

const components: Record<View, ComponentType> = {
  overview: OverviewView,
  project: ProjectView,
  live: LiveView,
  trends: TrendsView,
  traffic: TrafficView,
  devices: DevicesView,
};
const DOTS = { ok: 'good', degraded: 'warn', failed: 'bad' } as const;

const listed = signal(false);

// The address without a view opens the overview, or the project where there is no device yet. It then names
// that view: the first device of an empty project leaves the view as it is.
const stop = effect(() => {
  const its = status.value;
  if (!its) return;
  const empty = its.lines.every((line) => line.devices.length === 0);
  if (!isViewNamed()) show(empty ? 'project' : 'overview');
  queueMicrotask(() => stop());
});

/** The project has neither devices nor servers nor instruments: there is nothing that can be well. */
const runsNothing = computed(() => {
  const document = loaded.value?.document;
  const none = (key: string) => listAt(document ?? undefined, [key]).length === 0;
  const devices = status.value?.lines.some((line) => line.devices.length > 0) ?? true;
  return document !== undefined && document !== null && !devices && none('servers') && none('instruments');
});

function Health() {
  const idle = runsNothing.value;
  const health = connected.value && !idle ? status.value?.health : undefined;
  const text = connected.value && idle ? t.value.overview.noDevice : t.value.health[health ?? 'unknown'];
  return (
    <button
      type="button"
      class="button quiet health"
      title={text}
      aria-label={text}
      aria-haspopup={idle ? undefined : 'dialog'}
      onClick={() => {
        if (idle) go('project');
        else listed.value = true;
      }}
    >
      <i class={`dot ${health ? DOTS[health] : ''}`} />
      <span>{text}</span>
    </button>
  );
}

function Bar() {
  const its = info.value;
  return (
    <header class="bar">
      <span class="brand">Takt</span>
      <span class="project" title={its?.project}>
        {its?.project}
      </span>
      {its?.demo && <span class="badge">{t.value.shell.demo}</span>}
      {its && !mayWrite.value && (
        <span class="badge" title={t.value.shell.readOnlyHint}>
          {t.value.shell.readOnly}
        </span>
      )}
      <span class="spring" />
      <Health />
      <select
        aria-label={t.value.shell.language}
        value={language.value}
        onChange={(event) => setLanguage(event.currentTarget.value as Language)}
      >
        {LANGUAGES.map((one) => (
          <option key={one.code} value={one.code}>
            {one.name}
          </option>
        ))}
      </select>
      <button
        type="button"
        class="icon-button"
        aria-label={t.value.shell.theme}
        aria-pressed={theme.value === 'dark'}
        title={t.value.shell.theme}
        onClick={toggleTheme}
      >
        <Icon name="theme" />
      </button>
    </header>
  );
}

/** The shortcut of a key with Ctrl: saving in each view, undo and redo where the project is shown. */
function shortcut(event: KeyboardEvent): (() => void) | null {
  const key = event.key.toLowerCase();
  if (key === 's') return askToSave;
  if (view.peek() !== 'project') return null;
  if (key === 'y' || (key === 'z' && event.shiftKey)) return redo;
  return key === 'z' ? undo : null;
}

/** Dialogs and the editor of a cell keep their own undo, and save nothing. */
function onKeyDown(event: KeyboardEvent): void {
  if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
  const run = shortcut(event);
  if (!run) return;
  const editor = (event.target as Element).closest?.('dialog, .cell-editor');
  if (!editor || run === askToSave) event.preventDefault();
  if (editor) return;
  run();
  keepFocus();
}
addEventListener('keydown', onKeyDown);

export function App() {
  const Current = components[view.value];
  return (
    <div class="shell">
      <Bar />
      <nav aria-label={t.value.nav.label}>
        {VIEWS.map((name) => (
          <a key={name} href={`#/${name}`} aria-current={view.value === name ? 'page' : undefined}>
            <Icon name={name} />
            <span>{t.value.nav[name]}</span>
          </a>
        ))}
      </nav>
      {/* Each view begins at its top. */}
      <main key={view.value} id="main" tabIndex={-1}>
        <Current />
      </main>
      {listed.value && (
        <ProblemsDialog
          onClose={() => {
            listed.value = false;
          }}
        />
      )}
      <Saving />
      <Toasts />
    </div>
  );
}
