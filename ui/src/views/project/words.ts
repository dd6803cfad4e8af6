// Words of types in the current language.
import { t } from '../../i18n';
import { plainType } from './cells';

export function wordType(type: string): string {
  return (t.value.project.types as Record<string, string>)[plainType(type)] ?? type;
}
