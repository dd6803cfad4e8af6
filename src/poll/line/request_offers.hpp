// What a line may send next: its requests, offered to the arbiter.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "line/job_id.hpp"
#include "line/tables.hpp"
#include "reads/distinct_reads.hpp"
#include "reads/eventful_requests.hpp"
#include "reads/read_schedule.hpp"
#include "takt/bus/arbiter.hpp"
#include "takt/bus/transaction_engine.hpp"
#include "takt/wire/prepared_request.hpp"
#include "writes/command_queue.hpp"
#include "writes/write_groups.hpp"

namespace takt::poll {

/// Offers the reads, writes, commands and probes of a line to its arbiter, each with the earliest instant at
/// which it may start. All are offered for each transaction, so that no change since the last choice is
/// missed. Of many polled reads only the first one of each device is offered (ReadSchedule::set_queue). The
/// result is the same; test builds check this at every choice (TAKT_CHECK_CHOICE).
///
/// While a late response could be mistaken for that to a planned read, another read is offered and sent in
/// its place (DistinctReads, docs/decisions/0032-in-step.md).
///
/// It neither chooses nor sends: for each transaction the caller calls Arbiter::begin(), the functions of
/// "offers", and Arbiter::choose(). An offer changes nothing but what it admits: a token bucket may give its
/// token to a trigger, a write or a command. Offering twice at one instant has the effect of offering once.
///
/// Of the engine it asks when a request may start, and for which responses others could be mistaken. One
/// owner, one thread; what it is given must outlive it. Allocates in set_requests(); an offer may allocate
/// while a response is missing (DistinctReads::choose) and in ReadSchedule::visit_ready().
class RequestOffers {
public:
    struct Parts {
        const bus::TransactionCore& engine;
        LineTables tables;
        ReadSchedule& reads;
        WriteGroups& write_groups;
        CommandQueue& commands;
        DistinctReads* distinct_reads;  ///< nullptr: only planned reads are sent
        bus::Arbiter& arbiter;
    };
    /// @param rounds  reads go in rounds by ascending position, as in `parts.arbiter`
    RequestOffers(const Parts& parts, bool rounds) : parts_(parts), rounds_(rounds) {}

    /// The requests of the line are new ones. Call it when their reads and writes were added.
    void set_requests();
    /// Call it wherever a trigger, a value or a command may concern the request from now on.
    void note_event(std::size_t request);

    // ---- offers

    /// Reads, writes, commands, and probes whose back-off has passed.
    void offer_requests(Instant t);
    /// Writes and commands alone: of a line that polls no more.
    void offer_writes(Instant t);
    /// Probes before their back-off has passed. Call it last: there is one only if nothing else may be sent,
    /// and nothing is due before it has timed out.
    void offer_early_probes(Instant t);
    /// Whether nothing else may be sent at `t`, and nothing is due before a request that takes `lost` has
    /// ended. Call it behind all other offers.
    [[nodiscard]] bool is_spare(Instant t, Duration lost) const {
        return !parts_.arbiter.best() && parts_.engine.idle() && after(t, lost) <= parts_.arbiter.wakeup();
    }
    /// Any other request. @param due  it may not start before
    void offer(Instant t, UnitId unit, const bus::AnswerShape& shape, Instant due,
               const Candidate& candidate);

    // ---- what is sent

    /// When any device may be sent a request, if nothing else happens on the line.
    [[nodiscard]] Instant line_free() const;
    /// The planned read or what is sent in its place, which is noted in DistinctReads.
    [[nodiscard]] wire::PreparedRead read_to_send(Instant t, std::size_t request);

private:
    [[nodiscard]] const RequestRun& request(std::size_t index) const { return parts_.tables.requests[index]; }
    [[nodiscard]] const DeviceRun& device_of(std::size_t request_index) const {
        return parts_.tables.devices[request(request_index).device];
    }
    [[nodiscard]] Instant earliest(const DeviceRun& device, const bus::AnswerShape& shape) const {
        return parts_.engine.earliest_start(device.model->address, shape);
    }
    [[nodiscard]] bool takes_more(const DeviceRun& device) const {
        return reachable(device) && !full(device);
    }

    void offer_all(Instant t);
    void offer_first(Instant t);
    void offer_first_of(Instant t, Instant free, std::size_t device);
    void offer_event(Instant t, std::size_t request);
    void offer_triggered(Instant t, std::size_t request);
    bool offer_polled(Instant t, std::size_t request);
    void offer_write(Instant t, std::size_t request);
    void offer_command(Instant t, PendingCommand& command);
    void offer_commands(Instant t);
    void offer_read_back(Instant t, const DeviceRun& device, const ReadBack& back, Candidate candidate);
    void offer_probes(Instant t);
    void offer_probe(Instant t, std::size_t request, Instant since);
    void check_choice(Instant t);

    [[nodiscard]] bool eventful(std::size_t request) const;
    [[nodiscard]] std::optional<std::size_t> probe_of(std::size_t device) const;
    [[nodiscard]] const plan::ReadAlternative* alternative_to(Instant t, std::size_t request);
    [[nodiscard]] bus::AnswerShape shape_to_send(Instant t, std::size_t request);

    Parts parts_;
    bool rounds_;
    EventfulRequests eventful_;  // if the reads have a queue
};

}  // namespace takt::poll
