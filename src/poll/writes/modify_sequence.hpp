// Read-modify-writes of a line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "line/job_id.hpp"
#include "takt/base/assert.hpp"
#include "takt/bus/transaction.hpp"

namespace takt::poll {

/// The shape of the answer to the second step, which writes one register.
inline bus::AnswerShape written_shape(wire::Function function) {
    return bus::answer_shape(function, 1);
}

/// The two steps of a read-modify-write, one at a time on a line. To keep it atomic on the line, the caller
/// sends nothing else while it is active.
class ModifySequence {
public:
    /// The write that follows the read.
    struct SecondStep {
        JobKind kind = JobKind::group_write;
        std::uint64_t index = 0;  ///< as in Candidate
        std::size_t device = 0;
        bus::AnswerShape shape;
        std::uint16_t old = 0;  ///< the register as read
    };

    [[nodiscard]] bool active() const { return active_; }
    /// The next request of the line, once the register was read.
    [[nodiscard]] const std::optional<SecondStep>& second_step() const { return second_step_; }

    /// The read is submitted.
    void begin() {
        TAKT_ASSERT(!active_);
        active_ = true;
    }
    /// The register was read.
    void take_register(const SecondStep& next) {
        TAKT_ASSERT(active_ && !second_step_);
        second_step_ = next;
    }
    /// The read failed.
    void end() { active_ = false; }
    /// The second step is submitted or given up.
    SecondStep finish() {
        TAKT_ASSERT(second_step_);
        active_ = false;
        return *std::exchange(second_step_, std::nullopt);
    }

private:
    bool active_ = false;
    std::optional<SecondStep> second_step_;
};

}  // namespace takt::poll
