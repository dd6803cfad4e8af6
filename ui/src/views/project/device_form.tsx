// The settings of a device, in the order of the IDE's window.
import type { ComponentChildren } from 'preact';
import type { Mapping } from '../../api/types';
import { t } from '../../i18n';
import { at, isMapping, listAt, type Path, textAt } from '../../store/document';
import { draft } from '../../store/project';
import { strategyOf } from '../requests/figures';
import { ByteOrderBlock } from './byte_order_block';
import { readOnly, setKey, setKeys } from './edit';
import { bound, isWrong, KeyField, objectAt, Row } from './field';
import { hintText, keyText, profileOf, rulesAt, wordText } from './rules';
import { framingOf, isNetwork, transportOf } from './tree';
import { protocolText } from './words';

const MORE = [
  'strategy',
  'gaps',
  'readable',
  'no_read',
  'offers',
  'turnaround',
  'deadline',
  'round_trip',
  'in_flight',
  'write_single',
  'fc22',
  'fc23',
  'read_modify_write',
  'backoff',
  'notation',
  'device_template',
];

/** The protocol is a setting of the line: the field says so. */
function Protocol({ path }: { path: Path }) {
  const texts = t.value.project.protocol;
  const linePath = path.slice(0, 2);
  const line = objectAt(linePath);
  const rule = rulesAt(linePath, 'line').framing;
  const words = (rule?.words ?? ['rtu', 'ascii']).filter((its) => rule?.allowed.includes(its) ?? true);
  const its = bound(linePath, 'framing');
  const value = framingOf(line);
  const limit = rulesAt(path, 'device').registers_per_request;
  const count = listAt(line, ['devices']).length;
  const ofLine = texts.ofLine(textAt(line, ['name']) ?? '', count);
  return (
    <Row
      id={`${its.id}-of-device`}
      label={keyText('framing')}
      help={hintText('framing', 'line')}
      findings={its.findings}
      note={`${ofLine} ${limit?.greatest ? texts.cut(limit.greatest) : ''}`}
      wide
    >
      <select
        id={`${its.id}-of-device`}
        value={value}
        disabled={its.locked}
        aria-invalid={isWrong(its.findings)}
        onChange={(event) => setKey(linePath, 'framing', event.currentTarget.value)}
      >
        {[...new Set([...words, value])].map((word) => (
          <option key={word} value={word}>
            {protocolText(transportOf(line), word)}
          </option>
        ))}
      </select>
    </Row>
  );
}

// How requests were formed before grouping was switched off, for the way back.
const before = new Map<string, { group_requests: string | undefined; strategy: string | undefined }>();

function Grouping({ path, device }: { path: Path; device: Mapping }) {
  const texts = t.value.project.grouping;
  const its = bound(path, 'group_requests');
  const strategy = strategyOf(device, profileOf(draft.value));
  const set = (on: boolean) => {
    const key = textAt(device, ['name']) ?? its.id;
    if (!on) {
      before.set(key, {
        group_requests: textAt(device, ['group_requests']),
        strategy: textAt(device, ['strategy']),
      });
      setKeys(path, { group_requests: 'false', strategy: undefined });
    } else {
      const kept = before.get(key);
      const wasOff = kept === undefined || kept.group_requests === 'false' || kept.strategy === 'single';
      setKeys(path, wasOff ? { group_requests: 'true', strategy: undefined } : kept);
    }
  };
  return (
    <Row
      id={its.id}
      label={keyText('group_requests')}
      help={`${hintText('group_requests', 'device')} ${hintText('strategy', 'device')}`}
      findings={its.findings}
      note={strategy === 'single' ? texts.off : texts.strategy(wordText(strategy))}
    >
      <select
        id={its.id}
        value={strategy === 'single' ? 'false' : 'true'}
        disabled={its.locked || readOnly([...path, 'strategy']) !== null}
        onChange={(event) => set(event.currentTarget.value === 'true')}
      >
        <option value="true">{t.value.shell.yes}</option>
        <option value="false">{t.value.shell.no}</option>
      </select>
    </Row>
  );
}

export function More({ name, children }: { name: string; children: ComponentChildren }) {
  return (
    <details class="more">
      <summary>{name}</summary>
      <div class="fields">{children}</div>
    </details>
  );
}

export function DeviceForm({ path }: { path: Path }) {
  const device = objectAt(path);
  const line = at(draft.value, path.slice(0, 2));
  const tcp = isMapping(line) && isNetwork(transportOf(line));
  const off = strategyOf(device, profileOf(draft.value)) === 'single';
  const field = (name: string, rest = {}) => (
    <KeyField key={name} path={path} object="device" name={name} {...rest} />
  );
  return (
    <div class="form">
      <div class="fields">
        {field('name')}
        {field('address')}
        {field('poll_period')}
        {field('response_timeout')}
        {field('attempts')}
        {field('status')}
        {field('poll_enable')}
        <Protocol path={path} />
        <Grouping path={path} device={device} />
        {field('registers_per_request', { disabled: off })}
      </div>
      <ByteOrderBlock path={path} />
      <div class="fields">{field('comment', { wide: true })}</div>
      <More name={t.value.project.more}>
        {MORE.filter((name) => tcp || (name !== 'round_trip' && name !== 'in_flight') || device[name]).map(
          (name) => field(name),
        )}
      </More>
    </div>
  );
}
