import type { Texts } from '..';
import { devices } from './devices';
import { hints } from './hints';
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
  hints,
  words,
  overview,
  project,
  requests,
  live,
  trends,
  traffic,
  devices,
};
