// The state of a device in words.
import type { DeviceStatus } from '../../api/types';
import { t } from '../../i18n';

/** A device whose responses are damaged or do not fit is not called silent. */
export function stateText({ state, cause }: Pick<DeviceStatus, 'state' | 'cause'>): string {
  if (state === 'not_answering' && cause === 'bad_checksum') return t.value.state.damaged;
  if (state === 'not_answering' && cause === 'unexpected_reply') return t.value.state.unfitting;
  return t.value.state[state];
}
