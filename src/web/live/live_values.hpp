// The values of a project as browsers get them: a list once, then the rows that changed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "live/wall_time.hpp"
#include "takt/file/json.hpp"
#include "takt/host/configuration.hpp"
#include "takt/host/event.hpp"
#include "takt/host/snapshot.hpp"

namespace takt::web {

/// The current values by slot, and which of them changed since the last frame. One thread.
class LiveValues {
public:
    /// @param snapshot  with values and statistics
    explicit LiveValues(const host::Snapshot& snapshot);

    [[nodiscard]] const host::ConfigurationPtr& configuration() const { return configuration_; }

    void apply(const host::ValueChanged& changed);
    /// Takes over what no event reports: when a value that stayed the same was read, and why its device does
    /// not answer. @param snapshot  of the same generation; without statistics only the former
    void refresh(const host::Snapshot& snapshot);

    [[nodiscard]] bool changed() const { return !changed_.empty(); }
    /// Values that stayed the same were read.
    [[nodiscard]] bool read() const { return !read_.empty(); }

    /// The data of the event `snapshot`: docs/web.md, "Streams".
    [[nodiscard]] std::string list_text(Instant t) const;
    /// The data of the event `values`. Marks all values as unchanged.
    [[nodiscard]] std::string take_rows_text(Instant t);
    /// The data of the event `reads`: when values that stayed the same were read, those of one instant that
    /// follow each other as one entry. Marks them as not read.
    [[nodiscard]] std::string take_reads_text(Instant t);

private:
    struct State {
        value::Value value;
        value::Quality quality = value::Quality::never_read;
        value::Reason reason = value::Reason::ok;
        value::Reason cause = value::Reason::ok;
        std::optional<Instant> sampled_at;
    };

    void mark(std::uint32_t slot);
    [[nodiscard]] std::vector<bool> triggers() const;
    [[nodiscard]] file::Json entry(std::uint32_t slot, const WallTime& clock, bool trigger) const;

    host::ConfigurationPtr configuration_;
    std::vector<State> states_;           // by SlotId
    std::vector<std::uint32_t> changed_;  // slots, each once
    std::vector<bool> is_changed_;        // by SlotId
    std::vector<std::uint32_t> read_;     // ascending; may be in changed_ as well
};

/// For JSON; null without a time.
[[nodiscard]] file::Json milliseconds_or_null(const std::optional<Duration>& time);

/// The age that the plan proves for a variable; nothing: it proves none.
[[nodiscard]] std::optional<Duration> proved_age(const host::Configuration& configuration,
                                                 const value::VariableIndex& index);

/// The registers of a variable that hold a value; null for coils and where there is no value.
[[nodiscard]] file::Json raw_json(const model::Variable& variable, const value::Value& value);

}  // namespace takt::web
