/**
 * After what may have removed or disabled the element with the focus: then the tree of the project has it, or
 * the view.
 */
export function keepFocus(): void {
  requestAnimationFrame(() =>
    setTimeout(() => {
      const its = document.activeElement;
      if (its && its !== document.body && !its.matches(':disabled')) return;
      document.querySelector<HTMLElement>('.tree, #main:not(:has(.tree))')?.focus();
    }),
  );
}
