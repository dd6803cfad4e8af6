// Tabs with the keyboard of the ARIA pattern: arrows move, one tab stop.
export function TabBar(props: {
  name: string;
  label: string;
  value: string;
  tabs: { value: string; title: string; class?: string }[];
  /** The id of what the tabs show; else `name`-panel. */
  controls?: string;
  onValue: (value: string) => void;
}) {
  const move = (event: KeyboardEvent) => {
    const now = props.tabs.findIndex((its) => its.value === props.value);
    const steps: Record<string, number> = {
      ArrowRight: now + 1,
      ArrowLeft: now - 1,
      Home: 0,
      End: props.tabs.length - 1,
    };
    const to = steps[event.key];
    const next = to === undefined ? undefined : props.tabs[(to + props.tabs.length) % props.tabs.length];
    if (!next) return;
    event.preventDefault();
    props.onValue(next.value);
    document.getElementById(`${props.name}-${next.value}`)?.focus();
  };
  return (
    <div class="tabs" role="tablist" aria-label={props.label} onKeyDown={move}>
      {props.tabs.map((its) => (
        <button
          key={its.value}
          type="button"
          role="tab"
          id={`${props.name}-${its.value}`}
          class={its.class}
          aria-selected={its.value === props.value}
          aria-controls={props.controls ?? `${props.name}-panel`}
          tabIndex={its.value === props.value ? 0 : -1}
          onClick={() => props.onValue(its.value)}
        >
          {its.title}
        </button>
      ))}
    </div>
  );
}
