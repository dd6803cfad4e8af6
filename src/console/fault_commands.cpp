#include "takt/console/fault_commands.hpp"

#include <optional>
#include <string>
#include <utility>

#include "takt/base/ascii.hpp"
#include "takt/report/drawing/value_json.hpp"
#include "takt/text/escape.hpp"
#include "takt/value/text.hpp"

namespace takt::console {
namespace {

constexpr std::string_view kFaultUsage =
    "fault add [NAME:]FAULT, fault clear [NAME], fault list, set NAME VALUE, get NAME, quit";
constexpr std::string_view kFaultUsageWithoutNames = "fault add FAULT, fault clear, fault list, quit";
constexpr std::string_view kFaults =
    "silence, delay=50ms..2s, exception=1..255, bad_crc, wrong_unit, cut; :10% or @10s behind it";
constexpr std::string_view kVariableFaults =
    "silence, delay=50ms..2s, exception=1..255; the others with a device";

/// Takes the first word off `text`.
std::string_view take_fault_word(std::string_view& text) {
    text = trimmed(text, kCommandBlanks);
    const auto word = text.substr(0, text.find_first_of(" \t"));
    text = trimmed(text.substr(word.size()), kCommandBlanks);
    return word;
}

/// A name without the double quotes that may enclose it.
std::string unquoted(std::string_view text) {
    const bool quoted = text.size() >= 2 && text.starts_with('"') && text.ends_with('"');
    return std::string(quoted ? text.substr(1, text.size() - 2) : text);
}

std::string name_text(const std::string& name) {
    return name.find_first_of(" \t") == std::string::npos ? name : '"' + name + '"';
}

Answer in_force(const sim::AnswerFaults& faults) {
    std::string rules;
    for (const auto& rule : faults.rules())
        rules += ' ' + (rule.scope ? name_text(rule.scope->name) + ':' : std::string()) + sim::to_text(rule);
    return {.line = "ok" + text::escape_line(rules) + '\n', .json = {}};
}

class FaultCommands {
public:
    FaultCommands(std::shared_ptr<sim::AnswerFaults> faults, std::shared_ptr<ServedDevices> devices,
                  std::function<Instant()> now, std::function<void()> quit)
        : faults_(std::move(faults)),
          devices_(std::move(devices)),
          now_(std::move(now)),
          quit_(std::move(quit)) {}

    Result<void> execute(const std::string& line, const Reply& reply, const Texts& texts) const {
        std::string_view rest = line;
        const auto command = take_fault_word(rest);
        if (command == "fault") return fault(line, rest, reply);
        if (!devices_->empty() && (command == "set" || command == "get"))
            return value(command == "set", line, reply);
        if (command == "quit" && !rest.empty()) return wrong(line);
        if (command != "quit") {
            reply(unknown_command(texts, command, usage()));
            return {};
        }
        reply(quit_answer());
        quit_();
        return {};
    }

private:
    [[nodiscard]] Result<void> wrong(const std::string& line) const {
        return fail(Code::syntax, value::beside_allowed(line, usage()));
    }
    [[nodiscard]] std::string_view usage() const {
        return devices_->empty() ? kFaultUsageWithoutNames : kFaultUsage;
    }

    Result<void> fault(const std::string& line, std::string_view rest, const Reply& reply) const {
        const auto verb = take_fault_word(rest);
        if (verb == "add" && !rest.empty())
            TAKT_CHECK(add(rest));
        else if (verb == "clear" && (rest.empty() || !devices_->empty()))
            TAKT_CHECK(clear(rest));
        else if (verb != "list" || !rest.empty())
            return wrong(line);
        reply(in_force(*faults_));
        return {};
    }

    Result<void> clear(std::string_view name) const {
        if (name.empty())
            faults_->clear();
        else if (faults_->clear(unquoted(name)) == 0)
            return fail(Code::not_found, unquoted(name));
        return {};
    }

    // FAULT or NAME:FAULT. Both a name and a fault may contain colons.
    Result<void> add(std::string_view text) const {
        auto rule = sim::parse_fault(text);
        Error error = fail(Code::syntax, value::beside_allowed(text, kFaults)).error();
        for (auto colon = text.find(':'); !rule && colon != std::string_view::npos;
             colon = text.find(':', colon + 1)) {
            auto named = sim::parse_fault(trimmed(text.substr(colon + 1), kCommandBlanks));
            if (!named) continue;
            auto scope = devices_->scope_of(unquoted(trimmed(text.substr(0, colon), kCommandBlanks)));
            if (!scope) {
                error = scope.error();
                continue;
            }
            if (scope->items && sim::damages_frames(named->kind))
                return fail(Code::syntax, value::beside_allowed(text, kVariableFaults));
            named->scope = *std::move(scope);
            rule = std::move(named);
        }
        if (!rule) return std::unexpected(error);
        if (!faults_->add(now_(), *rule)) return fail(Code::queue_full, sim::AnswerFaults::kMost);
        return {};
    }

    Result<void> value(bool sets, const std::string& line, const Reply& reply) const {
        const auto command = parse_control(line);
        if (!command) return wrong(line);
        const auto& name = command->name;
        if (sets) TAKT_CHECK(devices_->set(now_(), name, command->value));
        TAKT_TRY(const auto read, devices_->get(now_(), name));
        const auto& variable = *read.variable;
        const auto shown = value::format(variable.type, variable.scaled(), read.value);
        auto object = file::Json::object();
        object.set("event", "answer");
        object.set("command", sets ? "set" : "get");
        object.set("name", name);
        object.set("type", takt::name(variable.type));
        object.set("value", report::to_json(variable.type, variable.scaled(), read.value));
        object.set("text", shown);
        object.set("quality", value::name(value::Quality::good));
        reply({.line = text::escape_line("ok " + name_text(name) + ' ' + shown) + '\n',
               .json = std::move(object)});
        return {};
    }

    std::shared_ptr<sim::AnswerFaults> faults_;
    std::shared_ptr<ServedDevices> devices_;
    std::function<Instant()> now_;
    std::function<void()> quit_;
};

}  // namespace

Execute fault_commands(std::shared_ptr<sim::AnswerFaults> faults, std::shared_ptr<ServedDevices> devices,
                       std::function<Instant()> now, std::function<void()> quit) {
    return [commands = FaultCommands(std::move(faults), std::move(devices), std::move(now), std::move(quit))](
               const std::string& line, const Reply& reply, const Texts& texts) {
        return commands.execute(line, reply, texts);
    };
}

}  // namespace takt::console
