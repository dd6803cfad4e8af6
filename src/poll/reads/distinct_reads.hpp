// The reads of a line that are sent in the place of planned ones (docs/decisions/0032-in-step.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "devices/outcome_class.hpp"
#include "line/heap_optional.hpp"
#include "line/tables.hpp"
#include "reads/distinct_read.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/plan/read_alternatives.hpp"

namespace takt::poll {

/// The alternatives to the planned reads of a line, and which of them was sent. They are made when the
/// response to a read could be mistaken for the first time: a line without failures has none.
///
/// It reads the tables of the line and changes none of them. It does not know the engine: the caller asks how
/// a response could be mistaken. Allocates in choose(). One owner, one thread; what it is given
/// must outlive it.
class DistinctReads {
public:
    DistinctReads(const model::Project& project, const model::Line& line, const LineTables& tables)
        : project_(project), line_(line), tables_(tables) {}

    /// The requests of the line are these from now on. Alternatives made of others are forgotten.
    void set_requests(std::span<const plan::Request> planned);

    /// See DistinctRead::choose().
    template <class Ask>
    [[nodiscard]] const plan::ReadAlternative* choose(std::size_t request, bus::Ambiguity planned,
                                                      const Ask& ambiguity) {
        return of(request).choose(planned, ambiguity);
    }

    /// @param instead  what is sent in the place of the planned read; nullptr: the planned read itself
    void send(std::size_t request, const plan::ReadAlternative* instead) {
        if (known(request)) reads_[request]->send(instead);
    }
    /// The planned read or a wider one was sent.
    [[nodiscard]] bool whole(std::size_t request) const {
        return !known(request) || reads_[request]->whole();
    }

    /// What the end of a read means.
    enum class Ended : std::uint8_t {
        planned,  ///< the same as that of the planned read: it failed, or all values have come
        part,     ///< some values have come; the planned read follows
        other,    ///< none of its values has come; the planned read follows
    };
    Ended ended(std::size_t request, const OutcomeClass& outcome_class);

private:
    [[nodiscard]] bool known(std::size_t request) const { return request < reads_.size() && reads_[request]; }
    [[nodiscard]] DistinctRead& of(std::size_t request);

    const model::Project& project_;
    const model::Line& line_;
    LineTables tables_;
    std::span<const plan::Request> planned_;
    std::vector<HeapOptional<DistinctRead>> reads_;                   // by request; empty: none is needed yet
    std::vector<HeapOptional<plan::AlternativeReads>> alternatives_;  // by device, likewise
};

}  // namespace takt::poll
