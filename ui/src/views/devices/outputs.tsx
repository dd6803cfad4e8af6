import type { OutputStatus } from '../../api/types';
import { formatNumber, t } from '../../i18n';
import { Grid } from '../../widgets/grid';

/** Where values are delivered to: sampled = delivered + waiting + dropped at all times. */
export function OutputList({ outputs }: { outputs: OutputStatus[] }) {
  const texts = t.value.devices;
  const count = (
    key: 'sampled' | 'delivered' | 'waiting' | 'dropped',
    fold: { foldedWidth: string } | { folds: 'figure' },
  ) => ({
    key,
    title: texts.output[key],
    width: '92px',
    align: 'right' as const,
    ...fold,
    cell: (its: OutputStatus) => formatNumber(its[key]),
  });
  return (
    <section class="panel">
      <header>
        <h2>{texts.outputs}</h2>
      </header>
      <Grid
        label={texts.outputs}
        columns={[
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
            foldedWidth: 'minmax(100px, 1fr)',
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
            width: 'minmax(260px, 1.3fr)',
            folds: 'text',
            wraps: true,
            cell: (its) => (
              <span class="text" title={its.destination}>
                {its.destination}
              </span>
            ),
          },
          count('sampled', { folds: 'figure' }),
          count('delivered', { foldedWidth: '84px' }),
          count('waiting', { foldedWidth: '84px' }),
          count('dropped', { folds: 'figure' }),
          {
            key: 'failure',
            title: texts.output.failure,
            width: 'minmax(150px, 1fr)',
            folds: 'text',
            line: 3,
            wraps: true,
            cell: (its) => {
              const behind = its.falls_behind;
              const text = its.failure ?? behind?.text;
              return (
                <span class="text" title={[text, behind?.advice].filter(Boolean).join('. ')}>
                  {text ?? '–'}
                </span>
              );
            },
          },
        ]}
        rows={outputs}
        rowKey={(its) => its.name}
      />
    </section>
  );
}
