#include "options/shared_options.hpp"

#include <chrono>

#include "takt/model/byte_order.hpp"
#include "takt/model/scalar.hpp"

namespace takt::app {

void reject_word(const std::string& option, const std::string& value, const std::string& allowed) {
    reject({"app.option.word", {{"option", option}, {"value", value}, {"allowed", allowed}}});
}

Option add_duration(Command& command, const std::string& name, std::function<void(Duration)> set,
                    const std::string& help) {
    static constexpr Duration kLongest = std::chrono::hours(366 * 24);
    return command
        .text(
            name,
            [set = std::move(set), name](const std::string& text) {
                const auto time = model::parse_duration(text);
                if (!time || *time > kLongest)
                    reject({"app.option.duration", {{"option", name}, {"value", text}}});
                set(*time);
            },
            help)
        .value_name("TIME");
}

Option add_wait(Command& command, const std::string& name, std::function<void(Duration)> set,
                const std::string& help) {
    return add_duration(
        command, name,
        [set = std::move(set), name](Duration time) {
            if (time < std::chrono::milliseconds(1))
                reject({"app.option.least", {{"option", name}, {"least", "1ms"}}});
            set(time);
        },
        help);
}

void add_type(Command& command, DataType& type, bool& given) {
    static const std::map<std::string, DataType> kTypes{
        {"int16", DataType::int16},   {"uint16", DataType::uint16},  {"int32", DataType::int32},
        {"uint32", DataType::uint32}, {"int64", DataType::int64},    {"uint64", DataType::uint64},
        {"float", DataType::float32}, {"double", DataType::float64}, {"string", DataType::string}};
    add_word(command, "--type", type, kTypes, "help.type").value_name("TYPE").marks(given);
}

void add_order(Command& command, ByteOrder& order) {
    command
        .text(
            "--order",
            [&order](const std::string& text) {
                const auto permutation = model::parse_byte_order(text);
                if (!permutation)
                    reject_word("--order", text, "2143 (CDAB), 4321 (ABCD), 1234 (DCBA), 3412 (BADC)");
                order = permutation->order;
            },
            "help.order")
        .value_name("ORDER");
}

void add_client(Command& command, ClientOptions& options) {
    command.value("TARGET", options.target, "help.target").required();
    command.value("--unit", options.unit, "help.unit").range(0, 255).default_text("1");
    add_timeout(command, options.timeout, "help.timeout");
    command.value("--attempts", options.attempts, "help.attempts").range(1, 255).show_default();
    command.flag("--json", options.json, "help.json");
    command.value("--traffic", options.traffic, "help.traffic").value_name("FILE");
}

}  // namespace takt::app
