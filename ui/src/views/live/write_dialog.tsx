// Writing a value: preview of the frame, confirmation, outcome and what was read back.
import { useEffect, useState } from 'preact/hooks';
import { post } from '../../api/client';
import type { CommandPreview, CommandResult, LiveValue, Scalar } from '../../api/types';
import { formatDuration, t } from '../../i18n';
import { Dialog } from '../../shell/dialog';
import { errorText, toast } from '../../shell/toasts';
import { translated } from '../traffic/words';

const PREVIEW_AFTER_MS = 150;

/** The typed text as a value; the program checks range and type. */
function parsed(type: string, text: string): Scalar {
  if (type === 'bool') return text === 'true';
  if (type === 'string') return text;
  const number = Number(text.trim().replace(',', '.'));
  return text.trim() === '' || Number.isNaN(number) ? text : number;
}

export function WriteDialog({ value, onClose }: { value: LiveValue; onClose: () => void }) {
  const texts = t.value.live;
  const [text, setText] = useState(String(value.value ?? (value.type === 'bool' ? 'false' : '')));
  const [preview, setPreview] = useState<CommandPreview | null>(null);
  const [problem, setProblem] = useState('');
  const [busy, setBusy] = useState(false);
  const body = {
    kind: value.local ? 'set' : 'write',
    variable: value.name,
    value: parsed(value.type, text),
  };

  useEffect(() => {
    const stop = new AbortController();
    const timer = setTimeout(() => {
      post<CommandPreview>('commands/preview', body, stop.signal)
        .then((its) => {
          setPreview(its);
          setProblem('');
        })
        .catch((failure) => {
          if (stop.signal.aborted) return;
          setPreview(null);
          setProblem(errorText(failure));
        });
    }, PREVIEW_AFTER_MS);
    return () => {
      clearTimeout(timer);
      stop.abort();
    };
  }, [text]);

  const send = async () => {
    setBusy(true);
    try {
      const result = await post<CommandResult>('commands', body);
      const good = result.outcome === 'done' || result.outcome === 'waiting';
      const read = result.read_back === undefined ? '' : ` ${texts.readBack(String(result.read_back))}`;
      toast(
        good ? 'good' : 'bad',
        result.outcome === 'done'
          ? texts.done(value.name, text) + (read && `.${read}`)
          : `${value.name}: ${texts.outcome[result.outcome]}${result.text ? `. ${result.text}` : ''}${read}`,
      );
      onClose();
    } catch (failure) {
      setProblem(errorText(failure));
    }
    setBusy(false);
  };

  return (
    <Dialog
      title={texts.writeTitle(value.name)}
      accept={texts.write}
      acceptDisabled={busy || preview === null}
      onAccept={() => void send()}
      onClose={onClose}
    >
      <div class="write-form">
        <span class="muted">{texts.current}</span>
        <span>
          {value.text || '–'} {value.unit}
        </span>
        <label class="muted" for="new-value">
          {texts.newValue}
        </label>
        <span>
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
              onInput={(event) => setText(event.currentTarget.value)}
            />
          )}{' '}
          {value.unit}
        </span>
        <span class="muted">{texts.frame}</span>
        <span>
          {preview?.frames.map((frame) => (
            <span key={frame.raw} class="frame">
              <code>{frame.raw}</code>
              <span class="muted small">
                {translated(frame.words)}
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
