#include "takt/file/schema.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>

#include "takt/model/scalar.hpp"

namespace takt::file {
namespace {

using model::Field;
using model::Kind;
using model::Object;

constexpr std::array<std::string_view, model::kObjects.size()> kNames{"project",
                                                                      "line",
                                                                      "device",
                                                                      "variable",
                                                                      "local",
                                                                      "host",
                                                                      "faults",
                                                                      "backoff",
                                                                      "round_trip",
                                                                      "tls",
                                                                      "areas",
                                                                      "server",
                                                                      "unit",
                                                                      "bank",
                                                                      "mirror",
                                                                      "limit",
                                                                      "identification",
                                                                      "file",
                                                                      "fifo",
                                                                      "access",
                                                                      "relay",
                                                                      "relay_map",
                                                                      "served_variable",
                                                                      "source",
                                                                      "sine",
                                                                      "ramp",
                                                                      "random_walk",
                                                                      "counter",
                                                                      "replay",
                                                                      "file_source",
                                                                      "command_source",
                                                                      "command",
                                                                      "sink",
                                                                      "instrument",
                                                                      "exchange",
                                                                      "start_command",
                                                                      "instrument_command",
                                                                      "read_back",
                                                                      "answer",
                                                                      "measurement",
                                                                      "output",
                                                                      "output_selection"};

constexpr std::array<std::string_view, 14> kKinds{
    "integer",    "duration",      "boolean",  "number",    "text", "word",    "function",
    "local_bool", "local_integer", "constant", "reference", "list", "mapping", "words"};

constexpr auto kContexts = [] {
    std::array<model::Context, 24> all{};
    std::size_t i = 0;
    for (const auto profile : {model::Profile::generic, model::Profile::owen_kc1})
        for (const auto transport : {model::Transport::serial, model::Transport::tcp, model::Transport::tls,
                                     model::Transport::simulated})
            for (const auto framing : {wire::Framing::rtu, wire::Framing::ascii, wire::Framing::tcp})
                all[i++] = {profile, transport, framing};
    return all;
}();

/// All that is in range, or tolerated, in one of the contexts.
model::Range widest(const Field& field) {
    model::Range all{std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()};
    for (const auto& context : kContexts) {
        const auto range = field.range(context);
        all.least = std::min(all.least, field.zero_means != nullptr ? 0 : range.least);
        all.greatest = std::max({all.greatest, range.greatest, range.tolerated});
    }
    return all;
}

Json json_object(std::initializer_list<std::pair<std::string, Json>> entries) {
    return Json(Json::Object(entries));
}

Json json_array(std::initializer_list<Json> items) {
    return Json(Json::Array(items));
}

Json type_of(std::string_view name) {
    return json_object({{"type", name}});
}

Json reference_to(Object object) {
    return json_object({{"$ref", "#/$defs/" + std::string(object_name(object))}});
}

/// The words that fit in some context. A word of digits is a number for readers of YAML.
Json::Array schema_words(const Field& field) {
    Json::Array words;
    for (std::size_t i = 0; i < field.words.size(); ++i) {
        const bool fits = field.fits == nullptr || std::ranges::any_of(kContexts, [&](const auto& context) {
                              return field.fits(i, context);
                          });
        if (!fits) continue;
        words.emplace_back(field.words[i]);
        const auto number = model::parse_integer(field.words[i]);
        if (number) words.emplace_back(number->as_int64().value_or(0));
    }
    return words;
}

Json integer_schema(const Field& field) {
    auto schema = type_of("integer");
    if (field.range == nullptr) return schema;
    const auto range = widest(field);
    schema.set("minimum", range.least);
    schema.set("maximum", range.greatest);
    return schema;
}

Json text_schema(const Field& field) {
    auto schema = json_object({{"type", json_array({"string", "number", "boolean"})}});
    if (field.range == nullptr) return schema;
    const auto range = widest(field);
    schema.set("minLength", range.least);
    schema.set("maxLength", range.greatest);
    return schema;
}

Json duration_schema(const Field& field) {
    Json::Array forms{
        json_object({{"type", "string"}, {"pattern", "^[0-9]+(\\.[0-9]+)? ?(ns|us|ms|s|min|h|d)$"}}),
        json_object({{"const", 0}})};
    if (!field.words.empty()) forms.push_back(json_object({{"enum", Json(schema_words(field))}}));
    auto schema = json_object({{"anyOf", Json(std::move(forms))}});
    if (field.range != nullptr) {
        const auto range = widest(field);
        schema.set("description",
                   model::to_text(Duration(range.least)) + ".." + model::to_text(Duration(range.greatest)));
    }
    return schema;
}

Json list_schema(Object object, const Field& field) {
    const auto items = object_behind(object, field.key);
    auto list = json_object({{"type", json_array({"array", "null"})}});
    if (!items) return json_object({{"type", json_array({"array", "string", "null"})}});
    list.set("items", reference_to(*items));
    if (field.key != "variables" && field.key != "locals") return list;
    return json_object({{"anyOf", json_array({std::move(list), type_of("string")})}});  // the name of a table
}

/// One mirror, or a list of several.
Json mapping_schema(const Field& field) {
    if (!field.object) return type_of("object");
    auto schema = reference_to(*field.object);
    if (field.object != Object::mirror) return schema;
    auto list = type_of("array");
    list.set("items", schema);
    return json_object({{"anyOf", json_array({std::move(schema), std::move(list)})}});
}

Json value_schema(Object object, const Field& field) {
    switch (field.kind) {
        case Kind::integer: return integer_schema(field);
        case Kind::duration: return duration_schema(field);
        case Kind::boolean: return type_of("boolean");
        case Kind::number: return type_of("number");
        case Kind::text:
        case Kind::local_bool:
        case Kind::local_integer: return text_schema(field);
        case Kind::word:
        case Kind::function: return json_object({{"enum", Json(schema_words(field))}});
        case Kind::constant: return json_object({{"type", json_array({"string", "number", "boolean"})}});
        case Kind::reference: return json_object({{"type", "string"}, {"pattern", "^[0-9]+$"}});
        case Kind::list: return list_schema(object, field);
        case Kind::mapping: return mapping_schema(field);
        case Kind::words: return type_of("object");
        case Kind::ranges: return json_object({{"type", json_array({"array", "string", "integer"})}});
    }
    return {};
}

Json field_schema(Object object, const Field& field) {
    auto schema = value_schema(object, field);
    if (!field.object || field.kind == Kind::mapping) return schema;
    return json_object({{"anyOf", json_array({std::move(schema), reference_to(*field.object)})}});
}

Json object_schema(Object object) {
    Json::Object properties;
    Json::Array required;
    for (const auto& field : model::fields(object)) {
        properties.emplace_back(field.key, field_schema(object, field));
        if (field.required) required.emplace_back(field.key);
    }
    auto schema = type_of("object");
    schema.set("properties", Json(std::move(properties)));
    if (!required.empty()) schema.set("required", Json(std::move(required)));
    schema.set("additionalProperties", false);
    return schema;
}

}  // namespace

std::string_view object_name(Object object) {
    return kNames[static_cast<std::size_t>(object)];
}

std::string_view kind_name(Kind kind) {
    return kind == Kind::ranges ? "ranges" : kKinds[static_cast<std::size_t>(kind)];
}

std::optional<Object> object_behind(std::optional<Object> object, std::string_view key) {
    if (!object) return std::nullopt;
    const auto* const field = model::find_field(*object, key);
    if (field == nullptr) return std::nullopt;
    if (field->object) return field->object;
    std::string path(model::location(*object));
    path.append(path.empty() ? "" : ".").append(key).append("[]");
    for (const auto behind : model::kObjects)
        if (model::location(behind) == path) return behind;
    return std::nullopt;
}

Json project_schema() {
    auto schema = json_object({{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                               {"title", "Takt project file, version 1"}});
    schema.set("$ref", "#/$defs/project");
    Json::Object objects;
    for (const auto object : model::kObjects)
        objects.emplace_back(object_name(object), object_schema(object));
    schema.set("$defs", Json(std::move(objects)));
    return schema;
}

}  // namespace takt::file
