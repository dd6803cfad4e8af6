import type { OutputStatus } from '../../api/types';
import { formatNumber, t } from '../../i18n';
import { narrow } from '../../shell/narrow';
import { type Column, Grid } from '../../widgets/grid';

/** On a narrow screen: two lines for each output. */
function shown(columns: Column<OutputStatus>[]): Column<OutputStatus>[] {
  if (!narrow.value) return columns;
  const folds = { failure: 'text', dropped: 'figure' } as const;
  return columns
    .filter(({ key }) => key !== 'destination' && key !== 'sampled')
    .map((its) => (its.key in folds ? { ...its, folds: folds[its.key as keyof typeof folds] } : its));
}

/** Where values are delivered to: sampled = delivered + waiting + dropped at all times. */
export function OutputList({ outputs }: { outputs: OutputStatus[] }) {
  const texts = t.value.devices;
  const count = (key: 'sampled' | 'delivered' | 'waiting' | 'dropped') => ({
    key,
    title: texts.output[key],
    width: narrow.value ? '80px' : '92px',
    align: 'right' as const,
    cell: (its: OutputStatus) => formatNumber(its[key]),
  });
  return (
    <section class="panel">
      <header>
        <h2>{texts.outputs}</h2>
      </header>
      <Grid
        label={texts.outputs}
        columns={shown([
          {
            key: 'name',
            title: texts.output.name,
            width: 'minmax(80px, 0.7fr)',
            cell: (its) => <b title={its.destination}>{its.name}</b>,
          },
          {
            key: 'state',
            title: texts.output.state,
            width: '112px',
            cell: (its) => (
              <>
                <i class={`dot ${its.failure ? 'bad' : its.state === 'delivering' ? 'good' : ''}`} />{' '}
                {texts.outputState[its.state as keyof typeof texts.outputState] ?? its.state}
              </>
            ),
          },
          {
            key: 'destination',
            title: texts.output.destination,
            width: 'minmax(120px, 1.3fr)',
            cell: (its) => <span title={its.destination}>{its.destination}</span>,
          },
          count('sampled'),
          count('delivered'),
          count('waiting'),
          count('dropped'),
          {
            key: 'failure',
            title: texts.output.failure,
            width: 'minmax(110px, 1fr)',
            cell: (its) => {
              const behind = its.falls_behind;
              const text = its.failure ?? behind?.text;
              return <span title={[text, behind?.advice].filter(Boolean).join('. ')}>{text ?? '–'}</span>;
            },
          },
        ])}
        rows={outputs}
        rowKey={(its) => its.name}
      />
    </section>
  );
}
