#include "takt/report/states/client_report.hpp"

#include <fmt/format.h>

#include <string_view>
#include <utility>
#include <variant>

#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/value_json.hpp"
#include "takt/text/escape.hpp"
#include "takt/value/text.hpp"
#include "takt/wire/frame_words.hpp"

namespace takt::report {
namespace {

using file::Json;

constexpr std::string_view kInterrupted = "app.client.interrupted";
constexpr std::string_view kWriteInterrupted = "app.client.write_interrupted";

Json begin(const ClientRun& run) {
    auto object = Json::object();
    object.set("target", run.target);
    object.set("unit", run.unit);
    return object;
}

std::string failure_reason(const Texts& texts, const ClientRun& run, const Error& error,
                           std::string_view message) {
    return run.interrupted ? texts(message) : texts.describe(error);
}

/// Adds "error" where the requests ended early.
/// @param message  the code of the message for an interruption
template <class T>
void set_end(Json& object, const Texts& texts, const ClientRun& run, const Result<T>& ended,
             std::string_view message) {
    if (ended) return;
    auto error = error_json(texts, ended.error());
    if (run.interrupted) error.set("code", "interrupted");
    error.set("text", failure_reason(texts, run, ended.error(), message));
    object.set("error", std::move(error));
}

}  // namespace

std::string read_text(DataType type, std::span<const client::ReadValue> values) {
    std::string text;
    for (const auto& [address, value] : values)
        text += fmt::format("{} {}\n", address,
                            type == DataType::boolean ? (std::get<bool>(value) ? "1" : "0")
                                                      : text::escape_line(value::format(type, false, value)));
    return text;
}

Json read_json(const Texts& texts, const ClientRun& run, const client::ReadSpec& spec,
               std::span<const client::ReadValue> values, const Result<void>& ended) {
    auto list = Json::array();
    for (const auto& read : values) list.push_back(to_json(spec.type(), false, read.value));
    auto object = begin(run);
    object.set("function", static_cast<int>(wire::read_function(spec.area)));
    object.set("start", spec.start);
    object.set("type", name(spec.type()));
    object.set("values", std::move(list));
    object.set("time_ms", milliseconds(run.duration));
    set_end(object, texts, run, ended, kInterrupted);
    return object;
}

std::string write_text(const Texts& texts, const WriteRun& write) {
    const auto& written = write.written;
    return texts(written.ended ? "app.written" : "app.partly_written",
                 {{"count", std::to_string(written.items)},
                  {"total", std::to_string(write.wanted)},
                  {"start", std::to_string(write.start)},
                  {"next", std::to_string(write.start + written.items)}});
}

Json write_json(const Texts& texts, const ClientRun& run, const WriteRun& write) {
    const auto& written = write.written;
    auto object = begin(run);
    object.set("function", static_cast<int>(written.function));
    object.set("start", write.start);
    object.set("quantity", static_cast<std::uint64_t>(written.items));
    object.set("outcome", written.outcome());
    if (!written.ended) object.set("wanted", static_cast<std::uint64_t>(write.wanted));
    object.set("time_ms", milliseconds(run.duration));
    set_end(object, texts, run, written.ended, kWriteInterrupted);
    return object;
}

Json raw_json(const Texts& texts, const ClientRun& run, Bytes request, const Result<Bytes>& response) {
    auto object = begin(run);
    object.set("request", wire::hex(request));
    if (response) object.set("response", wire::hex(*response));
    set_end(object, texts, run, response, kInterrupted);
    return object;
}

std::string ended_text(const Texts& texts, const ClientRun& run, const Error& error) {
    return failure_reason(texts, run, error, kInterrupted);
}

std::string write_ended_text(const Texts& texts, const ClientRun& run, const Error& error) {
    return failure_reason(texts, run, error, kWriteInterrupted);
}

}  // namespace takt::report
