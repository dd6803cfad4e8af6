// Status variables: locals that show how reads, writes and devices are doing.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "line/tables.hpp"
#include "takt/value/project_slots.hpp"
#include "takt/value/store.hpp"

namespace takt::poll {

/// The last results of the variables and requests of a line, and the locals that show them.
///
/// A variable shows the result of its last read or write. While nothing can be sent to its device, it shows
/// the reason for that instead. A device shows the result of its first request that is not ok.
///
/// It reads the tables of the line and changes none of them. Allocates in add_requests(). One owner, one
/// thread; what it is given must outlive it.
class Statuses {
public:
    Statuses(const LineTables& tables, const value::ProjectSlots& slots, value::Store& store)
        : tables_(tables), slots_(slots), store_(store) {}

    /// The requests of the line are new ones: all ok. Variables keep their last results.
    void set_requests();

    /// The last result of a request.
    [[nodiscard]] value::Reason of_request(std::size_t request) const { return requests_[request].last; }
    void carry(std::size_t request, value::Reason last) { requests_[request].last = last; }
    void carry(std::size_t variable, const Statuses& old, std::size_t old_variable) {
        variables_[variable] = old.variables_[old_variable];
    }
    /// The last results of all requests, in their order.
    [[nodiscard]] std::vector<value::Reason> of_requests() const;

    /// A read of the request has ended.
    void read_ended(Instant t, std::size_t request, value::Reason reason);
    /// A read of the request has failed; its device is shown as not answering already.
    void note_failed(std::size_t request, value::Reason reason);
    /// A write of these variables by the request has ended.
    void write_ended(Instant t, std::size_t request, std::span<const std::size_t> written,
                     value::Reason reason);
    /// The write of a variable has ended.
    void write_ended(Instant t, std::size_t variable, value::Reason reason);
    /// These values have become too old.
    void values_stale(Instant t, std::span<const std::size_t> variables,
                      std::span<const std::size_t> requests);

    /// Nothing can be sent to the device from now on.
    void device_away(Instant t, std::size_t device, value::Reason reason);
    /// A command for the variable was refused: nothing can be sent to its device.
    void show_unavailable(Instant t, std::size_t variable, value::Reason reason);
    /// The device answers again. Variables that are polled get their status from their next read.
    void device_back(Instant t, std::size_t device);
    /// The requests of the device begin anew.
    void restart(std::size_t device);

private:
    struct OfVariable {
        value::Reason last = value::Reason::ok;  // of its last read or write
        bool away = false;                       // it shows the state of its device instead
    };
    struct OfRequest {
        value::Reason last = value::Reason::ok;
        std::vector<model::LocalIndex> locals;  // the different ones of its variables
    };

    void show(Instant t, std::size_t variable, value::Reason reason);
    void show_device(Instant t, std::size_t device);
    void put(Instant t, model::LocalIndex local, value::Reason reason);

    LineTables tables_;
    const value::ProjectSlots& slots_;
    value::Store& store_;
    std::vector<OfVariable> variables_;
    std::vector<OfRequest> requests_;
};

}  // namespace takt::poll
