// All values of the running project.
import { computed, effect, signal } from '@preact/signals';
import { post } from '../../api/client';
import type { CommandResult, LiveValue } from '../../api/types';
import { t } from '../../i18n';
import { go, query, view } from '../../shell/route';
import { toast, toastError } from '../../shell/toasts';
import { second } from '../../store/clock';
import { info, mayWrite } from '../../store/info';
import { values, valueTime } from '../../store/live';
import { type Column, Grid } from '../../widgets/grid';
import { Icon } from '../../widgets/icon';
import { AgeCell, QualityCell, type Row, SparkCell, typeClass, ValueCell } from './cells';
import { FORMATS, type Format, hasBits } from './format';
import { Notices } from './notices';
import { WhyDialog } from './why_dialog';
import { wanted } from './wire';
import { WriteDialog } from './write_dialog';
import '../../style/live.css';

const filter = signal('');

// A link to a variable filters by its name.
effect(() => {
  const wanted = query.value.get('filter');
  if (view.value === 'live' && wanted !== null) filter.value = wanted;
});
const onlyTrouble = signal(false);
const sort = signal<{ key: string; down: boolean } | null>(null);
/** How the values of the view are written. */
const format = signal<Format>('normal');
const writing = signal<LiveValue | null>(null);
const asking = signal<string | null>(null);

const RANK = { bad: 0, uncertain: 1, never_read: 2, good: 3 } as const;
const keyOf: Record<string, (its: LiveValue) => string | number> = {
  device: (its) => its.device ?? '',
  name: (its) => its.name,
  quality: (its) => RANK[its.quality],
};

const rows = computed<Row[]>(() => {
  const wanted = filter.value.trim().toLowerCase();
  // Qualities are looked at once a second: the table does not depend on each value.
  if (onlyTrouble.value || sort.value?.key === 'quality') void second.value;
  let found = values.value.filter((row) => {
    const its = row.peek();
    if (onlyTrouble.value && its.quality === 'good') return false;
    return wanted === '' || `${its.device ?? ''} ${its.name}`.toLowerCase().includes(wanted);
  });
  if (sort.value) {
    const { key, down } = sort.value;
    const of = keyOf[key]!;
    const order = new Intl.Collator(undefined, { numeric: true });
    found = [...found].sort((a, b) => {
      const [x, y] = [of(a.peek()), of(b.peek())];
      const compared =
        typeof x === 'number' && typeof y === 'number' ? x - y : order.compare(String(x), String(y));
      return down ? -compared : compared;
    });
  }
  return found;
});

async function trigger(name: string): Promise<void> {
  try {
    const result = await post<CommandResult>('commands', { kind: 'trigger', variable: name, value: true });
    if (result.outcome === 'done') toast('good', t.peek().live.triggered(name));
    else toast('bad', `${name}: ${t.peek().live.outcome[result.outcome]}. ${result.text}`);
  } catch (failure) {
    toastError(failure);
  }
}

// Of the values that are shown, as far as the program is asked for them.
effect(() => {
  wanted.value =
    format.value === 'registers'
      ? rows.value
          .map((row) => row.peek())
          .filter((its) => its.line !== undefined)
          .map((its) => its.name)
      : [];
});

/** Registers come from the wire, other formats from the bits of the value. */
const fits = (its: LiveValue, format: Format) =>
  format === 'normal' || (format === 'registers' ? its.line !== undefined : hasBits(its));

function Actions({ row }: { row: Row }) {
  const texts = t.value.live;
  const its = row.peek();
  return (
    <span class="actions">
      {its.trigger ? (
        <button
          type="button"
          class="button small"
          disabled={!mayWrite.value}
          onClick={() => void trigger(its.name)}
        >
          {texts.trigger}
        </button>
      ) : (
        <button
          type="button"
          class="icon-button"
          title={texts.write}
          aria-label={`${texts.write}: ${its.name}`}
          disabled={!its.writable || !mayWrite.value}
          onClick={() => {
            writing.value = row.peek();
          }}
        >
          <Icon name="write" />
        </button>
      )}
      <button
        type="button"
        class="icon-button"
        title={texts.why}
        aria-label={`${texts.why} ${its.name}`}
        disabled={its.local}
        onClick={() => {
          asking.value = its.name;
        }}
      >
        <Icon name="why" />
      </button>
      <button
        type="button"
        class="icon-button"
        title={texts.plot}
        aria-label={`${texts.plot}: ${its.name}`}
        disabled={!info.value?.history || its.type === 'string'}
        onClick={() => go('trends', { pens: its.name })}
      >
        <Icon name="trends" />
      </button>
    </span>
  );
}

function columns(): Column<Row>[] {
  const texts = t.value.live.columns;
  return [
    {
      key: 'device',
      title: texts.device,
      width: 'minmax(142px, 0.4fr)',
      sortable: true,
      folds: 'text',
      cell: (row) => (
        <span class={`text ${row.peek().device ? '' : 'muted'}`}>
          {row.peek().device ?? t.value.live.local}
        </span>
      ),
    },
    {
      key: 'name',
      title: texts.name,
      width: 'minmax(166px, 0.4fr)',
      foldedWidth: 'minmax(134px, 1.2fr)',
      sortable: true,
      cell: (row) => <span class={`text ${typeClass(row.peek().type)}`}>{row.peek().name}</span>,
    },
    {
      key: 'value',
      title: texts.value,
      width: 'minmax(120px, 0.3fr)',
      foldedWidth: 'minmax(114px, 0.5fr)',
      align: 'right',
      cell: (row) => (
        <>
          <ValueCell row={row} format={fits(row.peek(), format.value) ? format.value : 'normal'} />
          <span class="folded-unit">{row.peek().unit}</span>
        </>
      ),
    },
    { key: 'unit', title: texts.unit, width: '80px', folds: 'hidden', cell: (row) => row.peek().unit },
    {
      key: 'quality',
      title: texts.quality,
      foldedTitle: `${texts.quality}, ${texts.age.toLowerCase()}`,
      width: 'minmax(132px, 2.6fr)',
      sortable: true,
      folds: 'figure',
      spans: 2, // and the age at its end
      cell: (row) => <QualityCell row={row} />,
    },
    {
      key: 'age',
      title: texts.age,
      width: '84px',
      folds: 'hidden',
      align: 'right',
      cell: (row) => <AgeCell row={row} />,
    },
    {
      key: 'trend',
      title: texts.trend,
      width: '126px',
      folds: 'hidden',
      cell: (row) => <SparkCell row={row} />,
    },
    { key: 'actions', title: texts.actions, width: '118px', cell: (row) => <Actions row={row} /> },
  ];
}

function onSort(key: string): void {
  const now = sort.peek();
  if (now?.key !== key) sort.value = { key, down: false };
  else sort.value = now.down ? null : { key, down: true };
}

export function LiveView() {
  const texts = t.value.live;
  return (
    <div class="live">
      <section class="panel values">
        <header>
          <h2>{texts.title}</h2>
          <span class="muted small">{texts.shown(rows.value.length, values.value.length)}</span>
          <label class="check">
            <input
              type="checkbox"
              checked={onlyTrouble.value}
              onChange={(event) => {
                onlyTrouble.value = event.currentTarget.checked;
              }}
            />
            {texts.onlyTrouble}
          </label>
          <select
            aria-label={texts.format.label}
            title={texts.format.label}
            value={format.value}
            onChange={(event) => {
              format.value = event.currentTarget.value as Format;
            }}
          >
            {FORMATS.map((one) => (
              <option key={one} value={one}>
                {texts.format[one]}
              </option>
            ))}
          </select>
          <input
            type="search"
            placeholder={texts.filter}
            aria-label={texts.filter}
            value={filter.value}
            onInput={(event) => {
              filter.value = event.currentTarget.value;
            }}
          />
        </header>
        <Grid
          label={texts.title}
          columns={columns()}
          rows={rows.value}
          rowKey={(row) => row.peek().name}
          sort={sort.value}
          onSort={onSort}
          onOpen={({ row }) => {
            const its = rows.peek()[row]?.peek();
            if (its?.writable && mayWrite.peek()) writing.value = its;
          }}
          empty={values.value.length > 0 ? undefined : valueTime.value > 0 ? texts.empty : texts.waiting}
        />
      </section>
      <Notices />
      {writing.value && (
        <WriteDialog
          value={writing.value}
          onClose={() => {
            writing.value = null;
          }}
        />
      )}
      {asking.value && (
        <WhyDialog
          variable={asking.value}
          onClose={() => {
            asking.value = null;
          }}
        />
      )}
    </div>
  );
}
