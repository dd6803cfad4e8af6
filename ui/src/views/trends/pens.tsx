// The table of the pens: values at the cursors, their difference, and the figures of the range.
import { formatClock, formatDuration, formatNumber, t } from '../../i18n';
import { Icon } from '../../widgets/icon';
import { drawnOf, penColor } from './chart';
import { statisticsOf, valueAt } from './data';
import { cursors, picture, removePen } from './state';

const shown = (value: number | null | undefined) =>
  value === null || value === undefined ? '–' : formatNumber(value, 6);

export function Pens() {
  const texts = t.value.trends;
  const history = picture.value;
  if (!history) return null;
  const { a, b } = cursors.value;
  const both = a !== null && b !== null;
  return (
    <div class="pens">
      <table>
        <thead>
          <tr>
            <th scope="col">{texts.pens}</th>
            <th scope="col">{a === null ? texts.now : `A ${formatClock(a, true)}`}</th>
            <th scope="col">{b === null ? '' : `B ${formatClock(b, true)}`}</th>
            <th scope="col">{both ? `${texts.difference} (${formatDuration(Math.abs(b - a))})` : ''}</th>
            <th scope="col">{texts.min}</th>
            <th scope="col">{texts.mean}</th>
            <th scope="col">{texts.max}</th>
            <th scope="col">{texts.good}</th>
            <th scope="col">{texts.samples}</th>
            <th />
          </tr>
        </thead>
        <tbody>
          {drawnOf(history).map((its) => {
            const variable = history.variables.find((one) => one.name === its.name)!;
            const atA = a === null ? its.curve.values.at(-1) : valueAt(its.curve, a / 1000);
            const atB = b === null ? null : valueAt(its.curve, b / 1000);
            const figures = both
              ? statisticsOf(its.curve, Math.min(a, b) / 1000, Math.max(a, b) / 1000)
              : variable;
            return (
              <tr key={its.name}>
                <th scope="row">
                  <i class="pen" style={{ background: penColor(its.pen) }} /> {its.name}{' '}
                  <span class="muted">{variable.unit}</span>
                </th>
                <td>{shown(atA)}</td>
                <td>{b === null ? '' : shown(atB)}</td>
                <td>{both && typeof atA === 'number' && typeof atB === 'number' ? shown(atB - atA) : ''}</td>
                <td>{shown(figures?.min)}</td>
                <td>{shown(figures?.mean)}</td>
                <td>{shown(figures?.max)}</td>
                <td>{formatNumber(100 * variable.good_share, 1)} %</td>
                <td>{formatNumber(variable.samples)}</td>
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
