import { t } from '../../i18n';

export function TrafficView() {
  return <h1>{t.value.traffic.title}</h1>;
}
