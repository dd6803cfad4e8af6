import { render } from 'preact';
import { takeToken } from './api/client';
import { App } from './app';
import { language } from './i18n';
import { toastError } from './shell/toasts';
import { loadInfo } from './store/info';
import { startLive } from './store/live';
import { loadProject } from './store/project';
import './style/tokens.css';
import './style/base.css';
import './style/shell.css';
import './style/widgets.css';

takeToken();
document.documentElement.lang = language.peek();
render(<App />, document.getElementById('app')!);
startLive();
loadInfo().catch(toastError);
// A run without a project file (of a request table) has none to edit.
loadProject().catch(() => {});
