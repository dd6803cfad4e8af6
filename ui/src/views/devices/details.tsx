import type { DeviceStatus, LineStatus } from '../../api/types';
import { formatDuration, formatNumber, t } from '../../i18n';
import { ProblemList } from '../../shell/problems';
import { toast } from '../../shell/toasts';
import { status } from '../../store/info';
import { Icon } from '../../widgets/icon';
import { LearntBlock } from './learnt';
import { deviceState, measuredText } from './state';
import { AttemptText, NextProbe, TryNow } from './try_now';

/** A setting for the project, to be copied. */
function Advice({ setting }: { setting: string }) {
  return (
    <p class="advice">
      {t.value.devices.advised} <code>{setting}</code>
      <button
        type="button"
        class="icon-button"
        title={t.value.shell.copy}
        aria-label={`${t.value.shell.copy}: ${setting}`}
        onClick={() => {
          void navigator.clipboard.writeText(setting).then(() => toast('good', setting));
        }}
      >
        <Icon name="copy" />
      </button>
    </p>
  );
}

/** What was measured and noticed of one device, with the setting to copy where one is advised. */
export function Details({ line, device }: { line: LineStatus; device: DeviceStatus }) {
  const texts = t.value.devices;
  const problems = status.value?.problems ?? [];
  const { turnaround, late_responses: late, delays } = device;
  return (
    <dl class="details">
      <dt>{texts.line(line.name)}</dt>
      <dd>
        {texts.columns.address} {device.address}
      </dd>
      <dt>{texts.columns.state}</dt>
      <dd>
        {deviceState(line.name, device).text}
        {device.cause && <span class="muted"> ({texts.cause(device.cause)})</span>}
        <AttemptText line={line} device={device} />
      </dd>
      {device.back_off && (
        <>
          <dt>{texts.backOff}</dt>
          <dd>
            <NextProbe device={device} />
            <p>
              <TryNow line={line} device={device} />
            </p>
          </dd>
        </>
      )}
      <dt>{texts.outages}</dt>
      <dd>{formatNumber(device.outages)}</dd>
      <dt>{texts.downtime}</dt>
      <dd>{formatDuration(device.downtime_ms)}</dd>
      <dt>{texts.surplus}</dt>
      <dd>{formatNumber(device.surplus_answers)}</dd>
      {turnaround && (
        <>
          <dt>{texts.measured}</dt>
          <dd>
            {measuredText(turnaround)}
            {turnaround.learnt && <p class="muted">{texts.turnaroundLearnt}</p>}
            {turnaround.advised && <Advice setting={`turnaround: ${turnaround.advised}`} />}
          </dd>
        </>
      )}
      {(late || delays) && (
        <>
          <dt>{texts.lateness}</dt>
          <dd>
            {late &&
              texts.latenessText(
                formatNumber(late.count),
                formatNumber(late.requests),
                formatDuration(late.longest_ms),
              )}
            {delays && <p>{delays.text}</p>}
            {delays?.advised_ms && (
              <Advice setting={`${delays.setting}: ${Math.ceil(delays.advised_ms)}ms`} />
            )}
            {delays?.advised_ms && delays.later > 0 && (
              <p class="muted">{texts.later(delays.later, formatNumber(delays.count))}</p>
            )}
          </dd>
        </>
      )}
      <LearntBlock line={line} device={device} />
      <dt>{texts.findings}</dt>
      <dd>
        <ProblemList
          problems={problems.filter(
            (its) => its.line === line.name && (its.device ?? device.name) === device.name,
          )}
        />
      </dd>
    </dl>
  );
}
