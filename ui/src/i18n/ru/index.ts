import type { Texts } from '..';
import { devices } from './devices';
import { keys, objectKeys, words } from './keys';
import { live } from './live';
import { overview } from './overview';
import { project } from './project';
import { requests } from './requests';
import { shell } from './shell';
import { traffic } from './traffic';
import { trends } from './trends';

export const ru: Texts = {
  ...shell,
  keys,
  objectKeys,
  words,
  overview,
  project,
  requests,
  live,
  trends,
  traffic,
  devices,
};
