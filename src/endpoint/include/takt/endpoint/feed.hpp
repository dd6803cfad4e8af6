// The sources that feed the bound variables of a project's servers.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "takt/base/log.hpp"
#include "takt/base/result.hpp"
#include "takt/endpoint/instrument_engine.hpp"
#include "takt/endpoint/loop_worker.hpp"
#include "takt/endpoint/reading.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/loop.hpp"
#include "takt/model/continued.hpp"
#include "takt/model/project.hpp"
#include "takt/value/store.hpp"

namespace takt::endpoint {

/// The content of one source. The loop's thread only.
class Feed {
public:
    virtual ~Feed() = default;
    /// @param t  not before that of an earlier call
    [[nodiscard]] virtual Reading read(Instant t) = 0;
};

/// The sources of a running project: instruments on their lines, files and commands polled at their periods.
/// The constructor starts everything, the destructor ends it.
class Feeds {
public:
    /// Files read and commands run at the same time.
    static constexpr std::size_t kThreads = 4;

    /// @param folder   folder of the project file, the base of relative paths
    /// @param store    the values of the project's variables and locals; loop, project and store outlive it
    Feeds(line::Loop& loop, const model::Project& project, std::string folder, const value::Store& store,
          const Log& log = {});
    ~Feeds();
    Feeds(const Feeds&) = delete;
    Feeds& operator=(const Feeds&) = delete;

    /// Opens the lines of the instruments. A serial port that is missing is retried.
    /// @returns unsupported, out_of_range: settings that the port cannot have
    [[nodiscard]] Result<void> open();

    /// Another project runs. Instruments that continue in it (model::continued_instruments()) keep their
    /// connections and measurements, and commands that run end; the others are closed, or opened.
    /// @returns as open()
    [[nodiscard]] Result<void> change(const model::Project& project, const value::Store& store);

    /// The feed of a binding with a source.
    /// @returns what reading the file of a replay returns
    [[nodiscard]] Result<std::unique_ptr<Feed>> feed(const model::Variable& variable,
                                                     const model::Source& source);

    /// Runs a command that is the sink of a write, one at a time. `done` gets an error or nothing, on the
    /// loop's thread, never from inside. @returns false if kMostWrites are waiting
    static constexpr std::size_t kMostWrites = 32;
    bool run(const model::Command& command, const std::string& value,
             std::function<void(const std::optional<Error>&)> done);

    /// Sends a value to an instrument with one of its commands (InstrumentEngine::submit()).
    /// @param instrument, command  indices in the project
    /// @param done  called once, later, on the loop's thread, never from inside; not after the destruction
    /// @returns out_of_range: the command does not take the value; what submit() returns. Then `done` is not
    ///          called
    [[nodiscard]] Result<void> write(std::size_t instrument, std::size_t command, const value::Value& value,
                                     InstrumentEngine::Done done);

    /// Whether the command takes the value; nothing is sent.
    [[nodiscard]] Result<void> check(std::size_t instrument, std::size_t command,
                                     const value::Value& value) const;

    /// The counters and the state of an instrument, by its index in the project.
    [[nodiscard]] const InstrumentCounters& counters(std::size_t instrument) const;
    [[nodiscard]] InstrumentState state(std::size_t instrument) const;
    [[nodiscard]] std::size_t instruments() const { return instruments_.size(); }
    [[nodiscard]] const std::string& instrument_name(std::size_t instrument) const;

private:
    class OnLine;
    class Probe;

    [[nodiscard]] std::string placed(const std::string& path) const;
    std::unique_ptr<Feed> probe(const model::TextTemplate& pattern, Duration every,
                                std::function<Result<std::string>(const StopFlag&)> look);

    line::Loop& loop_;
    const model::Project* project_;
    std::string folder_;
    const value::Store* store_;
    Log log_;
    Instant start_;
    std::vector<std::unique_ptr<OnLine>> instruments_;  // as in the project
    LoopWorker readers_;
    LoopWorker writers_;
};

}  // namespace takt::endpoint
