// Requests to the program. Every failure is an ApiError with a text for people.
import { language } from '../i18n';

export class ApiError extends Error {
  constructor(
    readonly status: number,
    readonly code: string,
    text: string,
    readonly body: unknown = null,
  ) {
    super(text);
  }
}

const TOKEN_KEY = 'takt.token';

/** The token of the address bar moves to the session's memory, so that it is not in copied links. */
export function takeToken(): void {
  const url = new URL(location.href);
  const token = url.searchParams.get('token');
  if (!token) return;
  sessionStorage.setItem(TOKEN_KEY, token);
  url.searchParams.delete('token');
  history.replaceState(null, '', url);
}

type Query = Record<string, string | number | string[] | undefined>;

/** A list is repeated: one parameter for each of its texts. */
export function apiUrl(path: string, query: Query = {}): string {
  const url = new URL(`api/v1/${path}`, document.baseURI);
  url.searchParams.set('lang', language.value);
  for (const [key, value] of Object.entries(query))
    if (Array.isArray(value)) for (const one of value) url.searchParams.append(key, one);
    else if (value !== undefined) url.searchParams.set(key, String(value));
  return url.toString();
}

/** For addresses that the browser opens by itself: streams and downloads. */
export function openUrl(path: string, query: Query = {}): string {
  const token = sessionStorage.getItem(TOKEN_KEY);
  return apiUrl(path, token ? { ...query, token } : query);
}

async function request(method: string, url: string, body?: unknown, signal?: AbortSignal): Promise<Response> {
  const headers: Record<string, string> = { Accept: 'application/json' };
  const token = sessionStorage.getItem(TOKEN_KEY);
  if (token) headers.Authorization = `Bearer ${token}`;
  const init: RequestInit = { method, headers };
  if (signal) init.signal = signal;
  if (body !== undefined) {
    headers['Content-Type'] = 'application/json';
    headers['X-Takt'] = '1';
    init.body = JSON.stringify(body);
  }
  try {
    return await fetch(url, init);
  } catch (failure) {
    if (failure instanceof DOMException && failure.name === 'AbortError') throw failure;
    throw new ApiError(0, 'unreachable', '');
  }
}

async function call<T>(method: string, url: string, body?: unknown, signal?: AbortSignal): Promise<T> {
  const response = await request(method, url, body, signal);
  const text = await response.text();
  let answer: unknown = null;
  try {
    answer = text ? JSON.parse(text) : null;
  } catch {
    throw new ApiError(response.status, 'malformed', text.slice(0, 200));
  }
  if (!response.ok) {
    const error = (answer as { error?: { code: string; text: string } } | null)?.error;
    throw new ApiError(response.status, error?.code ?? 'http', error?.text ?? response.statusText, answer);
  }
  return answer as T;
}

export const get = <T>(path: string, query: Query = {}, signal?: AbortSignal) =>
  call<T>('GET', apiUrl(path, query), undefined, signal);
export const post = <T>(path: string, body: unknown, signal?: AbortSignal, query = {}) =>
  call<T>('POST', apiUrl(path, query), body, signal);
export const put = <T>(path: string, body: unknown) => call<T>('PUT', apiUrl(path), body);

/** Saves the answer under the name that the program gives it. */
export async function download(path: string, body: unknown, query: Query): Promise<void> {
  const response = await request('POST', apiUrl(path, query), body);
  if (!response.ok) throw new ApiError(response.status, 'http', response.statusText);
  const link = document.createElement('a');
  link.download = /filename="?([^";]+)/.exec(response.headers.get('Content-Disposition') ?? '')?.[1] ?? '';
  link.href = URL.createObjectURL(await response.blob());
  link.click();
  URL.revokeObjectURL(link.href);
}
