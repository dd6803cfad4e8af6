import { t } from '../../i18n';
import { type IconName, Icon } from '../../widgets/icon';
import { importing } from './importing';
import type { TableState } from './table_state';

function Tool(props: { icon: IconName; name: string; disabled?: boolean; onClick: () => void }) {
  return (
    <button
      type="button"
      class="icon-button"
      title={props.name}
      aria-label={props.name}
      disabled={props.disabled}
      onClick={props.onClick}
    >
      <Icon name={props.icon} />
    </button>
  );
}

export function TableTools(props: { state: TableState; onAdd: () => void; onPaste: () => void }) {
  const { state } = props;
  const texts = t.value.project.table;
  const chosen = state.selectedRows().length;
  return (
    <div class="tools">
      <button type="button" class="button" disabled={state.locked} onClick={props.onAdd}>
        <Icon name="add" />
        {texts.add}
      </button>
      <Tool
        icon="copy"
        name={t.value.project.duplicate}
        disabled={state.locked || chosen === 0}
        onClick={state.duplicate}
      />
      <Tool
        icon="delete"
        name={t.value.project.remove}
        disabled={state.locked || chosen === 0}
        onClick={state.remove}
      />
      <Tool icon="fill" name={texts.fill} disabled={state.locked || chosen < 2} onClick={state.fillDown} />
      <Tool icon="paste" name={texts.paste} disabled={state.locked} onClick={props.onPaste} />
      {state.object !== 'bank' && (
        <button
          type="button"
          class="button quiet"
          disabled={state.locked}
          onClick={() => {
            importing.value = { text: '', path: state.path };
          }}
        >
          {t.value.project.import}
        </button>
      )}
      <span class="spring" />
      {chosen > 1 && <span class="muted small">{texts.selected(chosen)}</span>}
      <label class="check small">
        <input
          type="checkbox"
          checked={state.allColumns}
          onChange={(event) => state.setAllColumns(event.currentTarget.checked)}
        />
        {texts.allColumns}
      </label>
      {state.object !== 'bank' && (
        <input
          type="search"
          placeholder={texts.filter}
          aria-label={texts.filter}
          value={state.filter}
          onInput={(event) => state.setFilter(event.currentTarget.value)}
        />
      )}
      <span class="muted small count">{texts.count(state.order.length, state.list.length)}</span>
    </div>
  );
}
