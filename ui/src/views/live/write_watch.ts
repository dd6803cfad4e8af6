// Compares the first read after a write with what was written, for variables that are not verified.
import type { Scalar } from '../../api/types';
import { t } from '../../i18n';
import { toast } from '../../shell/toasts';
import { liveValue, readObservers } from '../../store/live';
import { type OpenWrite, readAfter, valueText } from './writing';

const open = new Map<string, OpenWrite>();

/** Another write of the variable begins: its value may be read before its outcome is known. */
export const endWatch = (name: string) => open.delete(name);

export function watchWrite(name: string, write: OpenWrite): void {
  open.set(name, write);
  readObservers.add(compare);
  compare();
}

function compare(): void {
  const texts = t.peek().live;
  const text = (value: Scalar) => valueText(value, texts.boolean);
  for (const [name, write] of open) {
    const its = liveValue(name)?.peek();
    const read = its ? readAfter(write, its) : null;
    if (its && read === null) continue;
    open.delete(name); // also if another project runs, without this variable
    if (read !== null && read !== write.written)
      toast('bad', texts.differs(name, text(write.written), text(read)));
  }
  if (open.size === 0) readObservers.delete(compare);
}
