import { t } from '../../i18n';

export function LiveView() {
  return <h1>{t.value.live.title}</h1>;
}
