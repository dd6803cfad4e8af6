#include "takt/publish/command_request.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>
#include <variant>

#include "takt/base/iso_time.hpp"
#include "takt/base/utf8.hpp"

namespace takt::publish {
namespace {

using file::Json;

constexpr std::string_view kKeys = "id, command, variable, device, value, sent, expires, expiry_s";
constexpr std::array kVerbs{CommandVerb::set, CommandVerb::write,  CommandVerb::trigger,
                            CommandVerb::get, CommandVerb::enable, CommandVerb::disable};

bool concerns_device(CommandVerb verb) {
    return verb == CommandVerb::enable || verb == CommandVerb::disable;
}

bool has_value(CommandVerb verb) {
    return verb == CommandVerb::set || verb == CommandVerb::write;
}

std::string shown(const Json& value) {
    const std::string text = value.dump();
    const auto front = whole_characters(text, 60);
    return front.size() == text.size() ? text : std::string(front) + "…";
}

bool is_id(std::string_view text) {
    return !text.empty() && text.size() <= CommandRequest::kLongestId &&
           std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
}

/// Reads the keys of a request; the first fault is kept.
class Reader {
public:
    explicit Reader(const Json& json) : json_(json) {}

    ParsedCommand read() && {
        if (!std::holds_alternative<Json::Object>(json_.value()))
            return {{}, CommandRefused{.detail = "no object: " + shown(json_)}};
        read_id();
        read_verb();
        read_subject();
        read_value();
        request_.sent_ns = time("sent");
        request_.expires_ns = time("expires");
        read_expiry();
        check_keys();
        return {std::move(request_), std::move(refused_)};
    }

private:
    void fault(std::string detail) {
        if (!refused_) refused_ = CommandRefused{.detail = std::move(detail)};
    }
    void missing(std::string_view key) { fault(std::string(key) + ": missing"); }
    void wrong(std::string_view key, const Json& value, std::string_view allowed) {
        fault(std::string(key) + ": " + shown(value) + "; allowed: " + std::string(allowed));
    }
    void superfluous(std::string_view key) {
        if (json_.find(key) != nullptr)
            fault(std::string(key) + ": not a key of " + std::string(name(request_.verb)));
    }
    const std::string* text(std::string_view key) {
        const Json* const found = json_.find(key);
        return found == nullptr ? nullptr : std::get_if<std::string>(&found->value());
    }

    void read_id() {
        const Json* const found = json_.find("id");
        if (found == nullptr) return missing("id");
        const auto* const id = text("id");
        if (id == nullptr || !is_id(*id)) return wrong("id", *found, "1 to 64 printable ASCII characters");
        request_.id = *id;
    }

    void read_verb() {
        const Json* const found = json_.find("command");
        if (found == nullptr) return missing("command");
        const auto* const word = text("command");
        const auto* const verb =
            std::ranges::find_if(kVerbs, [&](CommandVerb v) { return word != nullptr && *word == name(v); });
        if (verb == kVerbs.end())
            return wrong("command", *found, "set, write, trigger, get, enable, disable");
        request_.verb = *verb;
        known_verb_ = true;
    }

    void read_subject() {
        if (!known_verb_) return;
        const bool device = concerns_device(request_.verb);
        superfluous(device ? "variable" : "device");
        const std::string_view key = device ? "device" : "variable";
        const Json* const found = json_.find(key);
        if (found == nullptr) return missing(key);
        const auto* const subject = text(key);
        if (subject == nullptr || subject->empty() || subject->size() > CommandRequest::kLongestName)
            return wrong(key, *found, "a name of at most 256 bytes");
        request_.subject = *subject;
    }

    void read_value() {
        if (!known_verb_) return;
        if (!has_value(request_.verb)) return superfluous("value");
        const Json* const found = json_.find("value");
        if (found == nullptr) return missing("value");
        const auto& value = found->value();
        if (found->is_null() || std::holds_alternative<Json::Array>(value) ||
            std::holds_alternative<Json::Object>(value))
            return wrong("value", *found, "true, false, a number or a string");
        const auto* const string = std::get_if<std::string>(&value);
        if (string != nullptr && string->size() > CommandRequest::kLongestValue)
            return wrong("value", *found, "a string of at most 1024 bytes");
        request_.form =
            string != nullptr ? CommandRequest::ValueForm::string : CommandRequest::ValueForm::other;
        request_.value = string != nullptr ? *string : found->dump();
    }

    std::optional<std::int64_t> time(std::string_view key) {
        const Json* const found = json_.find(key);
        if (found == nullptr) return std::nullopt;
        const auto* const string = text(key);
        const auto parsed = string == nullptr ? std::nullopt : read_utc_time(*string);
        if (!parsed) wrong(key, *found, "a time like 2026-11-24T02:30:00Z");
        return parsed;
    }

    void read_expiry() {
        const Json* const found = json_.find("expiry_s");
        if (found == nullptr) return;
        const double seconds = std::visit(
            [](const auto& value) {
                using T = std::decay_t<decltype(value)>;
                if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>)
                    return static_cast<double>(value);
                else
                    return 0.0;
            },
            found->value());
        const double most = std::chrono::duration<double>(CommandRequest::kLongestExpiry).count();
        if (!(seconds > 0 && seconds <= most)) return wrong("expiry_s", *found, "above 0, up to 86400");
        request_.expiry = std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds));
    }

    void check_keys() {
        for (const auto& [key, value] : std::get<Json::Object>(json_.value())) {
            const auto word = key.find_first_of(", ") == std::string::npos ? key : std::string();
            const auto at = (", " + std::string(kKeys) + ",").find(", " + word + ",");
            if (word.empty() || at == std::string::npos)
                return fault("key " + shown(Json(key)) + " is unknown; allowed: " + std::string(kKeys));
        }
    }

    const Json& json_;
    CommandRequest request_;
    bool known_verb_ = false;
    std::optional<CommandRefused> refused_;
};

}  // namespace

std::string_view name(CommandVerb verb) {
    switch (verb) {
        case CommandVerb::set: return "set";
        case CommandVerb::write: return "write";
        case CommandVerb::trigger: return "trigger";
        case CommandVerb::get: return "get";
        case CommandVerb::enable: return "enable";
        case CommandVerb::disable: return "disable";
    }
    return "";
}

std::string_view name(CommandRefusal refusal) {
    switch (refusal) {
        case CommandRefusal::retained: return "retained";
        case CommandRefusal::not_subscribed: return "not_subscribed";
        case CommandRefusal::expired: return "expired";
        case CommandRefusal::clock: return "clock";
        case CommandRefusal::not_listed: return "not_listed";
        case CommandRefusal::unknown_variable: return "unknown_variable";
        case CommandRefusal::malformed: return "malformed";
        case CommandRefusal::too_many: return "too_many";
        case CommandRefusal::duplicate_id: return "duplicate_id";
        case CommandRefusal::no_poll_enable: return "no_poll_enable";
    }
    return "";
}

ParsedCommand parse_command(std::string_view payload) {
    const auto json = Json::parse(payload, CommandRequest::kMostBytes);
    if (json) return Reader(*json).read();
    if (json.error().code == Code::too_long)
        return {{},
                CommandRefused{.detail = std::to_string(payload.size()) +
                                         " bytes; allowed: " + std::to_string(CommandRequest::kMostBytes)}};
    return {{}, CommandRefused{.detail = "no JSON: " + std::string(json.error().subject.view())}};
}

ParsedCommand plain_set(std::string id, std::string_view variable, std::string_view payload) {
    ParsedCommand parsed;
    parsed.request.id = std::move(id);
    parsed.request.verb = CommandVerb::set;
    if (variable.empty() || variable.size() > CommandRequest::kLongestName) {
        parsed.refused = CommandRefused{.detail = "variable: allowed is a name of at most 256 bytes"};
        return parsed;
    }
    parsed.request.subject = variable;
    if (payload.empty() || payload.size() > CommandRequest::kLongestValue)
        parsed.refused =
            CommandRefused{.detail = "value: " + std::to_string(payload.size()) + " bytes; allowed: 1 to " +
                                     std::to_string(CommandRequest::kLongestValue)};
    else
        parsed.request.value = payload;
    return parsed;
}

}  // namespace takt::publish
