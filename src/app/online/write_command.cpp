// write: values to one device, in as many requests as it takes.
#include "commands.hpp"
#include "online/one_off.hpp"
#include "output.hpp"

namespace takt::app {
namespace {

ExitCode report_end(const Texts& texts, const WriteOptions& options, const report::ClientRun& run,
                    const report::WriteRun& write) {
    const auto& ended = write.written.ended;
    if (options.json) print(report::write_json(texts, run, write).dump() + '\n');
    if (ended) {
        if (!options.json) print_status(report::write_text(texts, write) + '\n');
        return ExitCode::ok;
    }
    print_error(report::write_ended_text(texts, run, ended.error()));
    if (write.written.items == 0) return exit_code(run, ended.error());
    return ended_with(report::write_text(texts, write), ExitCode::partly);
}

}  // namespace

ExitCode write(const CommonOptions& common, const WriteOptions& options) {
    const Texts texts(common.language);
    auto spec = options.spec;
    if (spec.area != wire::Area::coil && spec.area != wire::Area::holding_register)
        return ended_with(texts("app.read_only_area"), ExitCode::usage);
    const auto start = start_meant(texts, spec.area, spec.start, options);
    if (!start) return ExitCode::usage;
    spec.start = *start;
    const auto parts = client::write_parts(spec);
    if (!parts) return ended_with(texts.describe(parts.error()), ExitCode::usage);
    const std::size_t items = parts->back().end;
    if (is_beyond(texts, spec.start, items)) return ExitCode::usage;
    auto run = run_of(options);
    report::WriteRun write{.start = spec.start, .wanted = items, .written = {}};
    const auto one_off = OneOff::open(texts, options);
    if (one_off) {
        auto& device = (*one_off)->device();
        const Instant begin = line::now();
        write.written = client::write_values(device, *parts);
        run.duration = line::now() - begin;
        run.interrupted = device.interrupted();
    } else {
        write.written = {.function = wire::function_of(parts->front().request),
                         .ended = std::unexpected(one_off.error())};
    }
    return report_end(texts, options, run, write);
}

}  // namespace takt::app
