// What is selected in the tree: its settings and its variables.
import { signal } from '@preact/signals';
import type { ComponentType } from 'preact';
import { t } from '../../i18n';
import { at, formatPath, isMapping, listAt, type Path, textAt } from '../../store/document';
import { draft } from '../../store/project';
import { plan } from '../requests/plan';
import { DeviceForm } from './device_form';
import { readOnly } from './edit';
import { FileRows, filePart, FromFile } from './file_rows';
import { InstrumentForm, LineForm, OutputForm, ProjectForm, ServerForm, UnitForm } from './forms';
import { lit, selected, tab } from './selection';
import { TabBar } from './tab_bar';
import { VariableTable } from './table';
import type { TableObject } from './columns';
import { VariableForm } from './variable_form';

const formOpen = signal(innerHeight > 800);

/** Why the part cannot be changed. */
function ReadOnlyNote({ path }: { path: Path }) {
  const why = readOnly(path);
  if (why === null || why === true) return null;
  return <p class="banner info">{t.value.project.readOnlyPart(why)}</p>;
}

/** The variables of a device in the plan: how many there are if they come from files. */
function namesInPlan(device: string): string[] {
  const requests = plan.value.flatMap((line) => line.requests).filter((its) => its.device === device);
  return [...new Set(requests.flatMap((its) => its.variables))];
}

/** The draft names a file that is not the one that was loaded: its rows are known after the next save. */
const NotLoaded = ({ path, file }: { path: Path; file: string }) => (
  <FromFile path={formatPath(path)} note={t.value.project.table.fromTable(file)} />
);

function SelectedVariable({ path }: { path: Path }) {
  const texts = t.value.project.table;
  const [name] = lit.value.variables.size === 1 ? lit.value.variables : [];
  const index = listAt(draft.value, path).findIndex((its) => its.name === name);
  const found = name !== undefined && index >= 0;
  if (!found) return <p class="variable-panel none muted small">{texts.noneSelected}</p>;
  return (
    <details
      class="variable-panel"
      open={formOpen.value}
      onToggle={(event) => {
        formOpen.value = event.currentTarget.open;
      }}
    >
      <summary>{texts.of(name)}</summary>
      <VariableForm key={name} path={[...path, index]} />
    </details>
  );
}

function Variables({ path, object }: { path: Path; object: TableObject }) {
  const texts = t.value.project.table;
  const list = at(draft.value, [...path, 'variables']);
  const its = [...path, 'variables'];
  const label = object === 'variable' ? texts.variables : texts.served;
  if (typeof list === 'string') {
    const part = filePart(its);
    return part ? (
      <FileRows part={part} object={object} label={label} />
    ) : (
      <NotLoaded path={its} file={list} />
    );
  }
  const template = filePart([...path, 'device_template']);
  return (
    <>
      <ReadOnlyNote path={its} />
      <VariableTable key={formatPath(its)} path={its} object={object} label={label} />
      {template && template.rows.length > 0 && (
        <details class="template-rows">
          <summary>{texts.ofTemplate(template.rows.length)}</summary>
          <FileRows part={template} object={object} label={texts.ofTemplate(template.rows.length)} />
        </details>
      )}
      {object === 'variable' && <SelectedVariable path={its} />}
    </>
  );
}

const FORMS: Record<string, ComponentType<{ path: Path }>> = {
  lines: LineForm,
  servers: ServerForm,
  outputs: OutputForm,
  instruments: InstrumentForm,
};

export function Details() {
  const path = selected.value;
  const texts = t.value.project;
  const locals = path[0] === 'locals' ? filePart(['locals']) : undefined;
  if (locals)
    return (
      <div class="item-details">
        <FileRows part={locals} object="local" label={texts.table.locals} />
      </div>
    );
  if (path[0] === 'locals')
    return (
      <div class="item-details">
        <p class="explained muted small">{texts.picker.kinds.standard}</p>
        <VariableTable path={['locals']} object="local" label={texts.table.locals} />
      </div>
    );
  const key = formatPath(path);
  if (path.length < 4) {
    const Form = FORMS[String(path[0])] ?? ProjectForm;
    return (
      <div class="item-details scrolls" key={key}>
        <ReadOnlyNote path={path} />
        <Form path={path} />
      </div>
    );
  }
  const device = path[0] === 'lines';
  const node = at(draft.value, path);
  const list = isMapping(node) ? node.variables : undefined;
  const name = textAt(node, ['name']) ?? '';
  const count = Array.isArray(list)
    ? list.length
    : typeof list === 'string'
      ? (filePart([...path, 'variables'])?.rows.length ?? namesInPlan(name).length)
      : 0;
  return (
    <div class="item-details" key={key}>
      <TabBar
        name="details"
        label={texts.tabs.label}
        value={tab.value}
        tabs={[
          { value: 'settings', title: texts.tabs.settings },
          { value: 'variables', title: texts.tabs.variables(count) },
        ]}
        onValue={(to) => {
          tab.value = to as typeof tab.value;
        }}
      />
      <div
        class={`tab-panel ${tab.value}`}
        role="tabpanel"
        id="details-panel"
        aria-labelledby={`details-${tab.value}`}
      >
        {tab.value === 'variables' ? (
          <Variables path={path} object={device ? 'variable' : 'served_variable'} />
        ) : (
          <>
            <ReadOnlyNote path={path} />
            {device ? <DeviceForm path={path} /> : <UnitForm path={path} />}
          </>
        )}
      </div>
    </div>
  );
}
