// The servers of a project bound to their sources.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "serve_places.hpp"
#include "takt/app/running.hpp"
#include "takt/line/loop.hpp"
#include "takt/model/project.hpp"
#include "takt/source/bound_server.hpp"
#include "takt/source/feed.hpp"

namespace takt::app {

/// The values of a project that runs.
class RunningValues final : public source::ProjectValues {
public:
    /// @param running  outlives it
    explicit RunningValues(Running& running) : running_(running) {}
    [[nodiscard]] const value::Store& store() const override { return running_.values(); }
    [[nodiscard]] Result<bool> set(value::SlotId local, const value::Value& value) override {
        return running_.set_local(local, value);
    }
    [[nodiscard]] Result<bool> write(value::SlotId variable, const value::Value& value,
                                     Running::Written done) override {
        return running_.write_value(variable, value, std::move(done));
    }

private:
    Running& running_;
};

/// The values of a project that is only served: its locals; nothing is known of variables.
class ServedValues final : public source::ProjectValues {
public:
    explicit ServedValues(const model::Project& project);
    [[nodiscard]] const value::Store& store() const override { return store_; }
    [[nodiscard]] Result<bool> set(value::SlotId local, const value::Value& value) override;
    /// @returns timed_out: nobody polls
    [[nodiscard]] Result<bool> write(value::SlotId variable, const value::Value& value,
                                     Running::Written done) override;

private:
    value::Store store_;
};

/// The sources of a project, and what answers for its bound servers. The loop's thread only.
class ServedSources {
public:
    /// @param project, values  outlive it
    ServedSources(const model::Project& project, source::ProjectValues& values)
        : project_(project), values_(values) {}

    ~ServedSources() { close(); }
    ServedSources(const ServedSources&) = delete;
    ServedSources& operator=(const ServedSources&) = delete;

    /// Puts the bindings of the project's server of that index before the responder of its place; afterwards
    /// they know of no values.
    void bind(std::size_t server, Place& place);

    /// Connects what was bound, and opens the instruments' lines.
    /// @param loop  outlives what it is used for: to the end of this, or to close()
    /// @returns what source::Feeds::open() and feed() return
    [[nodiscard]] Result<void> open(line::Loop& loop);

    /// Nothing is fed any more: reads of what is bound are exception 0x0B.
    void close();

private:
    const model::Project& project_;
    source::ProjectValues& values_;
    std::optional<source::Feeds> feeds_;
    std::vector<std::shared_ptr<source::BoundServer>> bound_;
};

/// How many variables of servers are bound to variables of lines, or written to them.
[[nodiscard]] std::size_t bound_to_lines(const model::Project& project);

}  // namespace takt::app
