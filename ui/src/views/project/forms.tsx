// The forms of lines, servers, units, outputs, instruments, and of the project itself.
import type { ComponentChildren } from 'preact';
import { t } from '../../i18n';
import type { Path } from '../../store/document';
import { ByteOrderBlock } from './byte_order_block';
import { More } from './device_form';
import { KeyField, objectAt } from './field';
import { Part } from './parts';
import { VariableTable } from './table';
import { isNetwork, serverTransportOf, transportOf } from './tree';

function Fields(props: { path: Path; object: string; names: string[] }) {
  return (
    <div class="fields">
      {props.names.map((name) => (
        <KeyField key={name} path={props.path} object={props.object} name={name} />
      ))}
    </div>
  );
}

function Group({ title, children }: { title: string; children: ComponentChildren }) {
  return (
    <section class="group">
      <h2>{title}</h2>
      {children}
    </section>
  );
}

/** Parts with fields of their own. */
function Parts({ path, object, names }: { path: Path; object: string; names: string[] }) {
  return (
    <Group title={t.value.project.groups.nested}>
      {names.map((name) => (
        <Part key={name} path={path} object={object} name={name} />
      ))}
    </Group>
  );
}

const SERIAL = ['baud', 'parity', 'stop_bits', 'data_bits'];

export function LineForm({ path }: { path: Path }) {
  const texts = t.value.project;
  const transport = transportOf(objectAt(path));
  const where = transport === 'serial' ? ['port'] : isNetwork(transport) ? ['host', 'tcp_port'] : [];
  const characters = isNetwork(transport) ? [] : SERIAL;
  return (
    <div class="form">
      {transport === 'simulated' && <p class="banner info">{texts.importing.simulated}</p>}
      <Group title={texts.groups.line}>
        <Fields path={path} object="line" names={['name', 'transport', ...where, 'framing', ...characters]} />
      </Group>
      <Group title={texts.groups.polling}>
        <Fields path={path} object="line" names={['order', 'request_gap', 'frame_gap']} />
      </Group>
      <More name={texts.more}>
        {[
          ...(transport === 'serial' ? ['rs485'] : []),
          'byte_timeout',
          ...(isNetwork(transport)
            ? ['connection', 'idle_close', 'pause_after_connect', 'connections_per_host', 'length_tolerance']
            : []),
          'relay_interval',
          'command_interval',
          'command_burst',
        ].map((name) => (
          <KeyField key={name} path={path} object="line" name={name} />
        ))}
      </More>
    </div>
  );
}

export function ServerForm({ path }: { path: Path }) {
  const texts = t.value.project;
  const tcp = isNetwork(serverTransportOf(objectAt(path)));
  const where = tcp ? ['listen', 'tcp_port'] : ['port'];
  return (
    <div class="form">
      <Group title={texts.groups.server}>
        <Fields
          path={path}
          object="server"
          names={['name', 'transport', ...where, 'framing', ...(tcp ? [] : SERIAL)]}
        />
      </Group>
      <More name={texts.more}>
        {(tcp
          ? ['max_connections', 'max_per_peer', 'frame_timeout', 'idle_timeout', 'write_timeout', 'audit']
          : ['rs485', 'strict', 'turnaround', 'byte_timeout', 'audit']
        ).map((name) => (
          <KeyField key={name} path={path} object="server" name={name} />
        ))}
      </More>
      <Parts path={path} object="server" names={['access', 'relay']} />
    </div>
  );
}

export function UnitForm({ path }: { path: Path }) {
  const texts = t.value.project;
  return (
    <div class="form">
      <Fields path={path} object="unit" names={['address', 'server_id', 'durability', 'state']} />
      <Group title={texts.tabs.banks}>
        <VariableTable path={[...path, 'banks']} object="bank" label={texts.tabs.banks} />
      </Group>
      <ByteOrderBlock path={path} />
      <More name={texts.more}>
        {['exception_coils', 'restart', 'listen_only', 'notation'].map((name) => (
          <KeyField key={name} path={path} object="unit" name={name} />
        ))}
      </More>
      <Parts path={path} object="unit" names={['mirror', 'limits', 'identification', 'files', 'fifos']} />
    </div>
  );
}

const MQTT = [
  'version',
  'client_id',
  'user',
  'password_file',
  'password_env',
  'keep_alive',
  'backoff',
  'in_flight',
  'round_trip',
  'backlog',
];
const TLS = ['ca_file', 'certificate_file', 'key_file', 'alpn'];
const SELECTION = [
  'variables',
  'devices',
  'tags',
  'on_change',
  'period',
  'dead_band',
  'heartbeat',
  'bad_quality',
];
const STORE = ['quota_mb', 'retention', 'buffer_mb', 'directory'];

export function OutputForm({ path }: { path: Path }) {
  const texts = t.value.project;
  const mqtt = objectAt(path).transport !== 'history';
  return (
    <div class="form">
      <Group title={texts.groups.output}>
        <Fields
          path={path}
          object="output"
          names={['name', 'transport', ...(mqtt ? ['brokers', 'topic', 'message'] : [])]}
        />
        {mqtt && (
          <div class="fields">
            <KeyField path={path} object="output" name="retain" label={t.value.keys.mqtt_retain} />
          </div>
        )}
      </Group>
      <Group title={t.value.keys.select}>
        <Fields path={path} object="output" names={SELECTION} />
      </Group>
      <More name={texts.more}>
        {[...(mqtt ? [...MQTT, ...TLS, 'control_topic', 'commands', 'command_expiry'] : []), ...STORE].map(
          (name) => (
            <KeyField key={name} path={path} object="output" name={name} />
          ),
        )}
      </More>
      <Parts path={path} object="output" names={['select']} />
    </div>
  );
}

export function InstrumentForm({ path }: { path: Path }) {
  const texts = t.value.project;
  const transport = transportOf(objectAt(path));
  const where = transport === 'tcp' ? ['host', 'tcp_port'] : ['port', ...SERIAL];
  return (
    <div class="form">
      <Group title={texts.groups.instrument}>
        <Fields path={path} object="instrument" names={['name', 'transport', ...where]} />
      </Group>
      <Group title={texts.groups.polling}>
        <Fields path={path} object="instrument" names={['every', 'timeout', 'silent_after', 'start_retry']} />
      </Group>
      <Parts path={path} object="instrument" names={['exchanges', 'commands', 'start', 'reset']} />
    </div>
  );
}

export function ProjectForm() {
  const texts = t.value.project;
  return (
    <div class="form">
      <Group title={texts.groups.project}>
        <Fields
          path={[]}
          object="project"
          names={['profile', 'derive_timeouts', 'timeout_margin', 'backoff']}
        />
      </Group>
      <Group title={texts.groups.computer}>
        <Fields path={['host']} object="host" names={['jitter', 'overhead']} />
      </Group>
      <Group title={texts.groups.faults}>
        <Fields path={['faults']} object="faults" names={['burst', 'every']} />
      </Group>
    </div>
  );
}
