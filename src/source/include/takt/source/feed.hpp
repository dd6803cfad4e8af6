// What the bound variables of a project's servers are fed from.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "takt/base/log.hpp"
#include "takt/base/result.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/loop.hpp"
#include "takt/model/project.hpp"
#include "takt/source/instrument_engine.hpp"
#include "takt/source/loop_worker.hpp"
#include "takt/source/reading.hpp"
#include "takt/value/store.hpp"

namespace takt::source {

/// The content of one source. The loop's thread only.
class Feed {
public:
    virtual ~Feed() = default;
    /// @param t  never before that of an earlier call
    [[nodiscard]] virtual Reading read(Instant t) = 0;
};

/// The sources of a project at work: instruments on their lines, files and commands looked at in their
/// rhythm. Everything is started by the constructor and ends with it.
class Feeds {
public:
    /// At most so many files and commands are looked at, or run, at a time.
    static constexpr std::size_t kThreads = 4;

    /// @param folder   of the project file: where relative paths begin
    /// @param store    the values of the project's variables and locals; loop, project and store outlive it
    Feeds(line::Loop& loop, const model::Project& project, std::string folder, const value::Store& store,
          const Log& log = {});
    ~Feeds();
    Feeds(const Feeds&) = delete;
    Feeds& operator=(const Feeds&) = delete;

    /// Opens the instruments' lines. A serial port that is not there is looked for again and again.
    /// @returns unsupported, out_of_range: settings that the port cannot have
    [[nodiscard]] Result<void> open();

    /// For a binding with a source.
    /// @returns what reading the file of a replay returns
    [[nodiscard]] Result<std::unique_ptr<Feed>> feed(const model::Variable& variable,
                                                     const model::Source& source);

    /// Runs a command that a write goes to, one after the other. `done` gets an error, if there is one, on
    /// the loop's thread, never from inside. @returns false when kMostWrites wait
    static constexpr std::size_t kMostWrites = 32;
    bool run(const model::Command& command, const std::string& value,
             std::function<void(const std::optional<Error>&)> done);

    /// By the index of the instrument in the project.
    [[nodiscard]] const InstrumentCounters& counters(std::size_t instrument) const;

private:
    struct OnLine {
        std::unique_ptr<InstrumentEngine> engine;
        std::unique_ptr<line::Driver> driver;
    };
    class Probe;

    [[nodiscard]] std::string placed(const std::string& path) const;
    std::unique_ptr<Feed> probe(const model::TextTemplate& pattern, Duration every,
                                std::function<Result<std::string>(const StopFlag&)> look);

    line::Loop& loop_;
    const model::Project& project_;
    std::string folder_;
    const value::Store& store_;
    Log log_;
    Instant start_;
    std::vector<OnLine> instruments_;
    LoopWorker readers_;
    LoopWorker writers_;
};

}  // namespace takt::source
