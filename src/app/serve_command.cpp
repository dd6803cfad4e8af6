// Being the devices of a project on its lines, or one blank device.
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "fault_commands.hpp"
#include "place_access.hpp"
#include "serve_places.hpp"
#include "served_sources.hpp"
#include "serving.hpp"
#include "takt/app/commands.hpp"
#include "takt/app/console.hpp"
#include "takt/app/log.hpp"
#include "takt/app/project.hpp"
#include "takt/app/texts.hpp"
#include "takt/line/descriptors.hpp"
#include "takt/report/serve_report.hpp"
#include "work_loop.hpp"

namespace takt::app {
namespace {

/// What a project's servers are bound to while nobody polls.
struct Bound {
    explicit Bound(const model::Project& project) : values(project), sources(project, values) {}
    ServedValues values;
    ServedSources sources;
};

/// Everything of a serving, in the order in which it must be made and (backwards) taken down.
class Service {
public:
    /// @param places, options  outlive it; so does `bound`, which may be nullptr
    Service(const Texts& texts, std::vector<Place>& places, const ServeOptions& options, Bound* bound)
        : texts_(texts), places_(places), options_(options), bound_(bound), access_(texts, places, options) {}
    ~Service() {
        if (bound_) bound_->sources.close();  // it outlives the loop
    }
    Service(const Service&) = delete;
    Service& operator=(const Service&) = delete;

    Result<void> begin(std::vector<model::AccessRule> rules) {
        (void)line::raise_descriptor_limit();
        TAKT_CHECK(access_.begin(std::move(rules)));
        std::function<void()> reload;
        if (access_.reloads()) reload = [this] { access_.reload(); };
        TAKT_CHECK(work_loop_.begin(options_.traffic, std::move(reload)));
        auto& loop = work_loop_.loop();
        if (bound_) TAKT_CHECK(bound_->sources.open(loop));
        TAKT_CHECK(begin_faults(loop));
        for (const auto& place : places_) TAKT_CHECK(open_retained(loop, texts_, place));
        for (const auto& place : places_) {
            TAKT_TRY(auto serving, start_serving(loop, place, work_loop_.traffic()));
            print_status(place_text(texts_, place, serving));
            serving_.push_back(std::move(serving));
        }
        return {};
    }

    void work() {
        work_loop_.work(options_.run_for);
        const auto summary = end_serving(places_, serving_);
        access_.finish();
        if (options_.json)
            print(report::served_json(summary));
        else
            print_status(report::served_text(texts_, summary));
    }

private:
    Result<void> begin_faults(line::Loop& loop) {
        if (options_.faults.empty() && options_.control_path.empty()) return {};
        const auto faults = std::make_shared<sim::AnswerFaults>();
        for (const auto& rule : options_.faults)
            if (!faults->add(line::now(), rule)) return fail(Code::queue_full, sim::AnswerFaults::kMost);
        for (auto& place : places_) place.faults = faults;
        if (!options_.control_path.empty()) {
            TAKT_TRY(control_, ControlServer::listen(loop, options_.control_path,
                                                     fault_commands(loop, faults), texts_));
        }
        return {};
    }

    Texts texts_;
    std::vector<Place>& places_;
    const ServeOptions& options_;
    Bound* bound_;
    WorkLoop work_loop_;
    PlaceAccess access_;
    std::unique_ptr<ControlServer> control_;
    std::vector<Serving> serving_;
};

}  // namespace

ExitCode serve(const CommonOptions& common, const ServeOptions& options) {
    const Texts texts(common.language);
    std::optional<LoadedProject> loaded;
    if (options.state.empty() != options.blank.retain.empty()) {
        print_error(texts("app.registers.where"));
        return ExitCode::usage;
    }
    if (options.file.empty()) {
        if (options.listen.empty() && options.port.empty()) {
            print_error(texts("app.serve_where"));
            return ExitCode::usage;
        }
    } else {
        loaded = load_to_run(texts, options.file);
        if (!loaded) return ExitCode::usage;
        const bool replaced = !options.listen.empty() || !options.port.empty();
        if (replaced && !loaded->project.servers.empty()) {
            print_error(texts("app.serve_has_servers", {{"file", options.file}}));
            return ExitCode::usage;
        }
        if (replaced &&
            (loaded->project.lines.size() != 1 || (!options.listen.empty() && !options.port.empty()))) {
            print_error(
                texts("app.serve_one_line", {{"count", std::to_string(loaded->project.lines.size())}}));
            return ExitCode::usage;
        }
    }
    const bool servers = loaded && !loaded->project.servers.empty();
    std::optional<Bound> bound;
    if (servers) bound.emplace(loaded->project);
    const auto bind = [&](std::size_t server, Place& place) { bound->sources.bind(server, place); };
    auto places = servers  ? Result<std::vector<Place>>(server_places(loaded->project, options, bind))
                  : loaded ? device_places(loaded->project, options)
                           : blank_places(options);
    if (!places) return ended_by(texts, places.error());
    std::vector<model::AccessRule> rules;
    if (!options.access.empty()) {
        auto read = load_access(texts, options.access);
        if (!read) return ExitCode::usage;
        rules = *std::move(read);
    }
    if (const auto count = servers ? bound_to_lines(loaded->project) : 0; count > 0)
        print_status(texts("app.serve.not_polled", {{"count", std::to_string(count)}}) + '\n');
    Service service(texts, *places, options, bound ? &*bound : nullptr);
    if (const auto begun = service.begin(std::move(rules)); !begun) return ended_by(texts, begun.error());
    service.work();
    return ExitCode::ok;
}

}  // namespace takt::app
