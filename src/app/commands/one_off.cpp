#include "commands/one_off.hpp"

#include "output.hpp"
#include "takt/line/target.hpp"
#include "takt/report/formatting.hpp"
#include "takt/report/value_json.hpp"

namespace takt::app {

Result<std::unique_ptr<OneOff>> OneOff::open(const ClientOptions& options) {
    TAKT_CHECK(line::parse_target(options.target));  // a bad target makes no traffic log
    auto one_off = std::make_unique<OneOff>();
    TAKT_CHECK(one_off->loop_.begin(options.traffic, {}));
    auto& loop = one_off->loop_;
    TAKT_TRY(one_off->client_, client::Client::open(loop.loop(), options,
                                                    console::traffic_factory(
                                                        loop.traffic(), console::LineTraffic::Side::master)));
    return one_off;
}

ExitCode ended_by(const Texts& texts, const ClientOptions& options, OneOff* one_off, const Error& error,
                  file::Json object, std::string_view interrupted) {
    const bool stopped = one_off && one_off->device().interrupted();
    if (options.json) {
        auto what = report::error_json(texts, error);
        if (stopped) what.set("code", "interrupted");
        if (stopped) what.set("text", texts(interrupted));
        object.set("error", std::move(what));
        print(object.dump() + "\n");
    }
    print_error(stopped ? texts(interrupted) : texts.describe(error));
    return stopped ? ExitCode::timed_out : exit_code(error);
}

file::Json object_of(const ClientOptions& options) {
    auto object = file::Json::object();
    object.set("target", options.target);
    object.set("unit", options.unit);
    return object;
}

ExitCode bad_arguments(const Texts& texts, const Error& error) {
    print_error(texts.describe(error));
    return ExitCode::usage;
}

bool is_for_registers(const Texts& texts, wire::Area area, bool given) {
    if (!given || !is_bit_area(area)) return false;
    print_error(texts("app.registers_only", {{"area", std::string(report::area_word(area))}}));
    return true;
}

bool is_beyond(const Texts& texts, std::uint64_t start, std::uint64_t items) {
    if (start + items <= 65536) return false;
    print_error(
        texts("app.beyond_area", {{"start", std::to_string(start)}, {"items", std::to_string(items)}}));
    return true;
}

}  // namespace takt::app
