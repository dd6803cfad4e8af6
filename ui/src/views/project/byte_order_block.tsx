// Byte and register order: the two check boxes, the permutation, and the same four bytes in every order.
import { signal } from '@preact/signals';
import { formatNumber, t } from '../../i18n';
import type { Path } from '../../store/document';
import {
  type ByteOrder,
  DEFAULT_ORDER,
  decodeAll,
  effectiveOrder,
  floatText,
  parseBytes,
  permutation,
  spaced,
} from './byte_order';
import { setKeys } from './edit';
import { bound, objectAt } from './field';
import { Hint } from '../../widgets/hint';
import { Mark } from '../../widgets/mark';

const sample = signal('00 00 3F 80');

export function setOrder(path: Path, order: ByteOrder): void {
  const object = objectAt(path);
  if (object.byte_order !== undefined) setKeys(path, { byte_order: permutation(order) });
  else {
    const flag = (value: boolean, key: string, usual: boolean) =>
      object[key] === undefined && value === usual ? undefined : String(value);
    setKeys(path, {
      high_byte_first: flag(order.highByteFirst, 'high_byte_first', DEFAULT_ORDER.highByteFirst),
      high_register_first: flag(
        order.highRegisterFirst,
        'high_register_first',
        DEFAULT_ORDER.highRegisterFirst,
      ),
    });
  }
}

export function ByteOrderBlock({ path }: { path: Path }) {
  const texts = t.value.project.order;
  const order = effectiveOrder(objectAt(path), DEFAULT_ORDER);
  const named = bound(path, 'byte_order');
  const flags = [bound(path, 'high_byte_first'), bound(path, 'high_register_first')];
  const locked = named.locked;
  const digits = permutation(order);
  const bytes = parseBytes(sample.value);
  const findings = [named, ...flags].flatMap((its) => its.findings);
  return (
    <fieldset class="byte-order">
      <legend>{texts.title}</legend>
      <div class="switches">
        {(['highByteFirst', 'highRegisterFirst'] as const).map((key, i) => (
          <label key={key} class="check">
            <input
              type="checkbox"
              id={flags[i]!.id}
              checked={order[key]}
              disabled={locked}
              onChange={(event) => setOrder(path, { ...order, [key]: event.currentTarget.checked })}
            />
            {i === 0 ? texts.high_byte_first : texts.high_register_first}
          </label>
        ))}
        <span class="permutation" id={named.id} tabIndex={-1}>
          Float: <b>{spaced(digits)}</b>{' '}
          <Hint
            text={(['byte_order', 'high_byte_first', 'high_register_first'] as const)
              .map((key) => t.value.hints[key])
              .join(' ')}
          />
        </span>
        <Mark findings={findings} />
      </div>
      <div class="decoded">
        <label class="bytes">
          <span class="muted">{texts.bytes}</span>
          <input
            type="text"
            class="mono"
            value={sample.value}
            title={texts.bytesHint}
            aria-invalid={bytes === undefined}
            onInput={(event) => {
              sample.value = event.currentTarget.value;
            }}
          />
        </label>
        {bytes ? (
          <table>
            <thead>
              <tr>
                <th scope="col">{texts.digits}</th>
                <th scope="col" class="type-float">
                  {texts.float}
                </th>
                <th scope="col" class="type-int">
                  {texts.int32}
                </th>
              </tr>
            </thead>
            <tbody>
              {decodeAll(bytes).map((its) => (
                <tr key={its.digits} class={its.digits === digits ? 'current' : ''}>
                  <td>
                    <button
                      type="button"
                      class="mono"
                      disabled={locked}
                      aria-pressed={its.digits === digits}
                      title={texts.use(spaced(its.digits))}
                      onClick={() => setOrder(path, its.order)}
                    >
                      {spaced(its.digits)}
                    </button>
                  </td>
                  <td>{floatText(its.float)}</td>
                  <td>{formatNumber(its.int32)}</td>
                </tr>
              ))}
            </tbody>
          </table>
        ) : (
          <p class="bad small">{texts.wrong}</p>
        )}
      </div>
    </fieldset>
  );
}
