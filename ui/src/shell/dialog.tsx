import type { ComponentChildren } from 'preact';
import { useEffect, useRef } from 'preact/hooks';
import { t } from '../i18n';

/** A modal dialog. Escape and Cancel call onClose; the form's default button calls onAccept. */
export function Dialog(props: {
  title: string;
  accept?: string;
  acceptDisabled?: boolean;
  /** Enter accepts at once. */
  focusAccept?: boolean;
  onAccept?: () => void;
  onClose: () => void;
  children: ComponentChildren;
}) {
  const element = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    element.current?.showModal();
  }, []);
  const button = useRef<HTMLButtonElement>(null);
  useEffect(() => {
    if (props.focusAccept && !props.acceptDisabled) button.current?.focus();
  }, [props.acceptDisabled]);
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
          if (!props.acceptDisabled) props.onAccept?.();
        }}
      >
        <header>{props.title}</header>
        <div class="content">{props.children}</div>
        <footer>
          <button type="button" class="button" onClick={props.onClose}>
            {props.onAccept ? t.value.shell.cancel : t.value.shell.close}
          </button>
          {props.onAccept && (
            <button ref={button} type="submit" class="button primary" disabled={props.acceptDisabled}>
              {props.accept ?? t.value.shell.ok}
            </button>
          )}
        </footer>
      </form>
    </dialog>
  );
}
