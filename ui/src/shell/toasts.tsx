import { signal } from '@preact/signals';
import { ApiError } from '../api/client';
import { t } from '../i18n';
import { Icon } from '../widgets/icon';

interface Toast {
  id: number;
  kind: 'good' | 'bad' | 'info';
  text: string;
}
const MOST = 4;
const GOOD_MS = 5000;

const toasts = signal<Toast[]>([]);
let last = 0;

const remove = (id: number) => {
  toasts.value = toasts.peek().filter((its) => its.id !== id);
};

/** Errors stay until they are closed. */
export function toast(kind: Toast['kind'], text: string): void {
  const id = ++last;
  toasts.value = [...toasts.peek(), { id, kind, text }].slice(-MOST);
  if (kind !== 'bad') setTimeout(() => remove(id), GOOD_MS);
}

export function errorText(failure: unknown): string {
  if (failure instanceof ApiError && failure.status === 0) return t.peek().shell.unreachable;
  return failure instanceof Error ? failure.message : String(failure);
}
export const toastError = (failure: unknown) => toast('bad', errorText(failure));

export function Toasts() {
  return (
    <div class="toasts" role="status" aria-live="polite">
      {toasts.value.map((its) => (
        <div key={its.id} class={`toast ${its.kind}`}>
          <p>{its.text}</p>
          <button
            type="button"
            class="icon-button"
            aria-label={t.value.shell.close}
            onClick={() => remove(its.id)}
          >
            <Icon name="close" />
          </button>
        </div>
      ))}
    </div>
  );
}
