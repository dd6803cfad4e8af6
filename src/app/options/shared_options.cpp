#include "options/shared_options.hpp"

#include <chrono>
#include <cstdlib>

namespace takt::app {

void reject_word(const std::string& option, const std::string& value, const std::string& allowed) {
    reject({"app.option.word", {{"option", option}, {"value", value}, {"allowed", allowed}}});
}

Option add_duration(Command& command, const std::string& name, std::function<void(Duration)> set,
                    const std::string& help) {
    static const std::map<std::string, std::int64_t> kUnits{{"us", 1'000},
                                                            {"ms", 1'000'000},
                                                            {"s", 1'000'000'000},
                                                            {"min", 60'000'000'000},
                                                            {"h", 3'600'000'000'000}};
    return command
        .text(
            name,
            [set = std::move(set), name](const std::string& text) {
                const auto digits = text.find_first_not_of("0123456789.");
                const auto unit = kUnits.find(digits == std::string::npos ? "" : text.substr(digits));
                char* end = nullptr;
                const double number = std::strtod(text.c_str(), &end);
                constexpr double kLongest = 366.0 * 24 * 3600 * 1e9;
                if (unit == kUnits.end() || end != text.c_str() + digits || digits == 0 ||
                    number * static_cast<double>(unit->second) > kLongest)
                    reject({"app.option.duration", {{"option", name}, {"value", text}}});
                set(Duration(static_cast<std::int64_t>(number * static_cast<double>(unit->second))));
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
    static const std::map<std::string, std::pair<bool, bool>> kOrders{
        {"2143", {true, false}}, {"4321", {true, true}}, {"1234", {false, false}}, {"3412", {false, true}}};
    command
        .text(
            "--order",
            [&order](const std::string& text) {
                const auto found = kOrders.find(text);
                if (found == kOrders.end()) reject_word("--order", text, "2143, 4321, 1234, 3412");
                order = {found->second.first, found->second.second};
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
