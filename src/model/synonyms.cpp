#include "takt/model/synonyms.hpp"

#include <algorithm>
#include <string>

namespace takt::model {
namespace {

struct Synonym {
    std::string_view word;
    std::string_view key;
};

// A word may mean different keys in different objects; the first one that the object has counts.
constexpr Synonym kSynonyms[] = {
    {"slave", "address"},
    {"slave_id", "address"},
    {"slaveid", "address"},
    {"slave_address", "address"},
    {"unit", "address"},
    {"unit_id", "address"},
    {"id", "address"},
    {"station", "address"},
    {"node_id", "address"},
    {"адрес", "address"},
    {"адреса", "address"},
    {"speed", "baud"},
    {"baudrate", "baud"},
    {"baud_rate", "baud"},
    {"bitrate", "baud"},
    {"скорость", "baud"},
    {"швидкість", "baud"},
    {"ip", "host"},
    {"ip_address", "host"},
    {"hostname", "host"},
    {"server", "host"},
    {"хост", "host"},
    {"serial_port", "port"},
    {"tty", "port"},
    {"com", "port"},
    {"device", "port"},
    {"порт", "port"},
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
    {"retries", "attempts"},
    {"retry", "attempts"},
    {"попытки", "attempts"},
    {"спроби", "attempts"},
    {"fc", "read"},
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
    {"bytesize", "data_bits"},
    {"databits", "data_bits"},
    {"stopbits", "stop_bits"},
    {"protocol", "framing"},
    {"mode", "framing"},
    {"протокол", "framing"},
    {"endianness", "byte_order"},
    {"endian", "byte_order"},
    {"swap", "byte_order"},
    {"word_order", "byte_order"},
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
};

std::string lower(std::string_view text) {
    std::string made(text);
    std::ranges::transform(made, made.begin(), [](char c) {
        return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    return made;
}

}  // namespace

std::string_view synonym(Object object, std::string_view word) {
    const std::string wanted = lower(word);
    for (const auto& [other, key] : kSynonyms)
        if (other == wanted && find_field(object, key) != nullptr) return key;
    return {};
}

}  // namespace takt::model
