// Server-sent events that connect again by themselves, and report whether they are connected.
import { language } from '../i18n';
import { openUrl } from './client';

export interface Stream {
  close(): void;
}

const FIRST_PAUSE = 500;
const LONGEST_PAUSE = 8000;

/**
 * Its texts are in the language of the page: it is opened anew when that changes.
 * @param handlers  by name of the event; called with the parsed data
 * @param state     called when the connection opens or is lost
 */
export function openStream(
  path: string,
  handlers: Record<string, (data: never) => void>,
  state: (connected: boolean) => void,
  query: Record<string, string> = {},
): Stream {
  let source: EventSource | null = null;
  let timer = 0;
  let pause = FIRST_PAUSE;
  let closed = false;

  const connect = () => {
    source = new EventSource(openUrl(path, query));
    source.onopen = () => {
      pause = FIRST_PAUSE;
      state(true);
    };
    // The browser's own reconnection gives up after some errors; this one does not.
    source.onerror = () => {
      source?.close();
      state(false);
      if (closed) return;
      timer = window.setTimeout(connect, pause);
      pause = Math.min(2 * pause, LONGEST_PAUSE);
    };
    for (const [name, handle] of Object.entries(handlers))
      source.addEventListener(name, (event) => handle(JSON.parse((event as MessageEvent).data) as never));
  };
  connect();
  let opened = language.peek();
  const forget = language.subscribe((its) => {
    if (its === opened) return;
    opened = its;
    window.clearTimeout(timer);
    source?.close();
    connect();
  });
  return {
    close() {
      closed = true;
      forget();
      window.clearTimeout(timer);
      source?.close();
    },
  };
}
