// The table of the pens: values at the cursors, their difference, and the figures of the range.
import type { History, HistoryVariable } from '../../api/types';
import { formatClock, formatDuration, formatNumber, t } from '../../i18n';
import { Icon } from '../../widgets/icon';
import { decimalsOf, shortest } from '../live/format';
import { drawnOf } from './chart';
import { goodShare, statisticsOf, valueAt } from './data';
import { cursors, picture, removePen } from './state';
import { type Drawn, isLane, penColor } from './tracks';

type Figure = number | null | undefined;
const isKnown = (value: Figure): value is number => value !== null && value !== undefined;

/** As Live prints it. */
function valueText(its: Drawn, value: Figure): string {
  if (!isKnown(value)) return '–';
  return isLane(its) ? t.value.live.boolean[value ? 'on' : 'off'] : shortest(value, its.type);
}
/** What is derived from values has their digits, and `more`; of a boolean it is the share of the time. */
function derivedText(its: Drawn, value: Figure, from: Figure[], more: number): string {
  if (!isKnown(value)) return '–';
  if (isLane(its)) return `${formatNumber(100 * value, 1)} %`;
  return formatNumber(
    value,
    more + Math.max(...from.filter(isKnown).map((one) => decimalsOf(one, its.type))),
  );
}

interface Column {
  title: string;
  text: (its: Drawn, variable: HistoryVariable) => string;
}

function columns(history: History): Column[] {
  const texts = t.value.trends;
  const { a, b } = cursors.value;
  const atA = (its: Drawn) => (a === null ? its.curve.values.at(-1) : valueAt(its.curve, a / 1000));
  const atB = (its: Drawn) => (b === null ? null : valueAt(its.curve, b / 1000));
  const difference = (its: Drawn) => {
    const [first, second] = [atA(its), atB(its)];
    return isKnown(first) && isKnown(second) && !isLane(its)
      ? derivedText(its, second - first, [first, second], 0)
      : '–';
  };
  const figures = (its: Drawn, variable: HistoryVariable) =>
    a !== null && b !== null
      ? statisticsOf(its.curve, Math.min(a, b) / 1000, Math.max(a, b) / 1000)
      : variable;
  const mean: Column['text'] = (its, variable) => {
    const of = figures(its, variable);
    return derivedText(its, of?.mean, [of?.min, of?.max], 1);
  };
  return [
    {
      title: a === null ? texts.now : `A ${formatClock(a, true)}`,
      text: (its) => valueText(its, atA(its)),
    },
    ...(b === null
      ? []
      : [{ title: `B ${formatClock(b, true)}`, text: (its: Drawn) => valueText(its, atB(its)) }]),
    ...(a === null || b === null
      ? []
      : [{ title: `${texts.difference} (${formatDuration(Math.abs(b - a))})`, text: difference }]),
    { title: texts.min, text: (its, variable) => valueText(its, figures(its, variable)?.min) },
    { title: texts.mean, text: mean },
    { title: texts.max, text: (its, variable) => valueText(its, figures(its, variable)?.max) },
    { title: texts.good, text: (_, variable) => `${formatNumber(100 * goodShare(history, variable), 1)} %` },
    { title: texts.samples, text: (_, { samples }) => formatNumber(samples) },
  ];
}

export function Pens() {
  const texts = t.value.trends;
  const history = picture.value;
  if (!history) return null;
  const shown = columns(history);
  return (
    <div class="pens">
      <table>
        <thead>
          <tr>
            <th scope="col">{texts.pens}</th>
            {shown.map(({ title }) => (
              <th key={title} scope="col">
                {title}
              </th>
            ))}
            <th />
          </tr>
        </thead>
        <tbody>
          {drawnOf(history).map((its) => {
            const variable = history.variables.find((one) => one.name === its.name)!;
            return (
              <tr key={its.name}>
                <th scope="row">
                  <i class="pen" style={{ background: penColor(its.pen) }} /> {its.name}{' '}
                  <span class="muted">{variable.unit}</span>
                </th>
                {shown.map(({ title, text }) => (
                  <td key={title} data-title={title}>
                    {text(its, variable)}
                  </td>
                ))}
                <td>
                  <button
                    type="button"
                    class="icon-button"
                    aria-label={texts.removePen(its.name)}
                    title={texts.removePen(its.name)}
                    onClick={() => removePen(its.name)}
                  >
                    <Icon name="close" />
                  </button>
                </td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </div>
  );
}
