#include "options/shared_options.hpp"

#include <chrono>
#include <optional>
#include <utility>

#include "takt/line/target.hpp"
#include "takt/model/byte_order.hpp"
#include "takt/model/scalar.hpp"

namespace takt::app {

void reject_word(const std::string& option, const std::string& value, const std::string& allowed) {
    reject(word_error(option, value, allowed));
}

void check_target(const std::string& option, const std::string& url) {
    if (const auto target = line::parse_target(url); !target)
        reject(target_error(option, url, target.error()));
}

namespace {

struct TimeLimit {
    Duration time;
    const char* text;
};

constexpr TimeLimit kYear{std::chrono::hours(366 * 24), "8784h"};

/// `1,000ms` as `1000ms, 1.000ms`; empty: it is no duration with a comma.
std::string without_comma(const std::string& text) {
    const auto number = text.substr(0, text.find_first_not_of("0123456789,"));
    std::string meant;
    for (const auto& form : {model::without_thousands(number), model::with_point(number)})
        if (!form.empty() && model::parse_duration(form + text.substr(number.size())))
            meant.append(meant.empty() ? "" : ", ").append(form).append(text.substr(number.size()));
    return meant;
}

/// A number with a sign is out of range too.
Option add_time(Command& command, const std::string& name, TimeLimit least, TimeLimit greatest,
                std::function<void(Duration)> set, const std::string& help) {
    const auto read = [=, set = std::move(set)](const std::string& text) {
        const bool is_negative = text.starts_with('-') && model::parse_duration(text.substr(1));
        const auto time = model::parse_duration(text);
        const bool too_large = !time && time.error() == model::ScalarError::too_large;
        if (is_negative || too_large || (time && (*time < least.time || *time > greatest.time)))
            reject({"app.option.range",
                    {{"option", name}, {"value", text}, {"least", least.text}, {"greatest", greatest.text}}});
        if (!time) {
            const auto meant = without_comma(text);
            reject({meant.empty() ? "app.option.duration" : "app.option.duration.comma",
                    {{"option", name}, {"value", text}, {"meant", meant}}});
        }
        set(*time);
    };
    return command.text(name, read, help).value_name("TIME");
}

}  // namespace

Option add_duration(Command& command, const std::string& name, std::function<void(Duration)> set,
                    const std::string& help) {
    return add_time(command, name, {Duration::zero(), "0s"}, kYear, std::move(set), help);
}

Option add_wait(Command& command, const std::string& name, std::function<void(Duration)> set,
                const std::string& help) {
    return add_time(command, name, {std::chrono::milliseconds(1), "1ms"}, kYear, std::move(set), help);
}

namespace {

constexpr std::uint64_t kLeastFile = 10'000;
constexpr std::uint64_t kMostFile = 1'000'000'000'000;

/// "100M": a number, or one with k, M or G for a thousand, a million or a billion.
std::optional<std::uint64_t> parse_bytes(const std::string& text) {
    const auto digits = text.find_first_not_of("0123456789");
    if (digits == 0 || text.empty() || text.size() > 16) return std::nullopt;
    const auto unit = digits == std::string::npos ? "" : text.substr(digits);
    std::uint64_t factor = 1;
    if (unit == "k" || unit == "K")
        factor = 1000;
    else if (unit == "M")
        factor = 1'000'000;
    else if (unit == "G")
        factor = 1'000'000'000;
    else if (!unit.empty())
        return std::nullopt;
    const auto number = std::stoull(text);
    return number > kMostFile / factor ? kMostFile + 1 : number * factor;
}

}  // namespace

void add_capture_files(Command& command, console::CaptureFileOptions& options, const std::string& prefix,
                       const Option& needed) {
    const auto name = prefix + "size";
    command
        .text(
            name,
            [name, &options](const std::string& text) {
                const auto bytes = parse_bytes(text);
                if (!bytes || *bytes < kLeastFile || *bytes > kMostFile)
                    reject({"app.option.form.size", {{"option", name}, {"value", text}}});
                options.file_bytes = *bytes;
            },
            "help.capture.size")
        .needs(needed)
        .value_name("SIZE")
        .default_text("100M");
    command.value(prefix + "files", options.files, "help.capture.files")
        .needs(needed)
        .range(1, 1000)
        .value_name("N")
        .default_text("10");
}

void add_capture(Command& command, console::CaptureFileOptions& options) {
    const auto path = command.value("--capture", options.path, "help.capture.file").value_name("FILE.pcapng");
    add_capture_files(command, options, "--capture-", path);
}

void add_realtime(Command& command, RealtimeMode& mode) {
    command.flag_or_number("--realtime", kRealtimePriority, mode.priority, "help.realtime")
        .range(os::kLeastPriority, os::kMostPriority)
        .group("help.label.realtime");
    command.value("--cpu", mode.cpu, "help.realtime.cpu").range(0, 1023).group("help.label.realtime");
    add_time(
        command, "--spin", {Duration::zero(), "0s"}, {std::chrono::milliseconds(100), "100ms"},
        [&mode](Duration time) { mode.spin = time; }, "help.realtime.spin")
        .group("help.label.realtime");
}

const std::map<std::string, DataType>& type_words() {
    static const std::map<std::string, DataType> kTypes{
        {"int16", DataType::int16},   {"uint16", DataType::uint16},  {"int32", DataType::int32},
        {"uint32", DataType::uint32}, {"int64", DataType::int64},    {"uint64", DataType::uint64},
        {"float", DataType::float32}, {"double", DataType::float64}, {"string", DataType::string}};
    return kTypes;
}

void add_type(Command& command, DataType& type, std::vector<TypeFlag> flags, bool& given,
              const std::string& help) {
    command
        .text(
            "--type",
            [&type, flags = std::move(flags)](const std::string& text) {
                const auto found = type_words().find(text);
                if (found != type_words().end()) type = found->second;
                bool known = found != type_words().end();
                std::string words;
                for (const auto& [word, flag] : flags) {
                    *flag = text == word;
                    known = known || *flag;
                    words.append(word).append(", ");
                }
                if (known) return;
                for (const auto& word : type_words()) words += word.first + ", ";
                reject_word("--type", text, words.substr(0, words.size() - 2));
            },
            help)
        .value_name("TYPE")
        .marks(given);
}

ByteOrder order_of(const std::string& option, const std::string& text) {
    const auto permutation = model::parse_byte_order(text);
    if (!permutation) reject_word(option, text, "2143 (CDAB), 4321 (ABCD), 1234 (DCBA), 3412 (BADC)");
    return permutation->order;
}

void add_order(Command& command, ByteOrder& order) {
    command
        .text(
            "--order", [&order](const std::string& text) { order = order_of("--order", text); }, "help.order")
        .value_name("ORDER");
}

void add_client(Command& command, ClientOptions& options) {
    command.value("TARGET", options.target, "help.target").required().check([](const std::string& url) {
        check_target("TARGET", url);
    });
    command.value("--unit", options.unit, "help.unit").range(0, 255).default_text("1");
    add_timeout(command, options.timeout, "help.timeout");
    command.value("--attempts", options.attempts, "help.attempts").range(1, 255).show_default();
    command.flag("--json", options.json, "help.json");
    command.value("--traffic", options.traffic, "help.traffic").value_name("FILE");
}

}  // namespace takt::app
