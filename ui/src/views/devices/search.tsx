// Finding devices: a scan of hosts, ports or a line of the project, and the registers of a device.
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { get, post } from '../../api/client';
import type { LineStatus, Search, SearchTargets } from '../../api/types';
import { formatDuration, formatNumber, t } from '../../i18n';
import { errorText } from '../../shell/toasts';
import { mayWrite } from '../../store/info';
import { Found } from './found';
import { evaluation } from '../../store/project';
import { ask, placeText, problem, search, spare, throughLine } from './search_state';

const AGAIN_MS = 400;

const ADDRESS = 'address';
/** "address", or "line:NAME" of a line of the project. */
const where = signal(ADDRESS);
const address = signal('');
const units = signal('');
/** Serial ports and hosts of this computer, as targets. */
const targets = signal<string[]>([]);
const timeout = signal('');

function scan(): void {
  const target = where.peek() === ADDRESS ? address.peek().trim() : where.peek();
  const body = {
    targets: target.split(/[\s,;]+(?=\S+:\/\/)/).filter(Boolean),
    ...(units.peek().trim() ? { units: units.peek().replace(/\s/g, '') } : {}),
    ...throughLine(target),
    ...(timeout.peek().trim() ? { timeout_ms: Number(timeout.peek()) } : {}),
  };
  void ask(post<Search>('search/scan', body));
}

const LONGEST_FRAMES = 264; // bytes of a request and the longest response
const BITS = 11; // of a character

/** By how many milliseconds a request of a search without a response can delay the polling of a line. */
function delayOf(name: string, wait: number): number {
  const line = evaluation.value?.lines.find((its) => its.name === name);
  if (!line?.baud) return wait || 500;
  const characters = LONGEST_FRAMES * (line.framing === 'ascii' ? 2 : 1);
  return (wait || 200) + Math.ceil((1000 * BITS * characters) / line.baud);
}

/** What the search does to polling. */
function OnLine({ name }: { name: string }) {
  const texts = t.value.devices.search;
  const delay = formatNumber(delayOf(name, Number(timeout.value)));
  return (
    <>
      <label class="check">
        <input
          type="checkbox"
          checked={spare.value}
          onChange={(event) => {
            spare.value = event.currentTarget.checked;
          }}
        />
        {texts.spare}
      </label>
      <p class="muted small wide">
        {texts.onLine} {spare.value ? texts.spareNote : texts.delays(delay)}
      </p>
    </>
  );
}

function Progress({ its }: { its: Search }) {
  const texts = t.value.devices.search;
  const percent = its.total > 0 ? Math.min(100, (100 * its.done) / its.total) : 0;
  return (
    <div class="progress">
      {its.running && (
        <div
          class="bar"
          role="progressbar"
          aria-label={texts.title}
          aria-valuemin={0}
          aria-valuemax={100}
          aria-valuenow={Math.round(percent)}
        >
          <i style={{ width: `${percent}%` }} />
        </div>
      )}
      <p role="status">
        {its.running
          ? texts.progress(formatNumber(its.done), formatNumber(its.total), placeText(its.where))
          : texts.ended(
              formatNumber(its.devices.length),
              formatNumber(its.requests),
              formatDuration(its.elapsed_ms),
            )}
        {its.cancelled && ` · ${texts.cancelled}`}
        {!its.running && its.absent_hosts > 0 && ` · ${texts.absent(its.absent_hosts)}`}
      </p>
      {its.error && <p class="problem">{its.error}</p>}
    </div>
  );
}

/** What can be searched, to choose from. */
function Targets() {
  const texts = t.value.devices.search;
  return (
    <div class="targets" role="group" aria-label={texts.here}>
      <span class="muted small">{targets.value.length > 0 ? texts.here : texts.nothingHere}</span>
      {targets.value.map((its) => (
        <button
          key={its}
          type="button"
          class="button small"
          aria-pressed={address.value === its}
          onClick={() => {
            address.value = its;
          }}
        >
          {its.replace(/^\w+:\/\//, '')}
        </button>
      ))}
    </div>
  );
}

function Form({ lines, running }: { lines: LineStatus[]; running: boolean }) {
  const texts = t.value.devices.search;
  const field = (its: typeof units) => ({
    type: 'text',
    spellcheck: false,
    autocomplete: 'off',
    value: its.value,
    onInput: (event: { currentTarget: HTMLInputElement }) => {
      its.value = event.currentTarget.value;
    },
  });
  return (
    <form
      class="search-form"
      onSubmit={(event) => {
        event.preventDefault();
        scan();
      }}
    >
      <label>
        <span>{texts.where}</span>
        <select
          value={where.value}
          onChange={(event) => {
            where.value = event.currentTarget.value;
          }}
        >
          <option value={ADDRESS}>{texts.address}</option>
          {lines.map((line) => (
            <option key={line.name} value={`line:${line.name}`}>
              {texts.line(line.name)}
            </option>
          ))}
        </select>
      </label>
      {where.value === ADDRESS && (
        <label class="wide">
          <span>{texts.target}</span>
          <input {...field(address)} placeholder="tcp://192.168.1.1-254:502" />
        </label>
      )}
      <label>
        <span>{texts.units}</span>
        <input {...field(units)} placeholder="1-247" />
      </label>
      <label>
        <span>{texts.timeout}</span>
        <input {...field(timeout)} type="number" min={10} max={10000} placeholder={texts.usual} />
      </label>
      <span class="buttons">
        <button
          type="submit"
          class="button primary"
          disabled={!mayWrite.value || running || (where.value === ADDRESS && !address.value.trim())}
          title={mayWrite.value ? undefined : t.value.shell.readOnlyHint}
        >
          {texts.scan}
        </button>
        {running && (
          <button type="button" class="button" onClick={() => void ask(post<Search>('search/cancel', {}))}>
            {t.value.shell.cancel}
          </button>
        )}
      </span>
      {where.value === ADDRESS ? <Targets /> : <OnLine name={where.value.slice('line:'.length)} />}
    </form>
  );
}

export function SearchPanel({ lines }: { lines: LineStatus[] }) {
  const texts = t.value.devices.search;
  const its = search.value;
  const running = its?.running ?? false;
  useEffect(() => {
    if (!search.peek()) void ask(get<Search>('search'));
    get<SearchTargets>('search/targets')
      .then((its) => {
        targets.value = its.targets;
      })
      .catch((failure) => {
        problem.value = errorText(failure);
      });
  }, []);
  useEffect(() => {
    if (!running) return;
    const timer = setInterval(() => void ask(get<Search>('search')), AGAIN_MS);
    return () => clearInterval(timer);
  }, [running]);
  return (
    <section class="panel search">
      <header>
        <h2>{texts.title}</h2>
      </header>
      <Form lines={lines} running={running} />
      <p role="alert" class="problem">
        {problem.value}
      </p>
      {its && its.kind !== 'none' && <Progress its={its} />}
      {its && its.kind !== 'none' && <Found search={its} />}
    </section>
  );
}
