// Tables of the IDE, or of a spreadsheet, by pasting them: a preview, then one step in the draft.
import { useEffect, useState } from 'preact/hooks';
import { post } from '../../api/client';
import type { Finding, ImportedRow, ImportedRows, Mapping, Node } from '../../api/types';
import { t } from '../../i18n';
import { Dialog } from '../../shell/dialog';
import { errorText, toast } from '../../shell/toasts';
import {
  at,
  formatPath,
  isMapping,
  listAt,
  type Path,
  parsePath,
  textAt,
  withNode,
} from '../../store/document';
import { draft, setNodes } from '../../store/project';
import type { CellKind } from './cells';
import { type CoilChoice, openRows, withChoice } from './coil_choice';
import { CoilQuestion } from './coil_question';
import { COLUMNS } from './columns';
import { namesWithout } from './edit';
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
  replacedBy,
  serverOf,
  type Target,
  targetAt,
  targetsFor,
  variablesOf,
} from './importing';
import { NewLine } from './new_line';
import { keyText, profileOf, rulesAt, wordText } from './rules';
import { select, tab } from './selection';
import { transportOf } from './tree';
import { wordsOf } from './words';

const ASK_AFTER_MS = 200;
const MOST_SHOWN = 8;

type Kind = ImportedRows['kind'];

/** What each cell holds. */
function kindsOf(kind: Kind): Record<string, { kind: string }> {
  if (kind === 'devices') return rulesAt([], 'device');
  const columns = COLUMNS[kind === 'locals' ? 'local' : kind === 'served' ? 'served_variable' : 'variable'];
  return Object.fromEntries(columns.map((its) => [its.key, its]));
}

const headingOf = (key: string) => keyText(key === 'protocol' ? 'framing' : key);

function Rows({ kind, rows }: { kind: Kind; rows: ImportedRow[] }) {
  const texts = t.value.project.importing;
  const kinds = kindsOf(kind);
  const cellOf = (key: string, cell: ImportedRow[string] | undefined) =>
    Array.isArray(cell) ? cell.length : wordsOf(kinds[key]?.kind as CellKind | undefined, cell ?? '');
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
                  {headingOf(key)}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {rows.slice(0, MOST_SHOWN).map((row, i) => (
              <tr key={i}>
                {keys.map((key) => (
                  <td key={key}>{cellOf(key, row[key])}</td>
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

/** "Line 2, Address: ", of what is wrong in a cell. */
function whereOf(its: Finding): string {
  const key = parsePath(its.path).at(-1);
  if (its.line === 0) return '';
  return t.value.project.importing.line(its.line, typeof key === 'string' ? headingOf(key) : '');
}

/** What the pasted rows take the place of. */
function Replaced(props: { kind: Kind; list: Mapping[]; items: Mapping[]; all: boolean }) {
  const texts = t.value.project.importing;
  const { list } = props;
  if (list.length === 0) return null;
  const named = (its: Mapping) => textAt(its, ['name']) ?? '';
  const more = list.length > MOST_SHOWN && texts.more(list.length - MOST_SHOWN);
  const shown = list.slice(0, MOST_SHOWN);
  if (props.kind !== 'devices')
    return (
      <p class="small warning">
        {texts.replacesRows(list.length)} {shown.map(named).join(', ')} {more}
      </p>
    );
  return (
    <>
      {shown.map((its, i) => {
        const title = `${named(its)}, ${textAt(its, ['address']) ?? ''}`;
        const item = props.items.find((one) => one.address === its.address);
        const keeps = !props.all && item?.variables === undefined;
        const variables = textAt(its, ['variables']) ?? texts.variables(listAt(its, ['variables']).length);
        return (
          <p key={i} class="small warning">
            {keeps ? texts.keepsVariables(title) : texts.replaces(title, variables)}
          </p>
        );
      })}
      {more && <p class="small warning">{more}</p>}
    </>
  );
}

function Preview({ found, rows }: { found: ImportedRows; rows: ImportedRow[] }) {
  const variables = rows.flatMap(variablesOf);
  const of = (severity: string) => found.findings.filter((its) => its.severity === severity);
  return (
    <>
      {rows.length > 0 && <Rows kind={found.kind} rows={rows} />}
      {variables.length > 0 && <Rows kind="variables" rows={variables} />}
      {[...of('error'), ...of('warning')].map((its) => (
        <p key={its.code + its.line + its.column} class={`small ${its.severity}`}>
          {whereOf(its)}
          {its.message} <span class="muted">{its.advice}</span>
        </p>
      ))}
    </>
  );
}

type Change = { path: Path; value: Node };

/** The line and the device that a target makes; undefined: its connection is incomplete. */
function madeFor(target: Target, connection: Connection): Change[] | undefined {
  const { newDevice, newLine, newServer } = t.peek().project.tree;
  const changes: Change[] = [];
  if (target.makes === 'line') {
    const names = { line: newLine, simulated: wordText('simulated') };
    const line = lineOf(listAt(draft.value, ['lines']), connection, names);
    if (!line) return undefined;
    changes.push({ path: target.path.slice(0, 2), value: line });
  }
  if (target.makes === 'server')
    changes.push({
      path: target.path.slice(0, 2),
      value: serverOf(listAt(draft.value, ['servers']), newServer),
    });
  else if (target.makes && target.path.at(-1) === 'variables')
    changes.push({
      path: target.path.slice(0, 4),
      value: deviceOf(listAt(draft.value, target.path.slice(0, 3)), newDevice),
    });
  return changes;
}

export function ImportDialog({ start, path }: { start: string; path: Path | null }) {
  const texts = t.value.project.importing;
  const [text, setText] = useState(start);
  const [answer, setAnswer] = useState<{ asked: string; found: ImportedRows } | null>(null);
  const [problem, setProblem] = useState('');
  const [into, setInto] = useState<string | null>(null);
  const [replace, setReplace] = useState(false);
  const [choice, setChoice] = useState<CoilChoice | null>(null);
  const [entered, setConnection] = useState<Connection | null>(null);
  const found = answer?.found ?? null;
  const targets = found
    ? [
        ...targetsFor(draft.value, found.kind, {
          locals: t.value.project.tree.locals,
          devices: t.value.keys.devices,
        }),
        ...newTargets(draft.value, found.kind, {
          device: texts.newDevice,
          line: texts.newLine,
          server: texts.newServer,
        }),
      ]
    : [];
  const target = targets.find((its) => formatPath(its.path) === into) ?? targetAt(targets, path);
  const overTcp = found?.rows.some((its) => /tcp/i.test(String(its.protocol ?? '')));
  const connection = entered ?? { transport: overTcp ? 'tcp' : 'serial', port: '', host: '', tcp_port: '' };
  const made = target && madeFor(target, connection);
  // The parts that the target makes are in the draft after them.
  const document = (made ?? []).reduce<Node>((all, its) => withNode(all, its.path, its.value), draft.value);
  const close = () => {
    importing.value = null;
  };
  const before = found && target ? itemsBefore(listAt(draft.value, target.path), found.kind, path) : [];
  const devices = found?.kind === 'devices';
  const rows = found && devices ? completed(found.rows, before, t.value.project.tree.newDevice) : found?.rows;
  const items = rows && target ? rows.map((row) => itemOf(row, target.object)) : [];
  const list = merged(before, items, replace, devices ? 'address' : 'name');
  const replaced = target?.makes ? [] : replacedBy(before, items, replace, devices ? 'address' : 'name');
  // Names are checked against those of other devices, values against the kind of the line.
  const line = at(document, target?.path.slice(0, 2) ?? []);
  const device = devices || !target ? undefined : at(document, target.path.slice(0, 4));
  const ofLine = isMapping(line) ? transportOf(line) : undefined;
  const ofDevice = textAt(device, ['name']) ?? t.value.project.tree.newDevice;
  const asked = JSON.stringify({
    text,
    profile: profileOf(draft.value),
    transport: (target?.makes === 'line' ? undefined : ofLine) ?? connection.transport,
    device: ofDevice,
    names: [...namesWithout(devices ? replaced : [device as Mapping | undefined])],
  });
  useEffect(() => {
    if (text.trim() === '') {
      setAnswer(null);
      setProblem('');
      return undefined;
    }
    const stop = new AbortController();
    const timer = setTimeout(() => {
      post<ImportedRows>('import', JSON.parse(asked), stop.signal)
        .then((its) => {
          setAnswer({ asked, found: its });
          setProblem('');
        })
        .catch((failure) => {
          if (stop.signal.aborted) return;
          setAnswer(null);
          setProblem(errorText(failure));
        });
    }, ASK_AFTER_MS);
    return () => {
      clearTimeout(timer);
      stop.abort();
    };
  }, [asked]);
  const open = devices
    ? items.flatMap((its) => openRows(listAt(its, ['variables']), []))
    : openRows(list, before);
  const wrong = found?.findings.some((its) => its.severity === 'error') ?? false;
  const refusal = (): string => {
    if (text.trim() === '') return texts.refusal.empty;
    if (problem || wrong) return texts.refusal.wrong;
    if (answer?.asked !== asked) return t.value.project.checking;
    if (!target) return texts.nowhere;
    if (!made) return texts.refusal.missing(keyText(connection.transport === 'tcp' ? 'host' : 'port'));
    if (items.length === 0) return texts.refusal.none;
    return open.length > 0 && choice === null ? t.value.project.coils.title : '';
  };
  const accept = () => {
    if (!target || !made) return;
    const coils = (all: Mapping[]) => (choice ? withChoice(all, open, choice) : all);
    const value = devices
      ? list.map((its) =>
          Array.isArray(its.variables) ? { ...its, variables: coils(listAt(its, ['variables'])) } : its,
        )
      : coils(list);
    const changes: Change[] = [...made, { path: target.path, value }];
    const framing = found && devices && framingIn(found.rows, line as Mapping);
    if (framing) changes.push({ path: [...target.path.slice(0, 2), 'framing'], value: framing });
    setNodes(changes, `import ${formatPath(target.path)}`);
    select(target.path[0] === 'locals' ? target.path : target.path.slice(0, -1));
    if (target.path.at(-1) === 'variables') tab.value = 'variables';
    toast('good', texts.done(items.length + found!.rows.flatMap(variablesOf).length));
    close();
  };
  return (
    <Dialog title={texts.title} accept={texts.accept} refusal={refusal()} onAccept={accept} onClose={close}>
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
          {found && <Replaced kind={found.kind} list={replaced} items={items} all={replace} />}
          {found && <Preview found={found} rows={rows ?? []} />}
          {open.length > 0 && <CoilQuestion rows={open} value={choice} onPick={setChoice} />}
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
