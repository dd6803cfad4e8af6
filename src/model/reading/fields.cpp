#include "takt/model/fields.hpp"

#include <algorithm>
#include <iterator>

#include "reading/firmware_fields.hpp"
#include "reading/output_fields.hpp"
#include "reading/project_fields.hpp"
#include "reading/server_fields.hpp"
#include "reading/source_fields.hpp"
#include "takt/model/scalar.hpp"

namespace takt::model {
namespace {

struct ObjectFields {
    Object object;
    std::string_view location;
    std::span<const Field> fields;
};

constexpr ObjectFields kObjectFields[] = {
    {Object::project, "", kProject},
    {Object::line, "lines[]", kLine},
    {Object::device, "lines[].devices[]", kDevice},
    {Object::variable, "lines[].devices[].variables[]", kVariable},
    {Object::local, "locals[]", kLocal},
    {Object::host, "host", kHost},
    {Object::faults, "faults", kFaults},
    {Object::backoff, "backoff", kBackoff},
    {Object::round_trip, "round_trip", kRoundTrip},
    {Object::tls, "lines[].tls", kTls},
    {Object::areas, "lines[].devices[].readable", kByArea},
    {Object::server, "servers[]", kServer},
    {Object::unit, "servers[].units[]", kUnit},
    {Object::bank, "servers[].units[].banks[]", kBank},
    {Object::mirror, "servers[].units[].mirror", kMirror},
    {Object::limit, "servers[].units[].limits[]", kLimit},
    {Object::identification, "servers[].units[].identification[]", kIdentification},
    {Object::file, "servers[].units[].files[]", kFile},
    {Object::fifo, "servers[].units[].fifos[]", kFifo},
    {Object::access, "servers[].access[]", kAccess},
    {Object::relay, "servers[].relay[]", kRelay},
    {Object::relay_map, "servers[].relay[].map[]", kRelayMap},
    {Object::served_variable, "servers[].units[].variables[]", kServedVariable},
    {Object::source, "servers[].units[].variables[].source", kSource},
    {Object::sine, "servers[].units[].variables[].source.sine", kSine},
    {Object::ramp, "servers[].units[].variables[].source.ramp", kRamp},
    {Object::random_walk, "servers[].units[].variables[].source.random_walk", kRandomWalk},
    {Object::counter, "servers[].units[].variables[].source.counter", kCounter},
    {Object::replay, "servers[].units[].variables[].source.replay", kReplay},
    {Object::file_source, "servers[].units[].variables[].source.file", kFileSource},
    {Object::command_source, "servers[].units[].variables[].source.command", kCommandSource},
    {Object::command, "servers[].units[].variables[].writes_to.command", kCommand},
    {Object::sink, "servers[].units[].variables[].writes_to", kSink},
    {Object::instrument, "instruments[]", kInstrument},
    {Object::exchange, "instruments[].exchanges[]", kExchange},
    {Object::start_command, "instruments[].start[]", kStartCommand},
    {Object::instrument_command, "instruments[].commands[]", kInstrumentCommand},
    {Object::read_back, "instruments[].commands[].read_back", kReadBack},
    {Object::answer, "instruments[].exchanges[].answer", kAnswer},
    {Object::measurement, "instruments[].exchanges[].answer.fields[]", kMeasurement},
    {Object::output, "outputs[]", kOutput},
    {Object::output_selection, "outputs[].select[]", kOutputSelection},
    {Object::firmware, "", kFirmware},
};

constexpr const ObjectFields& of(Object object) {
    return kObjectFields[static_cast<std::size_t>(object)];
}

static_assert(std::size(kObjectFields) == kObjects.size() + 1);
static_assert(std::ranges::all_of(kObjects, [](Object object) { return of(object).object == object; }));

std::string bound_text(const Field& field, std::int64_t bound) {
    return field.kind == Kind::duration ? to_text(Duration(bound)) : std::to_string(bound);
}

}  // namespace

std::span<const Field> fields(Object object) {
    return of(object).fields;
}

std::string_view location(Object object) {
    return of(object).location;
}

const Field* find_field(Object object, std::string_view key) {
    for (const auto& field : fields(object))
        if (field.key == key) return &field;
    return nullptr;
}

std::string keys_of(Object object) {
    std::string keys;
    for (const auto& field : fields(object)) keys.append(keys.empty() ? "" : ", ").append(field.key);
    return keys;
}

std::string allowed(const Field& field, const Context& context) {
    if (field.kind == Kind::mapping && field.object) return keys_of(*field.object);
    if (field.kind == Kind::boolean) return "true, false";
    if (field.kind == Kind::text) return {};
    if (field.range != nullptr) {
        const auto [least, greatest, tolerated] = field.range(context);
        if (least == greatest) return bound_text(field, least);
        // Reserved addresses are tolerated, not allowed. Registers that are cut are allowed.
        const bool reserved = field.key == "address";
        auto text = bound_text(field, least) + ".." +
                    bound_text(field, reserved ? greatest : std::max(greatest, tolerated));
        for (const auto word : field.words) text.append(", ").append(word);
        return text;
    }
    std::string words;
    for (std::size_t i = 0; i < field.words.size(); ++i) {
        if (field.fits != nullptr && !field.fits(i, context)) continue;
        if (!words.empty()) words += ", ";
        words += field.words[i];
    }
    return words;
}

}  // namespace takt::model
