import type { DeviceStatus, LineStatus } from '../../api/types';
import { formatDuration, formatNumber, t } from '../../i18n';
import { toast } from '../../shell/toasts';
import { Icon } from '../../widgets/icon';

/** What was measured and noticed of one device, with the setting to copy where one is advised. */
export function Details({ line, device }: { line: LineStatus; device: DeviceStatus }) {
  const texts = t.value.devices;
  const findings = [device.delays?.text, device.noise?.text, device.late_responses?.text].filter(
    (text) => text !== undefined && text !== '',
  );
  const turnaround = device.turnaround;
  const advised = turnaround?.advised;
  return (
    <dl class="details">
      <dt>{texts.line(line.name)}</dt>
      <dd>
        {texts.columns.address} {device.address}
      </dd>
      <dt>{texts.columns.state}</dt>
      <dd>{t.value.state[device.state]}</dd>
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
            {texts.measuredText(
              formatDuration(turnaround.longest_ms),
              formatDuration(turnaround.p999_ms),
              formatNumber(turnaround.exchanges),
            )}
            {advised && (
              <p class="advice">
                {texts.advised} <code>{advised}</code>
                <button
                  type="button"
                  class="icon-button"
                  title={t.value.shell.copy}
                  aria-label={t.value.shell.copy}
                  onClick={() => {
                    void navigator.clipboard.writeText(advised).then(() => toast('good', advised));
                  }}
                >
                  <Icon name="copy" />
                </button>
              </p>
            )}
          </dd>
        </>
      )}
      <dt>{texts.findings}</dt>
      <dd>
        {findings.length === 0 && <span class="muted">{texts.well}</span>}
        {findings.map((text) => (
          <p key={text}>{text}</p>
        ))}
      </dd>
    </dl>
  );
}
