import type { ComponentChildren } from 'preact';
import { useState } from 'preact/hooks';
import { t } from '../i18n';

/** Two panes with a movable border; one below the other on a narrow screen. */
export function Split(props: {
  name: string;
  start: number;
  left: ComponentChildren;
  right: ComponentChildren;
}) {
  const key = `takt.split.${props.name}`;
  const [percent, setPercent] = useState(Number(localStorage.getItem(key)) || props.start);
  const set = (value: number) => {
    const next = Math.min(80, Math.max(20, value));
    setPercent(next);
    localStorage.setItem(key, String(next));
  };
  const drag = (event: PointerEvent) => {
    const handle = event.currentTarget as HTMLElement;
    const box = handle.parentElement!.getBoundingClientRect();
    handle.setPointerCapture(event.pointerId);
    const move = (its: PointerEvent) => set(((its.clientX - box.left) / box.width) * 100);
    handle.addEventListener('pointermove', move);
    handle.addEventListener('pointerup', () => handle.removeEventListener('pointermove', move), {
      once: true,
    });
  };
  return (
    <div class="split" style={{ '--left': `${percent}%` }}>
      <div class="pane">{props.left}</div>
      <div
        class="handle"
        role="separator"
        tabIndex={0}
        aria-orientation="vertical"
        aria-label={t.value.shell.resize}
        aria-valuenow={Math.round(percent)}
        onPointerDown={drag}
        onKeyDown={(event) => {
          if (event.key === 'ArrowLeft') set(percent - 2);
          if (event.key === 'ArrowRight') set(percent + 2);
        }}
      />
      <div class="pane">{props.right}</div>
    </div>
  );
}
