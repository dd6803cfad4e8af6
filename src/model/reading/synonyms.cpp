#include "takt/model/synonyms.hpp"

#include <algorithm>
#include <string>

#include "takt/base/ascii.hpp"
#include "takt/model/nearest.hpp"

namespace takt::model {
namespace {

struct Synonym {
    std::string_view word;
    std::string_view key;
    bool anywhere = false;  ///< means the key also in an object that lacks it
};

// A word may mean different keys in different objects; the first one that the object has counts.
constexpr Synonym kSynonyms[] = {
    {"slave", "address", true},
    {"slave_id", "address", true},
    {"slaveid", "address", true},
    {"slave_address", "address", true},
    {"unit", "address", true},
    {"unit_id", "address", true},
    {"id", "address"},
    {"station", "address"},
    {"node_id", "address", true},
    {"адрес", "address"},
    {"адреса", "address"},
    {"max", "limit"},
    {"maximum", "limit"},
    {"max_delay", "limit"},
    {"min", "first"},
    {"initial", "first"},
    {"speed", "baud", true},
    {"baudrate", "baud", true},
    {"baud_rate", "baud", true},
    {"bitrate", "baud", true},
    {"скорость", "baud", true},
    {"швидкість", "baud", true},
    {"ip", "host", true},
    {"ip_address", "host", true},
    {"hostname", "host", true},
    {"server", "host", true},
    {"port", "tcp_port", true},
    {"connect", "host", true},
    {"хост", "host", true},
    {"serial_port", "port", true},
    {"tty", "port", true},
    {"com", "port", true},
    {"device", "port"},
    {"порт", "port", true},
    {"interval", "poll_period"},
    {"interval", "period"},
    {"poll_interval", "poll_period"},
    {"scan_rate", "poll_period"},
    {"scan_interval", "period"},
    {"scan_interval", "poll_period"},
    {"poll", "poll_period"},
    {"период", "poll_period"},
    {"период", "period"},
    {"період", "poll_period"},
    {"період", "period"},
    {"retries", "attempts", true},
    {"retry", "attempts"},
    {"попытки", "attempts"},
    {"спроби", "attempts"},
    {"decimals", "scale"},
    {"fc", "read"},
    {"func", "read"},
    {"function", "read"},
    {"function_code", "read"},
    {"функция", "read"},
    {"функція", "read"},
    {"datatype", "type"},
    {"data_type", "type"},
    {"format", "type"},
    {"тип", "type"},
    {"addr", "register"},
    {"addr", "address"},
    {"address", "register"},
    {"reg", "register"},
    {"holding", "register"},
    {"holding_register", "register"},
    {"input_register", "register"},
    {"discrete_input", "coil"},
    {"discrete", "coil"},
    {"offset_address", "register"},
    {"регистр", "register"},
    {"регістр", "register"},
    {"tag", "name"},
    {"label", "name"},
    {"title", "name"},
    {"имя", "name"},
    {"название", "name"},
    {"назва", "name"},
    {"ім'я", "name"},
    {"multiplier", "scale"},
    {"factor", "scale"},
    {"gain", "scale"},
    {"коэффициент", "scale"},
    {"коефіцієнт", "scale"},
    {"bytesize", "data_bits", true},
    {"databits", "data_bits", true},
    {"stopbits", "stop_bits", true},
    {"protocol", "framing"},
    {"mode", "framing"},
    {"протокол", "framing"},
    {"endianness", "byte_order"},
    {"endian", "byte_order"},
    {"swap", "byte_order"},
    {"word_order", "byte_order"},
    {"word_swap", "byte_order"},
    {"byte_swap", "byte_order"},
    {"byteorder", "byte_order"},
    {"tags", "variables"},
    {"registers", "variables"},
    {"points", "variables"},
    {"переменные", "variables"},
    {"змінні", "variables"},
    {"slaves", "devices"},
    {"nodes", "devices"},
    {"устройства", "devices"},
    {"пристрої", "devices"},
    {"buses", "lines"},
    {"channels", "lines"},
    {"connections", "lines"},
    {"линии", "lines"},
    {"лінії", "lines"},
    {"max_registers", "registers_per_request"},
    {"server", "brokers"},
    {"url", "brokers"},
    {"uri", "brokers"},
    {"url", "host", true},
    {"uri", "host", true},
    {"host", "brokers"},
    {"host", "listen", true},
    {"ip", "listen"},
    {"bind", "listen", true},
    {"interface", "listen"},
    {"connect", "brokers"},
    {"start", "items", true},
    {"start", "register", true},
    {"start_address", "register", true},
    {"first", "items"},
    {"count", "items"},
    {"quantity", "items"},
    {"broker_url", "brokers"},
    {"брокер", "brokers"},
    {"username", "user"},
    {"login", "user"},
    {"пользователь", "user"},
    {"користувач", "user"},
    {"clientid", "client_id"},
    {"ca", "ca_file"},
    {"cafile", "ca_file"},
    {"cert", "certificate_file"},
    {"certfile", "certificate_file"},
    {"cert_file", "certificate_file"},
    {"keyfile", "key_file"},
    {"deadband", "dead_band"},
    {"hysteresis", "dead_band"},
    {"prefix", "topic"},
    {"тема", "topic"},
    {"max_size", "quota_mb"},
    {"quota", "quota_mb"},
    {"теги", "tags"},
    {"selection", "select"},
    {"history", "outputs"},
    {"mqtt", "outputs"},
    {"sqlite", "outputs"},
    {"database", "outputs"},
    {"range", "items"},
    {"limit", "limits"},
    {"object", "identification"},
    {"file", "files"},
    {"fifo", "fifos"},
    {"allow_restart", "restart"},
    {"allow_listen_only", "listen_only"},
};

struct ValueSynonym {
    std::string_view key;
    std::string_view value;
    std::string_view word;
};

constexpr ValueSynonym kValueSynonyms[] = {
    {"turnaround", "auto", "learn"},
    {"turnaround", "measure", "learn"},
    {"turnaround", "measured", "learn"},
    {"parity", "n", "none"},
    {"parity", "no", "none"},
    {"parity", "нет", "none"},
    {"parity", "немає", "none"},
    {"parity", "e", "even"},
    {"parity", "чет", "even"},
    {"parity", "чёт", "even"},
    {"parity", "парн", "even"},
    {"parity", "парна", "even"},
    {"parity", "o", "odd"},
    {"parity", "нечет", "odd"},
    {"parity", "нечёт", "odd"},
    {"parity", "непарна", "odd"},
    {"type", "boolean", "bool"},
    {"type", "bit", "bool"},
    {"type", "логический", "bool"},
    {"type", "логічний", "bool"},
    {"type", "s16", "int16"},
    {"type", "sint", "int16"},
    {"type", "int8", "int16"},
    {"type", "uint8", "uint16"},
    {"type", "i16", "int16"},
    {"type", "short", "int16"},
    {"type", "целое", "int16"},
    {"type", "целый", "int16"},
    {"type", "ціле", "int16"},
    {"type", "цілий", "int16"},
    {"type", "word", "uint16"},
    {"type", "uint", "uint16"},
    {"type", "u16", "uint16"},
    {"type", "ushort", "uint16"},
    {"type", "byte", "uint16"},
    {"type", "usint", "uint16"},
    {"type", "байт", "uint16"},
    {"type", "слово", "uint16"},
    {"type", "s32", "int32"},
    {"type", "i32", "int32"},
    {"type", "dint", "int32"},
    {"type", "long", "int32"},
    {"type", "dword", "uint32"},
    {"type", "udint", "uint32"},
    {"type", "u32", "uint32"},
    {"type", "ulong", "uint32"},
    {"type", "lint", "int64"},
    {"type", "i64", "int64"},
    {"type", "lword", "uint64"},
    {"type", "ulint", "uint64"},
    {"type", "u64", "uint64"},
    {"type", "float32", "float"},
    {"type", "f32", "float"},
    {"type", "single", "float"},
    {"type", "вещественный", "float"},
    {"type", "дійсний", "float"},
    {"type", "float64", "double"},
    {"type", "f64", "double"},
    {"type", "lreal", "double"},
    {"type", "text", "string"},
    {"type", "str", "string"},
    {"type", "строка", "string"},
    {"type", "рядок", "string"},
    {"area", "hr", "holding_register"},
    {"area", "holding", "holding_register"},
    {"area", "ir", "input_register"},
    {"area", "di", "discrete_input"},
    {"area", "discrete", "discrete_input"},
    {"area", "co", "coil"},
    {"area", "do", "coil"},
    {"transport", "rtu", "serial"},
    {"transport", "rs485", "serial"},
    {"transport", "rs-485", "serial"},
    {"transport", "rs232", "serial"},
    {"transport", "com", "serial"},
    {"transport", "ethernet", "tcp"},
    {"transport", "ip", "tcp"},
    {"transport", "modbus_tcp", "tcp"},
    {"transport", "mqtts", "mqtt"},
    {"transport", "mosquitto", "mqtt"},
    {"transport", "sqlite", "history"},
    {"transport", "database", "history"},
    {"transport", "db", "history"},
    {"transport", "archive", "history"},
    {"version", "5.0", "5"},
    {"version", "v5", "5"},
    {"version", "mqttv5", "5"},
    {"version", "4", "3.1.1"},
    {"version", "3", "3.1.1"},
    {"version", "311", "3.1.1"},
    {"bad_quality", "drop", "skip"},
    {"bad_quality", "ignore", "skip"},
    {"bad_quality", "send", "publish"},
    {"option", "duration", "for"},
    {"option", "time", "for"},
    {"option", "runtime", "for"},
    {"option", "seconds", "for"},
    {"option", "address", "unit"},
    {"option", "register", "START"},
    {"option", "read", "AREA"},
    {"option", "baud", "bauds"},
    {"option", "parity", "parities"},
    {"option", "delay", "fault"},
    {"option", "exception", "fault"},
    {"framing", "modbus_rtu", "rtu"},
    {"framing", "modbus_ascii", "ascii"},
    {"framing", "modbus_tcp", "tcp"},
};

std::string in_lower_case(std::string_view text) {
    std::string made(text);
    std::ranges::transform(made, made.begin(), takt::lower_case);
    return made;
}

}  // namespace

std::string_view synonym(Object object, std::string_view word) {
    constexpr std::size_t kLonger = 5;
    constexpr std::size_t kOneMistake = 2;  // of typing_distance()
    const std::string wanted = in_lower_case(word);
    for (const auto& [other, key, anywhere] : kSynonyms)
        if (other == wanted && find_field(object, key) != nullptr) return key;
    if (std::ranges::find(kSynonyms, wanted, &Synonym::word) != std::end(kSynonyms)) return {};
    for (const auto& [other, key, anywhere] : kSynonyms)
        if (other.size() >= kLonger && typing_distance(other, wanted) <= kOneMistake &&
            find_field(object, key) != nullptr)
            return key;
    return {};
}

std::string_view synonym_elsewhere(Object other, std::string_view word) {
    const std::string wanted = in_lower_case(word);
    for (const auto& [its, key, anywhere] : kSynonyms)
        if (anywhere && its == wanted && find_field(other, key) != nullptr) return key;
    return {};
}

std::string_view value_synonym(std::string_view key, std::span<const std::string_view> words,
                               std::string_view value) {
    const std::string wanted = in_lower_case(value);
    for (const auto& [of, other, word] : kValueSynonyms)
        if (of == key && other == wanted && std::ranges::find(words, word) != words.end()) return word;
    return {};
}

std::string_view meant_word(std::string_view key, std::span<const std::string_view> words,
                            std::string_view value) {
    if (const auto meant = value_synonym(key, words, value); !meant.empty() || value.empty()) return meant;
    const auto near = nearest(value, words);
    return is_unlike(value, near) ? std::string_view() : near;
}

}  // namespace takt::model
