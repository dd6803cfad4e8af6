import { t } from '../../i18n';

export function DevicesView() {
  return <h1>{t.value.devices.title}</h1>;
}
