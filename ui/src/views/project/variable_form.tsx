// All fields of one variable, as in the IDE's window: below the table, for the row that is selected.
import { t } from '../../i18n';
import type { Path } from '../../store/document';
import { KeyField, objectAt } from './field';
import { plainType } from './cells';

export function VariableForm({ path }: { path: Path }) {
  const its = objectAt(path);
  const type = plainType(String(its.type ?? ''));
  const bool = type === 'bool';
  const text = type === 'string';
  const names = [
    'name',
    'type',
    'register',
    ...(bool ? ['bit'] : []),
    ...(text ? ['length'] : []),
    'read',
    'write',
    'write_on_change',
    'read_trigger',
    'write_trigger',
    'status',
    'comment',
  ];
  const more = [
    'period',
    'deadline',
    'max_age',
    'min_interval',
    'burst',
    'default',
    'hold_last',
    'retain',
    'used',
    'unit',
    ...(bool || text
      ? []
      : ['scale', 'offset', 'dead_band', 'write_range', 'byte_order', 'enumeration', 'bits']),
    'area',
    ...(bool ? ['coil'] : []),
    'reference',
    'verify',
    'safe_to_repeat',
    'tags',
  ];
  return (
    <div class="form variable-form">
      <div class="fields">
        {names.map((name) => (
          <KeyField key={name} path={path} object="variable" name={name} />
        ))}
      </div>
      <details class="more">
        <summary>{t.value.project.more}</summary>
        <div class="fields">
          {more.map((name) => (
            <KeyField key={name} path={path} object="variable" name={name} />
          ))}
        </div>
      </details>
    </div>
  );
}
