#include "project/field_table.hpp"

#include <algorithm>
#include <expected>
#include <map>
#include <optional>

#include "takt/file/load.hpp"
#include "takt/file/schema.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/findings.hpp"
#include "takt/model/scalar.hpp"

namespace takt::web {
namespace {

using file::Json;
using model::Context;
using model::Field;
using model::Kind;
using model::Object;

/// Sets `value` to the word of the query parameter; without one it stays.
/// @returns the answer to an unknown word
template <class Words, class Enum>
std::optional<ApiResponse> take_word(const ApiRequest& request, std::string_view name, const Words& words,
                                     Enum& value) {
    const auto word = request.parameter(name);
    if (word.empty()) return std::nullopt;
    const auto found = std::ranges::find(words, word);
    if (found == words.end()) {
        std::string allowed;
        for (const auto each : words) allowed.append(allowed.empty() ? "" : ", ").append(each);
        return ApiResponse::wrong_parameter(request, name, std::move(allowed));
    }
    value = static_cast<Enum>(found - words.begin());
    return std::nullopt;
}

/// The context of the query. The framing follows the transport.
std::expected<Context, ApiResponse> context_of(const ApiRequest& request) {
    Context context;
    auto wrong = take_word(request, "profile", model::kProfiles, context.profile);
    if (!wrong) wrong = take_word(request, "transport", model::kTransports, context.transport);
    if (model::is_network(context.transport)) context.framing = wire::Framing::tcp;
    if (!wrong) wrong = take_word(request, "framing", model::kFramings, context.framing);
    if (wrong) return std::unexpected(*std::move(wrong));
    return context;
}

using Keys = std::map<std::string_view, std::string>;

std::string bool_word(bool flag) {
    return flag ? "true" : "false";
}

template <class Words, class Enum>
std::string word_of(const Words& words, Enum value) {
    return std::string(words[static_cast<std::size_t>(value)]);
}

/// The defaults of keys, read from a project that does not write them.
class Defaults {
public:
    explicit Defaults(const Context& context) {
        const bool network = model::is_network(context.transport);
        const auto text = "takt: 1\nprofile: " + word_of(model::kProfiles, context.profile) +
                          "\nlines: [{name: l, transport: " + word_of(model::kTransports, context.transport) +
                          ", framing: " + word_of(model::kFramings, context.framing) +
                          (network ? ", host: h" : ", port: p") +
                          ", devices: [{name: d, address: 1, variables: [{name: v, type: int16, register: 0, "
                          "read: 0x03}]}]}]\n";
        const auto checked = model::interpret(file::load_text("", text).document);
        if (checked.project.lines.empty()) return;
        const auto& line = checked.project.lines.front();
        take(checked.project);
        take(model::Output{});
        take(model::Instrument{});
        take(line);
        if (!line.devices.empty()) take(line.devices.front(), context);
    }

    [[nodiscard]] std::optional<std::string> find(Object object, std::string_view key) const {
        const auto texts = texts_.find(object);
        if (texts == texts_.end()) return std::nullopt;
        const auto found = texts->second.find(key);
        return found == texts->second.end() ? std::nullopt : std::optional(found->second);
    }

private:
    void take(const model::Project& project) {
        texts_[Object::project] = {{"profile", "generic"},
                                   {"derive_timeouts", bool_word(project.derive_timeouts)}};
    }

    void take(const model::Output& output) {
        const auto megabytes = [](std::uint64_t bytes) { return std::to_string(bytes >> 20U); };
        const model::OutputSelection selection;
        texts_[Object::output] = {
            {"version", word_of(model::kMqttVersions, output.mqtt.version)},
            {"keep_alive", model::to_text(output.mqtt.keep_alive)},
            {"in_flight", std::to_string(output.mqtt.in_flight)},
            {"backlog", word_of(model::kBacklogs, output.mqtt.backlog)},
            {"message", word_of(model::kMessageScopes, selection.message)},
            {"dead_band", "0"},
            {"bad_quality", word_of(model::kBadQuality, selection.policy.skip_bad)},
            {"command_expiry", model::to_text(output.command_expiry)},
            {"quota_mb", megabytes(output.journal.quota)},
            {"retention", model::to_text(output.journal.retention)},
            {"buffer_mb", megabytes(output.journal.buffer)},
        };
    }

    void take(const model::Instrument& instrument) {
        texts_[Object::instrument] = {
            {"every", model::to_text(instrument.every)},
            {"timeout", model::to_text(instrument.timeout)},
            {"start_retry", model::to_text(instrument.start_retry)},
            {"silent_after", std::to_string(instrument.silent_after)},
        };
        texts_[Object::instrument].merge(characters(instrument.format));
    }

    static Keys characters(const wire::CharacterFormat& format) {
        return {{"baud", std::to_string(format.baud)},
                {"parity", word_of(model::kParities, format.parity)},
                {"stop_bits", std::to_string(format.stop_bits)},
                {"data_bits", std::to_string(format.data_bits)}};
    }

    void take(const model::Line& line) {
        texts_[Object::line] = {
            {"transport", word_of(model::kTransports, line.transport)},
            {"tcp_port", std::to_string(line.tcp_port)},
            {"framing", word_of(model::kFramings, line.framing)},
            {"rs485", word_of(model::kRs485, line.rs485)},
            {"order", word_of(model::kOrders, line.order)},
            {"request_gap", model::to_text(line.request_gap)},
            {"frame_gap", model::to_text(line.frame_gap)},
            {"relay_interval", model::to_text(line.relay_interval)},
            {"command_interval", model::to_text(line.commands.min_interval)},
            {"command_burst", std::to_string(line.commands.burst)},
        };
        if (line.is_serial()) texts_[Object::line].merge(characters(line.format));
    }

    void take(const model::Device& device, const Context& context) {
        texts_[Object::device] = {
            {"poll_period", model::to_text(device.poll_period)},
            {"response_timeout", model::to_text(device.response_timeout)},
            {"round_trip", model::to_text(device.round_trip)},
            {"attempts", std::to_string(device.attempts)},
            {"in_flight", std::to_string(device.in_flight)},
            {"group_requests", bool_word(device.group_requests)},
            {"registers_per_request", std::to_string(device.registers_per_request)},
            {"strategy", word_of(model::kStrategies, model::device_defaults(context.profile).strategy)},
            {"gaps", word_of(model::kGaps, device.gaps)},
            {"fc22", bool_word(device.fc22)},
            {"fc23", bool_word(device.fc23)},
            {"read_modify_write", bool_word(device.read_modify_write)},
            {"high_byte_first", bool_word(device.order.high_byte_first)},
            {"high_register_first", bool_word(device.order.high_register_first)},
        };
    }

    std::map<Object, Keys> texts_;
};

Json words_json(const Field& field, const Context& context) {
    auto words = Json::array();
    for (std::size_t i = 0; i < field.words.size(); ++i)
        if (field.fits == nullptr || field.fits(i, context)) words.push_back(field.words[i]);
    return words;
}

Json field_json(Object object, const Field& field, const Context& context, const Defaults& defaults) {
    auto json = Json::object();
    json.set("kind", file::kind_name(field.kind));
    json.set("required", field.required);
    if (field.range != nullptr) {
        const auto range = field.range(context);
        json.set("least", range.least);
        json.set("greatest", range.greatest);
        if (range.tolerated != range.greatest) json.set("tolerated", range.tolerated);
    }
    if (field.kind == Kind::duration) json.set("unit", "ns");
    if (!field.words.empty()) json.set("words", words_json(field, context));
    if (const auto behind = file::object_behind(object, field.key))
        json.set("object", file::object_name(*behind));
    json.set("allowed", model::allowed(field, context));
    if (auto value = defaults.find(object, field.key)) json.set("default", *std::move(value));
    return json;
}

}  // namespace

ApiResponse field_table(const ApiRequest& request) {
    const auto context = context_of(request);
    if (!context) return context.error();
    const Defaults defaults(*context);
    Json::Object objects;
    for (const auto object : model::kObjects) {
        Json::Object keys;
        for (const auto& field : model::fields(object))
            keys.emplace_back(field.key, field_json(object, field, *context, defaults));
        objects.emplace_back(file::object_name(object), Json(std::move(keys)));
    }
    auto json = Json::object();
    json.set("objects", Json(std::move(objects)));
    return ApiResponse::json(json);
}

}  // namespace takt::web
