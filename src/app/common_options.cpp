#include "common_options.hpp"

#include <cstdlib>

namespace takt::app {

CLI::Option* add_duration(CLI::App& command, const std::string& name, std::function<void(Duration)> set,
                          const std::string& help) {
    static const std::map<std::string, std::int64_t> kUnits{{"us", 1'000},
                                                            {"ms", 1'000'000},
                                                            {"s", 1'000'000'000},
                                                            {"min", 60'000'000'000},
                                                            {"h", 3'600'000'000'000}};
    return command.add_option_function<std::string>(
        name,
        [set = std::move(set), name](const std::string& text) {
            const auto digits = text.find_first_not_of("0123456789.");
            const auto unit = kUnits.find(digits == std::string::npos ? "" : text.substr(digits));
            char* end = nullptr;
            const double number = std::strtod(text.c_str(), &end);
            constexpr double kLongest = 366.0 * 24 * 3600 * 1e9;
            if (unit == kUnits.end() || end != text.c_str() + digits || digits == 0 ||
                number * static_cast<double>(unit->second) > kLongest)
                throw CLI::ValidationError(
                    name,
                    "'" + text + "' is no duration: a number with its unit, as in 500ms, 10s, 2min, 1h");
            set(Duration(static_cast<std::int64_t>(number * static_cast<double>(unit->second))));
        },
        help);
}

void add_type(CLI::App& command, DataType& type, bool& given) {
    static const std::map<std::string, DataType> kTypes{
        {"int16", DataType::int16},   {"uint16", DataType::uint16},  {"int32", DataType::int32},
        {"uint32", DataType::uint32}, {"int64", DataType::int64},    {"uint64", DataType::uint64},
        {"float", DataType::float32}, {"double", DataType::float64}, {"string", DataType::string}};
    add_word(command, "--type", type, kTypes, "help.type")
        ->type_name("TYPE")
        ->each([&given](const std::string&) { given = true; });
}

void add_order(CLI::App& command, ByteOrder& order) {
    static const std::map<std::string, std::pair<bool, bool>> kOrders{
        {"2143", {true, false}}, {"4321", {true, true}}, {"1234", {false, false}}, {"3412", {false, true}}};
    command
        .add_option_function<std::string>(
            "--order",
            [&order](const std::string& text) {
                const auto found = kOrders.find(text);
                if (found == kOrders.end())
                    throw CLI::ValidationError("--order", "'" + text + "' is not 2143, 4321, 1234 or 3412");
                order = {found->second.first, found->second.second};
            },
            "help.order")
        ->type_name("ORDER");
}

void add_client(CLI::App& command, ClientOptions& options) {
    command.add_option("target", options.target, "help.target")->required()->type_name("TARGET");
    command.add_option("--unit", options.unit, "help.unit")->check(CLI::Range(0, 255))->default_str("1");
    add_timeout(command, options.timeout, "help.timeout");
    command.add_option("--attempts", options.attempts, "help.attempts")
        ->check(CLI::Range(1, 255))
        ->capture_default_str();
    command.add_flag("--json", options.json, "help.json");
    command.add_option("--traffic", options.traffic, "help.traffic")->type_name("FILE");
}

}  // namespace takt::app
