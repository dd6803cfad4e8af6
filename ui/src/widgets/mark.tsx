import type { Finding } from '../api/types';

/** The icon with the exclamation mark; its tooltip has the message and the permitted range. */
export function Mark({ id, findings }: { id?: string; findings: Finding[] }) {
  const shown = findings.filter((its) => its.severity !== 'note');
  const first = shown.find((its) => its.severity === 'error') ?? shown[0];
  if (!first) return null;
  return (
    <button type="button" class={`mark ${first.severity}`} aria-label={first.message}>
      !
      <span class="tip" id={id} role="tooltip">
        {shown.map((its) => (
          <span key={its.code + its.value}>
            {its.message}
            {its.advice && <span class="muted"> {its.advice}</span>}
            <br />
          </span>
        ))}
      </span>
    </button>
  );
}
