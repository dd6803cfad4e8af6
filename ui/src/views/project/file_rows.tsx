// The rows of a table file or a template: shown, changed in their own file, or taken into the project.
import { useState } from 'preact/hooks';
import type { FilePart } from '../../api/types';
import { t } from '../../i18n';
import { formatPath, type Path } from '../../store/document';
import { toast, toastError } from '../../shell/toasts';
import { mayEdit } from '../../store/info';
import { fileParts, takeOver } from '../../store/project';
import { Grid } from '../../widgets/grid';
import { typeClass } from './cells';
import { COLUMNS, type TableObject } from './columns';
import { keyText } from './rules';
import { lightVariable, lit } from './selection';
import { wordsOf } from './words';

/** The rows that come from a file for a key of the draft. */
export const filePart = (path: Path): FilePart | undefined =>
  fileParts.value.find((its) => its.path === formatPath(path));

/** Says where the rows are, and takes them over. */
export function FromFile({ path, note }: { path: string; note: string }) {
  const texts = t.value.project.takeOver;
  const [busy, setBusy] = useState(false);
  const isTemplate = path.endsWith('.device_template');
  const take = async () => {
    setBusy(true);
    try {
      const done = await takeOver(path);
      if (done) toast('info', isTemplate ? texts.templateDone : texts.tableDone);
      else toast('info', texts.again);
    } catch (failure) {
      toastError(failure);
    }
    setBusy(false);
  };
  return (
    <p class="banner info from-file-note">
      <span>{note}</span>
      {mayEdit.value && (
        <button
          type="button"
          class="button"
          disabled={busy}
          title={isTemplate ? texts.templateHint : texts.tableHint}
          onClick={() => void take()}
        >
          {isTemplate ? texts.template : texts.table}
        </button>
      )}
    </p>
  );
}

export function FileRows({ part, object, label }: { part: FilePart; object: TableObject; label: string }) {
  const columns = COLUMNS[object].filter((its) => part.rows.some((row) => row[its.key] !== undefined));
  return (
    <div class="from-file">
      <FromFile path={part.path} note={t.value.project.readOnlyPart(part.file)} />
      <Grid
        label={label}
        columns={columns.map((its) => ({
          key: its.key,
          title: keyText(its.key),
          width: its.width,
          ...(its.right && { align: 'right' as const }),
          cell: (row: Record<string, string>) => (
            <span class={`text ${its.key === 'name' || its.key === 'type' ? typeClass(row.type) : ''}`}>
              {wordsOf(its.kind, row[its.key] ?? '')}
            </span>
          ),
        }))}
        rows={part.rows}
        rowKey={(_, index) => index}
        rowClass={(row) => (lit.value.variables.has(row.name ?? '') ? 'selected lit' : '')}
        onCurrent={({ row }) => lightVariable(part.rows[row]?.name)}
      />
    </div>
  );
}
