// Headings are compared in folded form (folded()). Similar headings are found by the edit distance of module
// model over CP1251, so that a Cyrillic letter counts as one character.
#include "tables/headings.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tables/encoding.hpp"
#include "takt/base/utf8.hpp"
#include "takt/file/table.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/nearest.hpp"

namespace takt::file {
namespace {

struct Entry {
    std::string_view key;
    std::string_view english;
    std::string_view russian;
    std::string_view ukrainian;
    std::string_view others;  // separated by |
};

// clang-format off
constexpr Entry kEntries[] = {
    {"name", "Variable name", "Имя переменной", "Ім'я змінної",
     "Variable|Var|Tag|Tag name|Parameter|Имя|Переменная|Название|Название переменной|Наименование|"
     "Наименование переменной|Параметр|Ім'я|Змінна|Назва|Назва змінної|Найменування"},
    {"type", "Variable type", "Тип переменной", "Тип змінної", "Data type|Тип|Тип данных|Тип даних"},
    {"read", "Read function", "Функция чтения", "Функція читання",
     "Function|Function code|Reading function|Функция|Код функции|Функція|Код функції"},
    {"write", "Write function", "Функция записи", "Функція запису", "Writing function"},
    {"register", "Register address", "Адрес регистра", "Адреса регістра",
     "Address|Register number|Start address|Modbus address|Modbus register|Адрес|Регистр|Номер регистра|"
     "Адрес Modbus|Начальный адрес|Адреса|Регістр|Номер регістра|Адреса Modbus|Початкова адреса"},
    {"bit", "Bit address", "Адрес бита", "Адреса біта",
     "Bit number|Адрес бита (ов)|Бит|Номер бита|Біт|Номер біта"},
    {"area", "Area", "Область", "Область",
     "Memory area|Register area|Register type|Область памяти|Тип регистра|Область пам'яті|Тип регістра"},
    {"coil", "Coil address", "Адрес дискретного сигнала", "Адреса дискретного сигналу", "Coil number"},
    {"reference", "Modbus reference", "Обозначение 40001", "Позначення 40001",
     "Reference number|Reference (40001)|Обозначение (40001)|Позначення (40001)|Modicon address|"
     "Адрес Modicon|Адреса Modicon"},
    {"length", "String length", "Длина строки", "Довжина рядка", "Длина|Довжина"},
    {"write_on_change", "Write on change", "Запись по изменению", "Запис за зміною",
     "Запись при изменении|Запис при зміні"},
    {"read_trigger", "Read trigger", "Запуск чтения", "Запуск читання",
     "Start reading|Start-reading trigger|Триггер чтения|Чтение по триггеру|Тригер читання|"
     "Читання за тригером"},
    {"write_trigger", "Write trigger", "Запуск записи", "Запуск запису",
     "Start writing|Start-writing trigger|Триггер записи|Запись по триггеру|Тригер запису|Запис за тригером"},
    {"status", "Status", "Статус", "Статус", "Status variable|Переменная статуса|Змінна статусу"},
    {"min_interval", "Least interval", "Наименьший интервал", "Найменший інтервал",
     "Minimum interval|Минимальный интервал|Мінімальний інтервал"},
    {"burst", "Burst", "Серия", "Серія", ""},
    {"period", "Period", "Период", "Період",
     "Poll period|Polling period|Период опроса|Період опитування"},
    {"deadline", "Deadline", "Срок", "Строк", "Крайний срок|Крайній строк"},
    {"default", "Default value", "Значение по умолчанию", "Значення за замовчуванням",
     "Initial value|По умолчанию|Начальное значение|За замовчуванням|Початкове значення"},
    {"max_age", "Greatest age", "Предельный возраст", "Граничний вік", "Max age"},
    {"hold_last", "Hold last value", "Удержание последнего значения", "Утримання останнього значення", ""},
    {"retain", "Retain", "Энергонезависимость", "Енергонезалежність",
     "Retained|Retentive|Энергонезависимая|Сохранение|Енергонезалежна|Збереження"},
    {"used", "Used", "Используется", "Використовується",
     "Used in the project|Использование в проекте|Использование|Использовать|"
     "Використання у проекті|Використання в проєкті|Використання"},
    {"high_byte_first", "High byte first", "Старшим байтом вперёд", "Старшим байтом уперед", ""},
    {"high_register_first", "High register first", "Старшим регистром вперёд", "Старшим регістром уперед",
     "Старшим регістром вперед"},
    {"byte_order", "Byte order", "Порядок байт", "Порядок байтів", "Порядок байтов|Float"},
    {"scale", "Scale", "Множитель", "Множник",
     "Factor|Multiplier|Gain|Коэффициент|Масштаб|Коефіцієнт"},
    {"offset", "Offset", "Смещение", "Зміщення", "Сдвиг|Зсув"},
    {"dead_band", "Dead band", "Зона нечувствительности", "Зона нечутливості", "Мёртвая зона|Мертва зона"},
    {"write_range", "Write range", "Диапазон записи", "Діапазон запису", ""},
    {"verify", "Verify", "Проверка записи", "Перевірка запису", "Verify writes"},
    {"safe_to_repeat", "Safe to repeat", "Повтор безопасен", "Повтор безпечний", ""},
    {"unit", "Unit", "Единица измерения", "Одиниця вимірювання",
     "Units|Engineering unit|Unit of measurement|Единица|Единицы измерения|Ед. изм.|Одиниця|"
     "Одиниці вимірювання|Одиниця виміру|Од. вим."},
    {"enumeration", "Enumeration", "Перечисление", "Перелік", "Enum|States|Состояния|Стани"},
    {"bits", "Bit names", "Имена битов", "Імена бітів", ""},
    {"tags", "Tags", "Теги", "Теги", "Groups|Группы|Групи|Метки|Мітки"},
    {"comment", "Comment", "Комментарий", "Коментар",
     "Comments|Description|Remark|Note|Описание|Примечание|Опис|Примітка"},
    {kRegistersColumn, "Register count", "Количество регистров", "Кількість регістрів",
     "Number of registers|Count|Quantity|Число регистров|Количество|Кількість"},
    {"response_timeout", "Response timeout", "Таймаут ответа", "Таймаут відповіді", ""},
    {"attempts", "Attempts", "Кол-во попыток", "Спроби", "Кількість спроб"},
    {"poll_enable", "Polling", "Опрос", "Опитування", ""},
    {kProtocolColumn, "Protocol", "Протокол", "Протокол", ""},
    {"group_requests", "Group requests", "Группировать запросы", "Групувати запити", ""},
    {"registers_per_request", "Registers per request", "Кол-во регистров в запросе", "Регістрів у запиті",
     ""},
    {kLineColumn, "Line", "Линия", "Лінія", ""},
    {kTargetColumn, "Target", "Подключение", "Підключення", ""},
    {kDeviceColumn, "Device", "Устройство", "Пристрій",
     "Device name|Имя устройства|Прибор|Ім'я пристрою|Прилад"},
    {kUnitAddressColumn, "Unit address", "Адрес устройства", "Адреса пристрою",
     "Device address|Slave address|Slave ID|Unit ID|Slave|Адрес прибора|Адреса приладу"},
};
// clang-format on

struct TimeUnit {
    std::string_view name;
    std::string_view unit;
};
constexpr TimeUnit kTimeUnits[] = {
    {"ns", "ns"},   {"нс", "ns"},   {"us", "us"},  {"мкс", "us"},    {"ms", "ms"},     {"msec", "ms"},
    {"мс", "ms"},   {"мсек", "ms"}, {"s", "s"},    {"sec", "s"},     {"с", "s"},       {"сек", "s"},
    {"min", "min"}, {"мин", "min"}, {"хв", "min"}, {"h", "h"},       {"hour", "h"},    {"hours", "h"},
    {"ч", "h"},     {"час", "h"},   {"год", "h"},  {"минут", "min"}, {"seconds", "s"}, {"секунд", "s"},
};

char32_t small(char32_t c) {
    if (c >= U'A' && c <= U'Z') return c + 0x20;
    if (c >= 0x410 && c <= 0x42F) return c + 0x20;
    if (c >= 0x400 && c <= 0x40F) return c + 0x50;
    return c == U'Ґ' ? U'ґ' : c;
}

char32_t without_mark(char32_t c) {
    switch (c) {
        case U'ё': return U'е';
        case U'й': return U'и';
        case U'ї': return U'і';
        default: return c;
    }
}

bool counts(char32_t c) {
    return (c >= U'0' && c <= U'9') || (c >= U'a' && c <= U'z') || (c >= 0x430 && c <= 0x45F) || c == U'ґ';
}

const Entry* find_entry(std::string_view key) {
    const auto* const found = std::ranges::find(kEntries, key, &Entry::key);
    return found == std::end(kEntries) ? nullptr : found;
}

struct Named {
    std::string_view heading;
    std::string_view key;
};

// All known headings, by their folded text.
class Index {
public:
    Index() {
        for (const auto& field : model::fields(model::Object::variable)) add(field.key, field.key);
        for (const auto& entry : kEntries) {
            for (const auto heading : {entry.english, entry.russian, entry.ukrainian, entry.key})
                add(heading, entry.key);
            for (auto rest = entry.others; !rest.empty();) {
                const auto end = std::min(rest.find('|'), rest.size());
                add(rest.substr(0, end), entry.key);
                rest.remove_prefix(std::min(end + 1, rest.size()));
            }
        }
        for (const auto& [text, named] : by_text_) {
            letters_.push_back(to_cp1251(text).value_or(text));
            named_.push_back(named);
        }
        for (const auto& text : letters_) candidates_.push_back(text);
    }

    [[nodiscard]] const Named* find(const std::string& text) const {
        const auto found = by_text_.find(text);
        return found == by_text_.end() ? nullptr : &found->second;
    }

    // The key of all headings that begin with a text; empty if there is none, or more than one key.
    [[nodiscard]] std::string_view key_of_cut(const std::string& text) const {
        std::string_view key;
        for (auto at = by_text_.lower_bound(text); at != by_text_.end() && at->first.starts_with(text);
             ++at) {
            if (!key.empty() && key != at->second.key) return {};
            key = at->second.key;
        }
        return text.empty() ? std::string_view() : key;
    }

    [[nodiscard]] LikelyHeading nearest(const std::string& text) const {
        constexpr std::size_t kSurelyAMistake = 2;
        const auto letters = to_cp1251(text).value_or(text);  // one byte per letter
        const auto found = model::nearest(letters, candidates_);
        const auto at = static_cast<std::size_t>(std::ranges::find(candidates_, found) - candidates_.begin());
        return {named_[at].heading, named_[at].key,
                model::typing_distance(letters, found) <= kSurelyAMistake};
    }

private:
    void add(std::string_view heading, std::string_view key) {
        by_text_.try_emplace(folded(heading), Named{heading, key});
    }

    std::map<std::string, Named> by_text_;
    std::vector<std::string> letters_;
    std::vector<std::string_view> candidates_;
    std::vector<Named> named_;
};

const Index& index() {
    static const Index kIndex;
    return kIndex;
}

// `Период, мс`, `Address (hex)`: a heading followed by a unit or a base.
std::pair<std::string_view, std::string_view> split_suffix(std::string_view text) {
    const auto at = text.find_last_of(",([");
    if (at == std::string_view::npos || at == 0) return {text, {}};
    return {text.substr(0, at), text.substr(at + 1)};
}

}  // namespace

std::string folded(std::string_view text) {
    std::string result;
    result.reserve(text.size());
    for (std::size_t at = 0; at < text.size();) {
        const auto character = first_character(text.substr(at));
        at += std::max<std::size_t>(character.bytes, 1);
        const auto c = without_mark(small(character.code));
        if (character.bytes == 0 || !counts(c)) continue;
        result += encoded(c).view();
    }
    return result;
}

std::string_view time_unit(std::string_view text) {
    while (text.starts_with(' ')) text.remove_prefix(1);
    while (text.ends_with(' ') || text.ends_with('.')) text.remove_suffix(1);
    if (text == "µs" || text == "μs") return "us";
    const auto name = folded(text);
    const auto* const found = std::ranges::find(kTimeUnits, std::string_view(name), &TimeUnit::name);
    return found == std::end(kTimeUnits) ? std::string_view() : found->unit;
}

const model::Field* column_field(std::string_view key) {
    const bool setting = std::ranges::find(kDeviceSettings, key) != kDeviceSettings.end();
    return model::find_field(setting ? model::Object::device : model::Object::variable, key);
}

HeadingParts read_heading(std::string_view text) {
    const bool cut = text.ends_with("...") || text.ends_with("…");
    const auto cut_key = cut ? index().key_of_cut(folded(text)) : std::string_view();
    if (const auto* const named = index().find(folded(text)))
        return {.key = named->key, .ambiguous = cut && cut_key.empty()};
    if (!cut_key.empty()) return {.key = cut_key};
    const auto [front, behind] = split_suffix(text);
    const auto* const named = index().find(folded(front));
    if (named == nullptr) return {};
    const auto suffix = folded(behind);
    if (suffix == "hex" || suffix == "dec") return {.key = named->key, .hexadecimal = suffix == "hex"};
    const auto* const field = column_field(named->key);
    if (field == nullptr || field->kind != model::Kind::duration) return {};
    auto written = behind;
    while (written.ends_with(')') || written.ends_with(']') || written.ends_with(' '))
        written.remove_suffix(1);
    const auto unit = time_unit(written);
    if (unit.empty()) return {};
    return {.key = named->key, .unit = std::string(unit)};
}

HeadingParts read_field_name(std::string_view text) {
    constexpr std::size_t kLeast = std::size_t{2} * 4;  // four Cyrillic letters
    auto parts = read_heading(text);
    const auto name = folded(text);
    if (!parts.key.empty() || name.size() < kLeast) return parts;
    const auto key = index().key_of_cut(name);
    const bool setting = std::ranges::find(kDeviceSettings, key) != kDeviceSettings.end();
    return setting ? HeadingParts{.key = key} : parts;
}

LikelyHeading likely_heading(std::string_view text) {
    return index().nearest(folded(text));
}

std::string_view heading(std::string_view key, Headings headings) {
    const auto* const entry = find_entry(key);
    if (entry == nullptr) return key;
    switch (headings) {
        case Headings::keys: return key;
        case Headings::english: return entry->english;
        case Headings::russian: return entry->russian;
        case Headings::ukrainian: return entry->ukrainian;
        case Headings::ide:
            if (key == "bit") return "Адрес бита (ов)";
            if (key == "used") return "Использование в проекте";
            if (key == "high_byte_first") return "Старшим байтом вперед";
            if (key == "high_register_first") return "Старшим регистром вперед";
            return entry->russian;
    }
    return key;
}

bool has_headings(std::string_view key) {
    const auto* const entry = find_entry(key);
    return entry != nullptr && !entry->english.empty() && !entry->russian.empty() &&
           !entry->ukrainian.empty();
}

}  // namespace takt::file
