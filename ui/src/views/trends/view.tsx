import { t } from '../../i18n';

export function TrendsView() {
  return <h1>{t.value.trends.title}</h1>;
}
