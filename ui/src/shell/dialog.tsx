import type { ComponentChildren } from 'preact';
import { useEffect, useRef } from 'preact/hooks';
import { t } from '../i18n';
import { keepFocus } from './focus';

/** A modal dialog. Escape and Cancel call onClose; the form's default button calls onAccept. */
export function Dialog(props: {
  title: string;
  accept?: string;
  acceptDisabled?: boolean;
  /** Why it cannot be accepted; empty: it can. */
  refusal?: string;
  /** Enter accepts at once. */
  focusAccept?: boolean;
  onAccept?: () => void;
  onClose: () => void;
  children: ComponentChildren;
}) {
  const element = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    const dialog = element.current;
    dialog?.showModal();
    // An element that is only removed does not give the focus back.
    return () => {
      dialog?.close();
      keepFocus();
    };
  }, []);
  const disabled = props.acceptDisabled || Boolean(props.refusal);
  const button = useRef<HTMLButtonElement>(null);
  useEffect(() => {
    if (props.focusAccept && !disabled) button.current?.focus();
  }, [disabled]);
  return (
    <dialog
      class="sheet"
      ref={element}
      aria-label={props.title}
      onCancel={(event) => {
        event.preventDefault();
        props.onClose();
      }}
    >
      <form
        method="dialog"
        onSubmit={(event) => {
          event.preventDefault();
          if (!disabled) props.onAccept?.();
        }}
      >
        <header>{props.title}</header>
        <div class="content">{props.children}</div>
        <footer>
          {props.refusal && <span class="muted small refusal">{props.refusal}</span>}
          <button type="button" class="button" onClick={props.onClose}>
            {props.onAccept ? t.value.shell.cancel : t.value.shell.close}
          </button>
          {props.onAccept && (
            <button
              ref={button}
              type="submit"
              class="button primary"
              disabled={disabled}
              title={props.refusal}
            >
              {props.accept ?? t.value.shell.ok}
            </button>
          )}
        </footer>
      </form>
    </dialog>
  );
}
