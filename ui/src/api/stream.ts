// Server-sent events that connect again by themselves, and report whether they are connected.
import { openUrl } from './client';

export interface Stream {
  close(): void;
}

const FIRST_PAUSE = 500;
const LONGEST_PAUSE = 8000;

/**
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
  return {
    close() {
      closed = true;
      window.clearTimeout(timer);
      source?.close();
    },
  };
}
