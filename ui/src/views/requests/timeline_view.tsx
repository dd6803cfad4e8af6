// A round of the line as a picture: one lane for each device. Zoom with wheel, buttons or keyboard.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import type { PlannedLine } from '../../api/types';
import { formatDuration, formatNumber, t } from '../../i18n';
import { Icon } from '../../widgets/icon';
import { lightRequest, lit, revealVariable } from '../project/selection';
import { type DrawnLine, lineNumber } from './plan';
import { type Block, blocksOf, shifted, ticks, visible, type Window, zoomed } from './timeline';
import { requestKey, requestWords } from './words';

const LANE = 16;
const AXIS = 18;
const MOST_LANES = 10;
const COLOURS = 6;
const LEAST_TICK = 64; // pixels
const LABEL = 44;

/** The width of an element, also after it changed. */
function useWidth<T extends Element>() {
  const element = useRef<T>(null);
  const [width, setWidth] = useState(600);
  useEffect(() => {
    const observer = new ResizeObserver(() => setWidth(element.current?.clientWidth ?? 600));
    if (element.current) observer.observe(element.current);
    return () => observer.disconnect();
  }, []);
  return [element, width] as const;
}

function Blocks(props: {
  line: PlannedLine;
  blocks: Block[];
  lane: (request: number) => number;
  x: (ms: number) => number;
  lanes: number;
}) {
  const { line, x } = props;
  const texts = t.value.requests.timeline;
  const { variables, request: chosen } = lit.value;
  const devices = line.devices.map((its) => its.name);
  return (
    <>
      {props.blocks.map((block, i) => {
        const its = line.requests[block.request]!;
        const on =
          chosen !== null ? requestKey(its) === chosen : its.variables.some((name) => variables.has(name));
        const colour = (Math.max(0, devices.indexOf(its.device)) % COLOURS) + 1;
        const words = texts.block(
          `${its.device} ${requestWords(its)}`,
          formatDuration(block.start),
          formatDuration(block.end - block.start),
        );
        return (
          // biome-ignore lint/a11y/noStaticElementInteractions: the table of requests has it for the keyboard
          <rect
            key={i}
            class={`block ${on ? 'on' : ''} ${block.late ? 'late' : ''}`}
            x={x(block.start)}
            y={props.lane(block.request) * LANE + 2}
            width={Math.max(0.75, x(block.end) - x(block.start) - 0.5)}
            height={LANE - 4}
            style={{ fill: block.late ? 'var(--bad)' : `var(--pen-${colour})` }}
            onClick={() => {
              lightRequest(requestKey(its), its.variables);
              revealVariable(lineNumber.peek(), its.device);
            }}
          >
            <title>{block.late ? `${words}, ${texts.late}` : words}</title>
          </rect>
        );
      })}
    </>
  );
}

export function Timeline({ line }: { line: DrawnLine }) {
  const texts = t.value.requests.timeline;
  const blocks = useMemo(() => blocksOf(line.course), [line]);
  const length = line.course.length_ms;
  const [view, setView] = useState<Window | null>(null);
  const [svg, width] = useWidth<SVGSVGElement>();
  const all = { from: 0, to: length };
  const window = view && view.to <= length + 1e-6 ? view : all;
  const zoom = (factor: number, center = (window.from + window.to) / 2) => {
    const next = zoomed(window, factor, center, length);
    setView(next.to - next.from >= length ? null : next);
  };
  const move = (share: number) => setView(shifted(window, share * (window.to - window.from), length));
  useEffect(() => {
    const element = svg.current;
    const onWheel = (event: WheelEvent) => {
      event.preventDefault();
      const box = element!.getBoundingClientRect();
      const share = (event.clientX - box.left) / Math.max(1, box.width);
      if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY))
        move((event.deltaX || event.deltaY) / 800);
      else zoom(event.deltaY > 0 ? 1.25 : 0.8, window.from + share * (window.to - window.from));
    };
    // A wheel event that is cancelled needs a listener that is not passive.
    element?.addEventListener('wheel', onWheel, { passive: false });
    return () => element?.removeEventListener('wheel', onWheel);
  });
  if (blocks.length === 0) return <p class="muted small">{texts.none}</p>;
  const names = [...new Set(line.requests.filter((its) => its.period_ms !== null).map((its) => its.device))];
  const lanes = names.length <= MOST_LANES ? names.length : 1;
  const lane = (request: number) => (lanes > 1 ? names.indexOf(line.requests[request]!.device) : 0);
  const x = (ms: number) => ((ms - window.from) / (window.to - window.from)) * width;
  const keys: Record<string, () => void> = {
    '+': () => zoom(0.5),
    '=': () => zoom(0.5),
    '-': () => zoom(2),
    ArrowLeft: () => move(-0.2),
    ArrowRight: () => move(0.2),
    Home: () => setView(null),
  };
  const button = (icon: 'add' | 'remove' | 'refresh', name: string, run: () => void) => (
    <button type="button" class="icon-button" title={name} aria-label={name} onClick={run}>
      <Icon name={icon} />
    </button>
  );
  const height = lanes * LANE + AXIS;
  const marks = ticks(window, width / LEAST_TICK);
  const distance = marks.length > 1 ? x(marks[1]!) - x(marks[0]!) : width;
  return (
    <section class="timeline" aria-label={texts.label}>
      <div class="names small" style={{ gridTemplateRows: `repeat(${lanes}, ${LANE}px)` }}>
        {lanes > 1 || names.length === 1
          ? names.map((name) => (
              <span key={name} title={name}>
                {name}
              </span>
            ))
          : null}
      </div>
      <svg
        ref={svg}
        height={height}
        tabindex={0} // SVG has no tabIndex
        role="img"
        aria-label={`${texts.label}: ${formatDuration(length)}. ${texts.hint}`}
        onKeyDown={(event) => {
          const run = keys[event.key];
          if (!run || event.ctrlKey) return;
          event.preventDefault();
          run();
        }}
      >
        {marks.map((at) => (
          <g key={at}>
            <line class="tick" x1={x(at)} x2={x(at)} y1={0} y2={lanes * LANE} />
            {(x(at) < width - LABEL || distance > 2 * LABEL) && (
              <text
                x={Math.min(width - 2, x(at) + 3)}
                y={height - 5}
                text-anchor={x(at) > width - LABEL ? 'end' : 'start'}
              >
                {at === marks[0] ? `${formatNumber(at, 3)} ${t.value.units.ms}` : formatNumber(at, 3)}
              </text>
            )}
          </g>
        ))}
        <Blocks line={line} blocks={visible(blocks, window, width, lane)} lane={lane} x={x} lanes={lanes} />
      </svg>
      <div class="zoom">
        {button('add', texts.zoomIn, () => zoom(0.5))}
        {button('remove', texts.zoomOut, () => zoom(2))}
        {button('refresh', texts.fit, () => setView(null))}
      </div>
    </section>
  );
}
