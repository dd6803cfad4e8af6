// write: values to one device, in as many requests as it takes.
#include <string>
#include <vector>

#include "commands/client_commands.hpp"
#include "commands/one_off.hpp"
#include "output.hpp"

namespace takt::app {
namespace {

file::Json write_json(const WriteOptions& options, std::size_t items, const client::Written& written,
                      Duration time) {
    auto object = object_of(options);
    object.set("function", static_cast<int>(written.function));
    object.set("start", options.spec.start);
    object.set("quantity", static_cast<std::uint64_t>(written.items));
    object.set("outcome", written.outcome());
    if (!written.ended) object.set("wanted", static_cast<std::uint64_t>(items));
    object.set("time_ms", static_cast<double>(time.count()) / 1e6);
    return object;
}

}  // namespace

ExitCode write(const CommonOptions& common, const WriteOptions& options) {
    const Texts texts(common.language);
    const auto& spec = options.spec;
    if (spec.area != wire::Area::coil && spec.area != wire::Area::holding_register) {
        print_error(texts("app.read_only_area"));
        return ExitCode::usage;
    }
    if (is_for_registers(texts, spec.area, options.registers_only)) return ExitCode::usage;
    const auto parts = client::write_parts(spec);
    if (!parts) return bad_arguments(texts, parts.error());
    const std::size_t items = parts->back().end;
    if (is_beyond(texts, spec.start, items)) return ExitCode::usage;
    const auto one_off = OneOff::open(options);
    if (!one_off) {
        const client::Written nothing{.function = wire::function_of(parts->front().request),
                                      .ended = std::unexpected(one_off.error())};
        return ended_by(texts, options, nullptr, one_off.error(), write_json(options, items, nothing, {}));
    }
    const Instant begin = line::now();
    const auto written = client::write_values((*one_off)->device(), *parts);
    auto object = write_json(options, items, written, line::now() - begin);
    const Texts::Arguments counts{{"count", std::to_string(written.items)},
                                  {"total", std::to_string(items)},
                                  {"start", std::to_string(spec.start)},
                                  {"next", std::to_string(spec.start + written.items)}};
    if (written.ended) {
        if (options.json)
            print(object.dump() + "\n");
        else
            print_status(texts("app.written", counts) + "\n");
        return ExitCode::ok;
    }
    const ExitCode code = ended_by(texts, options, one_off->get(), written.ended.error(), std::move(object),
                                   "app.client.write_interrupted");
    if (written.items == 0) return code;
    print_error(texts("app.partly_written", counts));
    return ExitCode::partly;
}

}  // namespace takt::app
