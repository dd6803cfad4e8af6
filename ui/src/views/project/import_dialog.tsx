// Tables of the IDE, or of a spreadsheet, by pasting them: a preview, then one step in the draft.
import { useEffect, useState } from 'preact/hooks';
import { post } from '../../api/client';
import type { ImportedRow, ImportedRows, Mapping, Node } from '../../api/types';
import { t } from '../../i18n';
import { Dialog } from '../../shell/dialog';
import { errorText, toast } from '../../shell/toasts';
import { at, formatPath, listAt, type Path } from '../../store/document';
import { draft, setNodes } from '../../store/project';
import { type CoilChoice, openRows, withChoice } from './coil_choice';
import { CoilQuestion } from './coil_question';
import {
  type Connection,
  completed,
  deviceOf,
  framingIn,
  importing,
  itemOf,
  itemsBefore,
  lineOf,
  merged,
  newTargets,
  type Target,
  targetAt,
  targetsFor,
  variablesOf,
} from './importing';
import { NewLine } from './new_line';
import { keyText, wordText } from './rules';
import { select, tab } from './selection';

const ASK_AFTER_MS = 200;
const MOST_SHOWN = 8;

function Rows({ kind, rows }: { kind: ImportedRows['kind']; rows: ImportedRow[] }) {
  const texts = t.value.project.importing;
  const keys = [...new Set(rows.flatMap((its) => Object.keys(its)))];
  return (
    <>
      <h3>{texts.found(texts.kind[kind], rows.length)}</h3>
      <div class="preview">
        <table>
          <thead>
            <tr>
              {keys.map((key) => (
                <th key={key} scope="col">
                  {keyText(key === 'protocol' ? 'framing' : key)}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {rows.slice(0, MOST_SHOWN).map((row, i) => (
              <tr key={i}>
                {keys.map((key) => (
                  <td key={key}>{Array.isArray(row[key]) ? row[key].length : row[key]}</td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
        {rows.length > MOST_SHOWN && <p class="muted small">{texts.more(rows.length - MOST_SHOWN)}</p>}
      </div>
    </>
  );
}

function Preview({ found, rows }: { found: ImportedRows; rows: ImportedRow[] }) {
  const variables = rows.flatMap(variablesOf);
  const findings = found.findings.filter((its) => its.severity !== 'note');
  return (
    <>
      {rows.length > 0 && <Rows kind={found.kind} rows={rows} />}
      {variables.length > 0 && <Rows kind="variables" rows={variables} />}
      {findings.map((its) => (
        <p key={its.code + its.line + its.column} class={`small ${its.severity}`}>
          {its.line > 0 && t.value.project.importing.line(its.line)}
          {its.message} <span class="muted">{its.advice}</span>
        </p>
      ))}
    </>
  );
}

type Change = { path: Path; value: Node };

/** The line and the device that a target makes; undefined: its connection is incomplete. */
function madeFor(target: Target, connection: Connection): Change[] | undefined {
  const { newDevice, newLine } = t.peek().project.tree;
  const changes: Change[] = [];
  if (target.makes === 'line') {
    const names = { line: newLine, simulated: wordText('simulated') };
    const line = lineOf(listAt(draft.value, ['lines']), connection, names);
    if (!line) return undefined;
    changes.push({ path: target.path.slice(0, 2), value: line });
  }
  if (target.makes && target.path.at(-1) === 'variables')
    changes.push({
      path: target.path.slice(0, 4),
      value: deviceOf(listAt(draft.value, target.path.slice(0, 3)), newDevice),
    });
  return changes;
}

export function ImportDialog({ start, path }: { start: string; path: Path | null }) {
  const texts = t.value.project.importing;
  const [text, setText] = useState(start);
  const [found, setFound] = useState<ImportedRows | null>(null);
  const [problem, setProblem] = useState('');
  const [into, setInto] = useState<string | null>(null);
  const [replace, setReplace] = useState(false);
  const [choice, setChoice] = useState<CoilChoice | null>(null);
  const [entered, setConnection] = useState<Connection | null>(null);
  useEffect(() => {
    if (text.trim() === '') {
      setFound(null);
      setProblem('');
      return undefined;
    }
    const stop = new AbortController();
    const timer = setTimeout(() => {
      post<ImportedRows>('import', { text }, stop.signal)
        .then((its) => {
          setFound(its);
          setProblem('');
        })
        .catch((failure) => {
          if (stop.signal.aborted) return;
          setFound(null);
          setProblem(errorText(failure));
        });
    }, ASK_AFTER_MS);
    return () => {
      clearTimeout(timer);
      stop.abort();
    };
  }, [text]);

  const targets = found
    ? [
        ...targetsFor(draft.value, found.kind, {
          locals: t.value.project.tree.locals,
          devices: t.value.keys.devices,
        }),
        ...newTargets(draft.value, found.kind, { device: texts.newDevice, line: texts.newLine }),
      ]
    : [];
  const target = targets.find((its) => formatPath(its.path) === into) ?? targetAt(targets, path);
  const overTcp = found?.rows.some((its) => /tcp/i.test(String(its.protocol ?? '')));
  const connection = entered ?? { transport: overTcp ? 'tcp' : 'serial', port: '', host: '', tcp_port: '' };
  const made = target && madeFor(target, connection);
  const close = () => {
    importing.value = null;
  };
  const before = found && target ? itemsBefore(listAt(draft.value, target.path), found.kind, path) : [];
  const devices = found?.kind === 'devices';
  const rows = found && devices ? completed(found.rows, before, t.value.project.tree.newDevice) : found?.rows;
  const items = rows && target ? rows.map((row) => itemOf(row, target.object)) : [];
  const list = merged(before, items, replace, devices ? 'address' : 'name');
  const open = devices
    ? items.flatMap((its) => openRows(listAt(its, ['variables']), []))
    : openRows(list, before);
  const wrong = found?.findings.some((its) => its.severity === 'error') ?? false;
  const accept = () => {
    if (!target || !made) return;
    const coils = (all: Mapping[]) => (choice ? withChoice(all, open, choice) : all);
    const value = devices
      ? list.map((its) =>
          Array.isArray(its.variables) ? { ...its, variables: coils(listAt(its, ['variables'])) } : its,
        )
      : coils(list);
    const changes: Change[] = [...made, { path: target.path, value }];
    const line = target.path.slice(0, 2);
    const node = (target.makes === 'line' ? made[0]!.value : at(draft.value, line)) as Mapping;
    const framing = found && devices && framingIn(found.rows, node);
    if (framing) changes.push({ path: [...line, 'framing'], value: framing });
    setNodes(changes, `import ${formatPath(target.path)}`);
    select(target.path[0] === 'locals' ? target.path : target.path.slice(0, -1));
    if (target.path.at(-1) === 'variables') tab.value = 'variables';
    toast('good', texts.done(items.length + found!.rows.flatMap(variablesOf).length));
    close();
  };
  return (
    <Dialog
      title={texts.title}
      accept={texts.accept}
      acceptDisabled={wrong || !made || items.length === 0 || (open.length > 0 && choice === null)}
      onAccept={accept}
      onClose={close}
    >
      <div class="importing">
        <p class="muted">{texts.hint}</p>
        <textarea
          rows={6}
          class="mono"
          aria-label={texts.text}
          value={text}
          spellcheck={false}
          onInput={(event) => setText(event.currentTarget.value)}
        />
        <div aria-live="polite">
          {problem && <p class="bad">{problem}</p>}
          {found && <Preview found={found} rows={rows ?? []} />}
          {open.length > 0 && <CoilQuestion rows={open} value={choice} onPick={setChoice} />}
          {found && targets.length === 0 && <p class="bad">{texts.nowhere}</p>}
        </div>
        {target && (
          <div class="choice-row">
            <label>
              <span class="muted">{texts.into}</span>
              <select
                value={formatPath(target.path)}
                onChange={(event) => setInto(event.currentTarget.value)}
              >
                {targets.map((its) => (
                  <option key={formatPath(its.path)} value={formatPath(its.path)}>
                    {its.title}
                  </option>
                ))}
              </select>
            </label>
            {target.makes === 'line' && <NewLine value={connection} onValue={setConnection} />}
            {!target.makes && (
              <label>
                <span class="muted">{texts.mode}</span>
                <select
                  value={String(replace)}
                  onChange={(event) => setReplace(event.currentTarget.value === 'true')}
                >
                  <option value="false">{devices ? texts.appendDevices : texts.append}</option>
                  <option value="true">{texts.replace}</option>
                </select>
              </label>
            )}
          </div>
        )}
      </div>
    </Dialog>
  );
}
