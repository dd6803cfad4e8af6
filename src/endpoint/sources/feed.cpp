// Files and commands are read by worker threads, never on the loop. A source is polled only after its
// previous result has arrived, so that slow sources do not accumulate jobs.
#include "takt/endpoint/feed.hpp"

#include <algorithm>
#include <utility>

#include "sources/command_text.hpp"
#include "sources/instrument_log.hpp"
#include "sources/outside.hpp"
#include "takt/base/ascii.hpp"
#include "takt/endpoint/answer.hpp"
#include "takt/sim/generator.hpp"
#include "takt/value/project_slots.hpp"

namespace takt::endpoint {
namespace {

constexpr std::size_t kMostProbes = 4096;

constexpr std::string_view kSpace = " \t\r\n\f\v";

class ConstantFeed final : public Feed {
public:
    explicit ConstantFeed(value::Value value) : value_(std::move(value)) {}
    [[nodiscard]] Reading read(Instant t) override { return {value_, t, false}; }

private:
    value::Value value_;
};

class GeneratorFeed final : public Feed {
public:
    GeneratorFeed(const model::Generator& settings, Instant start) : generator_(settings, start) {}
    [[nodiscard]] Reading read(Instant t) override { return {generator_.at(t), t, false}; }

private:
    sim::Generator generator_;
};

class ReplayFeed final : public Feed {
public:
    ReplayFeed(std::vector<double> rows, const model::Replay& settings, Instant start)
        : rows_(std::move(rows)), every_(settings.every), loop_(settings.loop), start_(start) {}
    [[nodiscard]] Reading read(Instant t) override {
        const auto step = static_cast<std::size_t>(std::max(t - start_, Duration::zero()) / every_);
        return {rows_[loop_ ? step % rows_.size() : std::min(step, rows_.size() - 1)], t, false};
    }

private:
    std::vector<double> rows_;
    Duration every_;
    bool loop_;
    Instant start_;
};

class StoreFeed final : public Feed {
public:
    StoreFeed(const value::Store& store, value::SlotId slot) : store_(store), slot_(slot) {}
    [[nodiscard]] Reading read(Instant t) override {
        const auto& slot = store_[slot_];
        if (slot.quality == value::Quality::never_read || slot.quality == value::Quality::bad ||
            value::is_empty(slot.value))
            return {.fails = true};
        // A local has a value from the start, even if it was never set.
        return {slot.value, store_.info(slot_).local && !slot.good_at ? t : slot.good_at, false};
    }

private:
    const value::Store& store_;
    value::SlotId slot_;
};

class MeasurementFeed final : public Feed {
public:
    MeasurementFeed(const InstrumentEngine& engine, std::string_view measurement)
        : reading_(engine.reading(measurement)) {}
    [[nodiscard]] Reading read(Instant) override { return reading_; }

private:
    const Reading& reading_;
};

class StateFeed final : public Feed {
public:
    explicit StateFeed(const InstrumentEngine& engine) : engine_(engine) {}
    [[nodiscard]] Reading read(Instant t) override {
        return {static_cast<std::int64_t>(engine_.state()), t, false};
    }

private:
    const InstrumentEngine& engine_;
};

}  // namespace

/// An instrument on its line. A timer of its own ends commands that expire while the link is down: the driver
/// is then idle.
class Feeds::OnLine {
public:
    OnLine(line::Loop& loop, const model::Instrument& instrument, const Log& log)
        : settings(instrument), loop_(loop), log_(log, settings), expiry_(loop, [this](Instant t) {
              engine.on_tick(t);
              expiry_.set(engine.next_expiry());
              if (driver_) driver_->poke();
          }) {
        engine.set_observer([this](Instant t, const InstrumentEvent& event) { log_.on_event(t, event); });
    }

    [[nodiscard]] Result<void> open() {
        if (driver_) return {};
        line::DriverOptions options;
        options.wait_for_port = true;
        options.on_link = [this](Instant t, bool up, const std::optional<Error>& why) {
            log_.on_link(t, up, why);
        };
        if (!settings.serial) {
            driver_ = line::connect_tcp(loop_, settings.port, settings.tcp_port, engine, options);
            return {};
        }
        line::SerialSettings serial;
        serial.path = settings.port;
        serial.format = settings.format;
        TAKT_TRY(driver_, line::open_serial(loop_, serial, engine, options));
        return {};
    }

    // The engine gives results from inside the driver's calls: they are posted, because a client may send its
    // next request from inside the delivery.
    [[nodiscard]] Result<void> write(std::size_t command, const value::Value& value,
                                     InstrumentEngine::Done done) {
        TAKT_TRY(auto text, command_text(settings.commands[command], value));
        const Instant t = line::now();
        TAKT_CHECK(
            engine.submit(t, command, std::move(text),
                          [this, alive = std::weak_ptr(alive_), done = std::move(done)](WriteResult result) {
                              loop_.post([alive, done, result] {
                                  if (!alive.expired()) done(result);
                              });
                          }));
        expiry_.set(engine.next_expiry());
        if (driver_) driver_->poke();
        return {};
    }

    const model::Instrument settings;
    InstrumentEngine engine{settings};

private:
    line::Loop& loop_;
    InstrumentLog log_;
    std::shared_ptr<bool> alive_ = std::make_shared<bool>();
    line::Timer expiry_;
    std::unique_ptr<line::Driver> driver_;  // nullptr: not opened yet
};

/// Polls a file or command at its period on a worker thread, one call at a time.
class Feeds::Probe final : public Feed {
public:
    using Look = std::function<Result<std::string>(const StopFlag&)>;

    Probe(line::Loop& loop, LoopWorker& worker, const model::TextTemplate& pattern, Duration every, Look look)
        : state_(std::make_shared<State>(State{pattern, {}, false, true})),
          worker_(worker),
          every_(every),
          look_(std::move(look)),
          timer_(loop, [this](Instant t) { begin(t); }) {
        timer_.set(line::now());
    }
    ~Probe() override { state_->wanted = false; }

    [[nodiscard]] Reading read(Instant) override { return state_->reading; }

private:
    struct State {
        model::TextTemplate pattern;
        Reading reading;
        bool busy = false;
        bool wanted = true;
    };

    void begin(Instant t) {
        timer_.set(after(t, every_));
        if (state_->busy) return;
        state_->busy = worker_.run([state = state_, look = look_, t](const StopFlag& stop) {
            auto text = look(stop);
            return std::function<void()>([state, t, text = std::move(text)] {
                state->busy = false;
                if (state->wanted) take(*state, t, text);
            });
        });
    }

    static void take(State& state, Instant t, const Result<std::string>& text) {
        auto found = text ? match(state.pattern, *text) : std::nullopt;
        // Programs print spaces before the number and line ends behind it.
        if (text && !found) found = match(state.pattern, trimmed(*text, kSpace));
        state.reading.fails = true;
        if (!found) return;
        for (const auto& [name, value] : *found)
            if (name == "value") state.reading = {value, t, false};
    }

    std::shared_ptr<State> state_;
    LoopWorker& worker_;
    Duration every_;
    Look look_;
    line::Timer timer_;
};

Feeds::Feeds(line::Loop& loop, const model::Project& project, std::string folder, const value::Store& store,
             const Log& log)
    : loop_(loop),
      project_(&project),
      folder_(std::move(folder)),
      store_(&store),
      log_(log),
      start_(line::now()),
      readers_(loop, kThreads, kMostProbes),
      writers_(loop, 1, kMostWrites) {
    for (const auto& instrument : project.instruments)
        instruments_.push_back(std::make_unique<OnLine>(loop, instrument, log));
}

Feeds::~Feeds() = default;

Result<void> Feeds::open() {
    for (const auto& instrument : instruments_) TAKT_CHECK(instrument->open());
    return {};
}

Result<void> Feeds::change(const model::Project& project, const value::Store& store) {
    const auto before = model::continued_instruments(*project_, project);
    auto old = std::exchange(instruments_, {});
    for (std::size_t i = 0; i < before.size(); ++i)
        instruments_.push_back(before[i] ? std::move(old[*before[i]])
                                         : std::make_unique<OnLine>(loop_, project.instruments[i], log_));
    old.clear();  // a port that one of them had is free for another
    project_ = &project;
    store_ = &store;
    return open();
}

std::string Feeds::placed(const std::string& path) const {
    return path.starts_with('/') || folder_.empty() ? path : folder_ + "/" + path;
}

std::unique_ptr<Feed> Feeds::probe(const model::TextTemplate& pattern, Duration every,
                                   std::function<Result<std::string>(const StopFlag&)> look) {
    return std::make_unique<Probe>(loop_, readers_, pattern, every, std::move(look));
}

Result<std::unique_ptr<Feed>> Feeds::feed(const model::Variable& variable, const model::Source& source) {
    const auto stored = [&](const std::string& name) -> std::unique_ptr<Feed> {
        const auto slot = store_->find(name);
        // The profile may have removed the variable.
        if (!slot) return std::make_unique<ConstantFeed>(value::Value{});
        return std::make_unique<StoreFeed>(*store_, *slot);
    };
    if (const auto* const constant = std::get_if<model::Constant>(&source))
        return std::make_unique<ConstantFeed>(value::to_value(variable.type, variable.scaled(), *constant));
    if (const auto* const generator = std::get_if<model::Generator>(&source))
        return std::make_unique<GeneratorFeed>(*generator, start_);
    if (const auto* const replay = std::get_if<model::Replay>(&source)) {
        TAKT_TRY(auto rows, read_column(placed(replay->path), replay->column));
        return std::make_unique<ReplayFeed>(std::move(rows), *replay, start_);
    }
    if (const auto* const file = std::get_if<model::FileSource>(&source))
        return probe(file->pattern, file->every,
                     [path = placed(file->path)](const StopFlag&) { return read_small_file(path); });
    if (const auto* const command = std::get_if<model::CommandSource>(&source))
        return probe(command->pattern, command->every,
                     [run = command->command](const StopFlag& stop) { return run_command(run, stop); });
    if (const auto* const other = std::get_if<model::VariableSource>(&source)) return stored(other->name);
    if (const auto* const local = std::get_if<model::LocalSource>(&source)) return stored(local->name);
    const auto& measured = std::get<model::InstrumentSource>(source);
    const auto& engine = instruments_[measured.instrument]->engine;
    if (measured.measurement.empty()) return std::make_unique<StateFeed>(engine);
    return std::make_unique<MeasurementFeed>(engine, measured.measurement);
}

bool Feeds::run(const model::Command& command, const std::string& value,
                std::function<void(const std::optional<Error>&)> done) {
    return writers_.run([filled = with_value(command, value), done = std::move(done)](const StopFlag& stop) {
        const auto result = run_command(filled, stop);
        return std::function<void()>(
            [done, error = result ? std::nullopt : std::optional(result.error())] { done(error); });
    });
}

Result<void> Feeds::write(std::size_t instrument, std::size_t command, const value::Value& value,
                          InstrumentEngine::Done done) {
    return instruments_[instrument]->write(command, value, std::move(done));
}

Result<void> Feeds::check(std::size_t instrument, std::size_t command, const value::Value& value) const {
    TAKT_CHECK(command_text(instruments_[instrument]->settings.commands[command], value));
    return {};
}

InstrumentState Feeds::state(std::size_t instrument) const {
    return instruments_[instrument]->engine.state();
}

const std::string& Feeds::instrument_name(std::size_t instrument) const {
    return instruments_[instrument]->settings.name;
}

const InstrumentCounters& Feeds::counters(std::size_t instrument) const {
    return instruments_[instrument]->engine.counters();
}

}  // namespace takt::endpoint
