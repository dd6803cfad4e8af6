import { t } from '../../i18n';

export function ProjectView() {
  return <h1>{t.value.project.title}</h1>;
}
