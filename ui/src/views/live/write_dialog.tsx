// Writing a value: change and frame before, a question where the value is doubtful, and the outcome.
import { useEffect, useState } from 'preact/hooks';
import { post } from '../../api/client';
import type { CommandPreview, CommandResult, LiveValue, Scalar } from '../../api/types';
import { formatDuration, t } from '../../i18n';
import { Dialog } from '../../shell/dialog';
import { errorText, toast } from '../../shell/toasts';
import { exchangeTime } from '../../store/clock';
import { liveValue, values } from '../../store/live';
import { withoutUnit } from '../traffic/words';
import { endWatch, watchWrite } from './write_watch';
import { changeText, type Doubt, doubtOf, parsedValue, proofOf, valueText } from './writing';

const PREVIEW_AFTER_MS = 150;

/** Watches the reads that begin after this instant, by the clock of the program. */
async function watch(name: string, written: Scalar): Promise<void> {
  try {
    watchWrite(name, { written, after: await exchangeTime() });
  } catch {
    // Without the program there are no reads to compare.
  }
}

/** The preview of a typed text. */
interface Preview extends CommandPreview {
  of: string;
}

const rangeText = ({ least, greatest }: NonNullable<LiveValue['write_range']>) =>
  `${least ?? ''}..${greatest ?? ''}`;

export function WriteDialog({ value, onClose }: { value: LiveValue; onClose: () => void }) {
  const texts = t.value.live;
  // A new snapshot replaces the signals of all values.
  void values.value;
  const now = liveValue(value.name)?.value ?? value;
  const [text, setText] = useState(value.value === null && value.type === 'bool' ? 'false' : value.text);
  const [preview, setPreview] = useState<Preview | null>(null);
  const [problem, setProblem] = useState('');
  const [busy, setBusy] = useState(false);
  const [accepted, setAccepted] = useState(false);
  const [doubt, setDoubt] = useState<Doubt | null>(null);
  const body = {
    kind: value.local ? 'set' : 'write',
    variable: value.name,
    value: parsedValue(value.type, text),
  };
  const current = preview?.of === text ? preview : null;
  const nowText = valueText(now.type === 'bool' ? now.value : now.text, texts.boolean);
  const nextText = (its: Preview) => valueText(its.value_written, texts.boolean, text.trim());

  useEffect(() => {
    const stop = new AbortController();
    const timer = setTimeout(() => {
      post<CommandPreview>('commands/preview', body, stop.signal)
        .then((its) => {
          setPreview({ ...its, of: text });
          setProblem('');
        })
        .catch((failure) => {
          if (stop.signal.aborted) return;
          setPreview(null);
          setAccepted(false);
          setProblem(errorText(failure));
        });
    }, PREVIEW_AFTER_MS);
    return () => {
      clearTimeout(timer);
      stop.abort();
    };
  }, [text]);

  const send = async (its: Preview) => {
    setBusy(true);
    endWatch(value.name);
    try {
      const result = await post<CommandResult>('commands', body);
      const good = result.outcome === 'done' || result.outcome === 'waiting';
      const read = result.read_back === undefined ? '' : ` ${texts.readBack(String(result.read_back))}`;
      const proof = proofOf(now);
      toast(
        good ? 'good' : 'bad',
        result.outcome === 'done'
          ? texts.done[proof](value.name, nextText(its))
          : `${value.name}: ${texts.outcome[result.outcome]}${result.text ? `. ${result.text}` : ''}${read}`,
      );
      if (result.outcome === 'done' && proof === 'acknowledged' && !now.write_only)
        void watch(value.name, its.value_written);
      onClose();
    } catch (failure) {
      setProblem(errorText(failure));
    }
    setBusy(false);
  };

  const accept = (its: Preview) => {
    const why = doubtOf(now, its.value_written);
    if (why) setDoubt(why);
    else void send(its);
  };
  // Enter may come before the preview, which decides whether to ask back.
  useEffect(() => {
    if (!accepted || !current) return;
    setAccepted(false);
    accept(current);
  }, [accepted, current]);

  if (doubt && current)
    return (
      <Dialog
        key="doubt"
        title={texts.confirmTitle(value.name)}
        accept={texts.writeAnyway}
        acceptDisabled={busy}
        onAccept={() => void send(current)}
        onClose={() => setDoubt(null)}
      >
        <p>
          {texts.doubt[doubt](
            nextText(current),
            doubt === 'range' && now.write_range ? rangeText(now.write_range) : nowText,
          )}
        </p>
        <p class="value">{changeText(nowText, nextText(current), value.unit)}</p>
        <p role="alert" class="problem">
          {problem}
        </p>
      </Dialog>
    );
  return (
    <Dialog
      key="write"
      title={texts.writeTitle(value.name)}
      accept={texts.write}
      acceptDisabled={busy || accepted || preview === null}
      onAccept={() => setAccepted(true)}
      onClose={onClose}
    >
      <div class="write-form">
        <span class="muted">{texts.current}</span>
        <span>
          {nowText} {value.unit}
        </span>
        <label class="muted" for="new-value">
          {texts.newValue}
        </label>
        <span class="entry">
          {value.type === 'bool' ? (
            <select id="new-value" value={text} onChange={(event) => setText(event.currentTarget.value)}>
              <option value="true">{texts.boolean.on}</option>
              <option value="false">{texts.boolean.off}</option>
            </select>
          ) : (
            <input
              id="new-value"
              type="text"
              value={text}
              aria-invalid={problem !== ''}
              aria-describedby="write-problem"
              // A dialog puts the cursor behind the text: typing would append.
              onFocus={(event) => event.currentTarget.select()}
              onInput={(event) => {
                setText(event.currentTarget.value);
                setAccepted(false);
              }}
            />
          )}{' '}
          {value.unit}
        </span>
        <span class="muted">{texts.change}</span>
        <span class="change">{current && changeText(nowText, nextText(current), value.unit)}</span>
        <span class="muted">{texts.frame}</span>
        <span>
          {preview?.frames.map((frame) => (
            <span key={frame.raw} class="frame">
              <code>{frame.raw}</code>
              <span class="muted small">
                {withoutUnit(frame.words)}
                {' · '}
                {texts.busTime} {formatDuration(frame.bus_time_us / 1000)}
              </span>
            </span>
          ))}
          {preview?.frames.length === 0 && <span class="muted">{texts.noFrame}</span>}
          {preview?.rounded && <p class="small">{texts.rounded(String(preview.value_written))}</p>}
          <span id="write-problem" role="alert" class="problem">
            {problem}
          </span>
        </span>
      </div>
    </Dialog>
  );
}
