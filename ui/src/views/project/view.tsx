// The project: its tree and the settings of what is selected; beside them what they do to the bus.
import { t } from '../../i18n';
import { keepFocus } from '../../shell/focus';
import { narrow } from '../../shell/narrow';
import { info, mayEdit } from '../../store/info';
import { canRedo, canUndo, isChanged, isUnreadable, loaded, redo, revert, undo } from '../../store/project';
import { Icon, type IconName } from '../../widgets/icon';
import { Split } from '../../widgets/split';
import { RequestsPane } from '../requests/pane';
import { shownLine } from '../requests/plan';
import { loadText } from '../requests/summary';
import { Details } from './details';
import { ImportDialog } from './import_dialog';
import { importing } from './importing';
import { FindingTexts, Problems, wrongValues } from './problems';
import { askToSave, Conflict } from './save_dialog';
import { half } from './selection';
import { Start } from './start';
import { TabBar } from './tab_bar';
import { Tree } from './tree_view';
import '../../style/forms.css';
import '../../style/project.css';
import '../../style/table.css';

function Step(props: { icon: IconName; name: string; keys: string; disabled: boolean; onClick: () => void }) {
  return (
    <button
      type="button"
      class="icon-button"
      title={`${props.name} (${props.keys})`}
      aria-label={props.name}
      aria-keyshortcuts={props.keys.replace('Ctrl', 'Control')}
      disabled={props.disabled}
      onClick={() => {
        props.onClick();
        keepFocus();
      }}
    >
      <Icon name={props.icon} />
    </button>
  );
}

function Toolbar() {
  const texts = t.value.project;
  const wrong = wrongValues.value > 0;
  return (
    <header class="project-bar">
      <h1>{texts.title}</h1>
      <Step icon="undo" name={texts.undo} keys="Ctrl+Z" disabled={!canUndo.value} onClick={undo} />
      <Step icon="redo" name={texts.redo} keys="Ctrl+Y" disabled={!canRedo.value} onClick={redo} />
      <span class="spring" />
      <Problems />
      {mayEdit.value && (
        <>
          <span class="muted small saved">{isChanged.value ? texts.changed : texts.unchanged}</span>
          <button type="button" class="button quiet" disabled={!isChanged.value} onClick={revert}>
            {texts.revert}
          </button>
          <button
            type="button"
            class="button primary"
            disabled={!isChanged.value || wrong}
            title={wrong ? texts.cannotSave : undefined}
            aria-keyshortcuts="Control+S"
            onClick={askToSave}
          >
            {texts.save}
          </button>
        </>
      )}
    </header>
  );
}

/** A file that an editor would damage: its faults instead of the forms. */
function Unreadable() {
  return (
    <div class="project-view">
      <p class="banner bad">{t.value.project.unreadable}</p>
      <FindingTexts findings={loaded.value?.findings ?? []} />
    </div>
  );
}

/** "Requests: 7, 45 %": the effect of an edit is seen on a narrow screen too. */
function effectTitle(): string {
  const line = shownLine.value;
  const name = t.value.project.effect;
  return line ? `${name}: ${line.request_count}, ${loadText(line)}` : name;
}

export function ProjectView() {
  const texts = t.value.project;
  if (!loaded.value)
    return <p class="muted">{info.value && !info.value.project ? texts.noFile : texts.loading}</p>;
  if (isUnreadable.value) return <Unreadable />;
  return (
    <div class="project-view" data-half={half.value}>
      <Toolbar />
      <Conflict />
      {!mayEdit.value && <p class="banner info">{texts.readOnly}</p>}
      <Start />
      <div class="halves">
        <TabBar
          name="half"
          controls="main"
          label={texts.views}
          value={half.value}
          tabs={[
            { value: 'edit', title: texts.edit },
            { value: 'effect', title: effectTitle() },
          ]}
          onValue={(to) => {
            half.value = to as typeof half.value;
          }}
        />
      </div>
      <Split
        name="project"
        start={narrow.value ? 54 : 48}
        left={
          <div class="panel editing">
            <Tree />
            <Details />
          </div>
        }
        right={<RequestsPane />}
      />
      {importing.value && (
        <ImportDialog key={importing.value.text} start={importing.value.text} path={importing.value.path} />
      )}
    </div>
  );
}
