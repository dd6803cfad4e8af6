// The devices that a search found, and the registers that a probe found.
import type { FoundDevice, Mapping, ProbedDevice, Search } from '../../api/types';
import { formatDuration, t } from '../../i18n';
import { go } from '../../shell/route';
import { toast } from '../../shell/toasts';
import { mayEdit, mayWrite } from '../../store/info';
import { change, draft, isUnreadable, loaded } from '../../store/project';
import { type Column, Grid } from '../../widgets/grid';
import { draftDevice, withFound, withProbed } from './adopt';
import { placeText, probe } from './search_state';

const editable = () => mayEdit.value && loaded.value !== null && !isUnreadable.value;

/** One undo step of the draft; undefined: it cannot be added. */
function take(next: Mapping | undefined, name: string, label: string): void {
  const texts = t.peek().devices.search;
  if (next) {
    change(next, label);
    toast('good', texts.added(name));
  } else {
    toast('bad', texts.notAdded(name));
  }
}

function add(found: FoundDevice): void {
  const name = String(found.device_node?.name ?? found.unit);
  take(withFound(draft.peek(), found), name, `found ${found.target} ${found.unit}`);
}

function addProbed(probed: ProbedDevice): void {
  const name = probed.known_as ?? '';
  take(withProbed(draft.peek(), probed), name, `probed ${probed.target} ${probed.unit}`);
}

function Known({ found }: { found: FoundDevice }) {
  const texts = t.value.devices.search;
  if (found.known_as !== null) return <>{found.known_as}</>;
  const drafted = draftDevice(draft.value, found);
  if (drafted)
    return (
      <button type="button" class="button small" onClick={() => go('project')}>
        {texts.inDraft(String(drafted.name))}
      </button>
    );
  return (
    <button
      type="button"
      class="button small"
      disabled={!editable() || found.device_node === null}
      onClick={() => add(found)}
    >
      {texts.add}
    </button>
  );
}

function columns(running: boolean): Column<FoundDevice>[] {
  const texts = t.value.devices.search;
  return [
    {
      key: 'target',
      title: texts.target,
      width: 'minmax(170px, 1.2fr)',
      cell: (its) => <span title={its.target}>{placeText(its.target)}</span>,
    },
    {
      key: 'unit',
      title: t.value.devices.columns.address,
      width: '64px',
      align: 'right',
      cell: (its) => its.unit,
    },
    {
      key: 'identity',
      title: texts.identity,
      width: 'minmax(120px, 1fr)',
      cell: (its) => its.identity || <span class="muted">–</span>,
    },
    {
      key: 'response',
      title: t.value.devices.columns.response,
      width: '92px',
      align: 'right',
      cell: (its) => formatDuration(its.response_ms),
    },
    {
      key: 'known',
      title: texts.inProject,
      width: 'minmax(170px, 1fr)',
      cell: (its) => <Known found={its} />,
    },
    {
      key: 'probe',
      title: texts.registers,
      width: '130px',
      cell: (its) => (
        <button
          type="button"
          class="button small"
          disabled={!mayWrite.value || running}
          onClick={() => probe(its.target, its.unit)}
        >
          {texts.probe}
        </button>
      ),
    },
  ];
}

function Probed({ its, found }: { its: ProbedDevice; found: FoundDevice | undefined }) {
  const texts = t.value.devices.search;
  return (
    <details class="probed" open>
      <summary>
        {texts.probed(placeText(its.target), its.unit)}
        {its.known_as !== null && (
          <button
            type="button"
            class="button small"
            disabled={!editable() || Object.keys(its.keys).length === 0}
            onClick={() => addProbed(its)}
          >
            {texts.take}
          </button>
        )}
      </summary>
      <pre>{its.text || its.summary}</pre>
      {its.known_as === null && found && !draftDevice(draft.value, found) && (
        <p class="muted small">{texts.addsRegisters}</p>
      )}
    </details>
  );
}

export function Found({ search }: { search: Search }) {
  const texts = t.value.devices.search;
  return (
    <>
      {search.devices.length > 0 && (
        <Grid
          label={texts.found}
          columns={columns(search.running)}
          rows={search.devices}
          rowKey={(its) => `${its.target} ${its.unit}`}
        />
      )}
      {search.troubles.length > 0 && (
        <ul class="troubles">
          {search.troubles.map((its, i) => (
            <li key={i}>
              <i class="dot bad" /> {its.text}
            </li>
          ))}
        </ul>
      )}
      {search.probed.map((its) => (
        <Probed
          key={`${its.target} ${its.unit}`}
          its={its}
          found={search.devices.find((one) => one.target === its.target && one.unit === its.unit)}
        />
      ))}
    </>
  );
}
