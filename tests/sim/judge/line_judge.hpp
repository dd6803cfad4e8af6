// The judge of one line. Its inputs are the bytes at the master's port, the devices' observers, the accepted
// commands of the users, and the table of values. It keeps its own records and shares no code with the
// engines. Parts: record.cpp (events), settle.cpp (ends of transactions), wire_rules.cpp, order_rules.cpp,
// write_rules.cpp, value_rules.cpp.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "arithmetic.hpp"
#include "case.hpp"
#include "ledger.hpp"
#include "sim/faults/faults.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/plan/read_alternatives.hpp"
#include "takt/sim/device_observer.hpp"
#include "takt/value/command.hpp"
#include "takt/value/store.hpp"
#include "transaction.hpp"
#include "values.hpp"

namespace takt::judge {

/// A variable by its index among all of the line, in the order of the project.
using VariableNumber = std::size_t;

/// Removes elements from the front until `most` are left.
template <class Container>
void shorten(Container& container, std::size_t most) {
    while (container.size() > most) container.erase(container.begin());
}

/// The adapter between the master and a serial line.
struct Adapter {
    bool echoes = false;    ///< the master receives its own transmissions
    bool in_parts = false;  ///< a transmission may be received in parts
};

class LineJudge {
public:
    LineJudge(const Case& judged, std::size_t line, Complaints& complaints, const Adapter& adapter = {});

    /// The line learns and switches to `plan`. It is then judged by the rules that hold for every plan; the
    /// age of its values is not judged.
    void on_plan(Instant t, const plan::LinePlan& plan);

    // The master's port. Times as the master is given them.
    void on_link(Instant t, bool up);
    /// The connection was closed. It is opened when it is needed.
    void on_close(Instant t);
    /// @param claim  the purpose as the master reports it
    void on_sent(Instant t, std::span<const std::uint8_t> bytes, const std::optional<Claim>& claim);
    /// The chosen request was never sent, because the line did not become silent.
    void on_unsent(const Claim& claim);
    void on_heard(Instant t, std::span<const std::uint8_t> bytes);
    /// A request of a client that shares the line was sent, and the master has its outcome.
    void on_relayed(Instant t, std::span<const std::uint8_t> bytes);
    void on_relayed_end(const bus::Outcome& outcome);

    // The devices.
    void on_read(const sim::DeviceItems& items);
    void on_write(const sim::DeviceItems& items);
    void on_fault(const sim::FaultEvent& event);

    // The users. Only accepted commands.
    void on_set(Instant t, VariableNumber variable, const value::Value& value);
    void on_command(Instant t, const value::WriteCommand& command, VariableNumber variable);
    void on_outcome(Instant t, const value::CommandOutcome& outcome);
    void on_local(Instant t, model::LocalIndex local, bool before, bool after);

    /// After every call of the engine. @param ended  transactions that have ended according to the engine, by
    /// device
    void look(Instant t, const value::Store& store, std::uint32_t first_slot,
              const std::vector<std::uint64_t>& ended);

    /// Each state of a value, as outputs and the history get it: look() sees the last one of a step only.
    void on_event(Instant t, const value::Event& event, std::uint32_t first_slot);

    /// Everything is idle and has been for long enough.
    void finish(Instant t, const value::Store& store, std::uint32_t first_slot);

    [[nodiscard]] std::size_t variables() const { return variables_.size(); }
    [[nodiscard]] VariableNumber number_of(std::size_t device, std::size_t variable) const {
        return devices_[device].first_variable + variable;
    }
    [[nodiscard]] const model::Variable& model_of(VariableNumber v) const { return *variables_[v].model; }
    /// Recovered faults, by kind.
    [[nodiscard]] const std::map<std::string_view, std::uint64_t>& recoveries() const { return recoveries_; }

private:
    static constexpr Instant kMayBeReadBack = Instant::max();  // instead of the time since when it must be
    struct DeviceState {
        const model::Device* model = nullptr;
        std::size_t first_variable = 0;
        bool enabled = true;
        unsigned failures = 0;  // in a row, for certain
        unsigned possible = 0;  // with the answers that the master need not have found
        unsigned probes = 0;    // that failed since it counts as not answering
        Instant probe_not_before = Instant::min();
        Instant last_read = Instant::min();    // its start
        Instant clean_from = Instant::min();   // nothing that was asked of it before can hold anything back
        std::uint64_t sent = 0;                // transactions
        std::uint64_t ended = 0;               // of them, by the engine
        bool failed_by_close = false;          // the last time, for certain
        bool has_reads = false;                // else it is not probed
        Instant good_at = Instant::min();      // of the last event with a good value
        std::optional<Duration> fastest;       // of its answers
        std::optional<Instant> answered_late;  // the last time that its answer came after the deadline
        [[nodiscard]] bool dead() const { return failures >= model->attempts; }
        [[nodiscard]] bool may_be_dead() const { return possible >= model->attempts; }
        void answers() { failures = possible = probes = 0; }
    };
    struct Order {
        value::Value value;
        Instant t;
        std::optional<value::CommandId> command;
    };
    struct Executed {
        Instant t;
        Words items;
        std::optional<value::CommandId> command = {};  // that was written alone
        [[nodiscard]] bool for_another(std::optional<value::CommandId> than) const {
            return command && command != than;
        }
    };
    struct VariableState {
        const model::Variable* model = nullptr;
        std::size_t device = 0;
        std::optional<std::size_t> change_group;  // request of the plan
        std::vector<Order> orders;                // that stand, the last one is what is wanted
        std::vector<Order> refused;               // that must not be executed any more
        std::deque<Executed> executed;            // the last ones
        std::deque<Executed> believed;            // that its device confirmed, or that no device answers
        std::optional<Words> read_items;          // as last read well
        std::uint64_t batch = 0;
        bool good = false;                  // by a read
        Instant sampled_at;                 // the moment of what is shown
        Instant event_at = Instant::min();  // the last one
    };
    /// The values of a device and their times.
    struct Served {
        Instant t;
        std::uint8_t unit = 0;
        wire::Area area = wire::Area::holding_register;
        std::uint16_t start = 0;
        Words items;
    };
    struct RequestState {
        const plan::Request* plan = nullptr;
        // reading
        Instant served_until = Instant::min();  // releases up to then are served
        bool at_once = false;                   // its device came back
        bool retry = false;                     // the last attempt failed
        Instant failed_at;
        unsigned failures = 0;             // in a row
        unsigned cuts = 0;                 // in a row: its connection ended before its response
        bool busy = false;                 // its device answered with exception 5 or 6
        bool held = false;                 // it failed or was put off: not judged by priority
        std::optional<Instant> edge;       // of its trigger, unserved
        std::optional<Instant> next_edge;  // that rose while `edge` was set
        bool trigger_failed = false;       // the last read by its trigger did
        bool exchanged = false;            // the edge may be served by the 0x17 that it causes too
        // writing
        std::vector<VariableNumber> members;
        std::optional<Instant> set_since;        // by a change, not sent since
        std::optional<Instant> triggered_since;  // likewise, by its trigger
        bool may_be_triggered = false;           // while its device counts as dead, but may have answered
        std::set<VariableNumber> set_bits;       // of a register, that were set and not sent since
        std::set<VariableNumber> taken_bits;     // those that the write in flight has
        std::set<VariableNumber> changed;        // what its last write certainly changed
        bool modifying = false;                  // its register was read, to be written back
        bool repeat = false;                     // it may be sent again
        bool open = false;                       // whether its last write was done is not known
        std::optional<Instant> read_back_since;  // its write was confirmed and is to be compared
        std::optional<Instant> last_admitted;    // by its bucket
        void forget_edges() {
            edge.reset();
            next_edge.reset();
        }
        /// It has a back-off of its own, though its device answers.
        [[nodiscard]] bool slowed(unsigned attempts) const { return failures >= attempts; }
    };
    struct Command {
        value::WriteCommand order;
        VariableNumber variable = 0;
        Instant t;
        unsigned sends = 0;
        bool waits = true;       // not in flight
        bool modifying = false;  // its register is being read, or was
        bool carried = false;    // its value was sent with a request for something else
        bool repeat = false;
        std::optional<Instant> read_back_since;  // as of a group
        bool compared = false;                   // it was read back, and is equal
        bool broadcast = false;                  // devices that missed it are unknown
        bool ignored = false;                    // its device confirmed it without executing it
    };

    // record.cpp, settle.cpp
    void adopt(const plan::LinePlan& plan);
    void begin_connection(Instant t);
    void carry(const RequestState& old, RequestState& now) const;
    [[nodiscard]] std::span<const std::uint8_t> without_echo(Instant t, std::span<const std::uint8_t> bytes);
    void settle(Transaction& transaction, Instant t);
    /// The master waits for its answer, for certain or perhaps.
    [[nodiscard]] bool waits(const Transaction& transaction, Instant t) const;
    [[nodiscard]] static bool may_wait(const Transaction& transaction, Instant t) {
        return !transaction.broadcast &&
               (!transaction.over || (transaction.unsure() && transaction.deadline >= t));
    }
    void settle_closed(Instant t);
    [[nodiscard]] Close attribute(const Transaction& transaction, Instant t) const;
    [[nodiscard]] bool may_be_spared(const Transaction& transaction, Instant t) const;
    [[nodiscard]] bool all_met_closes() const;
    void perhaps_lost();
    void note_event_end(const Transaction&, Instant end);
    void settle_request(Transaction& transaction, Instant t);
    void settle_device(const Transaction& transaction);
    void settle_writes(const Transaction& transaction, Instant t);
    void settle_passed(Instant t);
    void settle_claimed(Instant t, const Claim& claim);
    void settle_answered();
    void note_trouble(DeviceState& device, Instant until);
    void note_late_answers(Instant t);
    void note_further_answers();
    [[nodiscard]] bool answers_too_late(Instant t, const DeviceState& device) const;
    /// Line time that the guarantees do not include.
    struct Excess {
        Instant t;
        Duration length;
        std::optional<std::size_t> device;  // whose failed attempt it was
        Duration hold{};                    // for so long that device may be held back beyond it
        bool bounded = false;               // the rate limit of the line admits it
        bool unproved = false;              // an event that no bound includes, that of a dead device neither
    };
    [[nodiscard]] Excess excess_of_failure(const Transaction& transaction, Instant t,
                                           Duration occupied) const;
    [[nodiscard]] Excess excess_of_confirmation(const Transaction& transaction, Instant t) const;
    void note_excess(const Excess& excess);
    void came_back(std::size_t device);
    void restart(std::size_t device, bool at_once);
    [[nodiscard]] Duration all_once(std::size_t device) const;
    void forget_between();
    void believe(const Transaction& transaction, Instant t);
    void note_ignored(Instant t, std::size_t device);
    [[nodiscard]] Transaction* outstanding(std::uint8_t unit);
    [[nodiscard]] bool serial() const { return line_.is_serial(); }
    [[nodiscard]] bool one_at_a_time() const { return line_.framing != wire::Framing::tcp; }
    [[nodiscard]] std::optional<std::size_t> device_of(std::uint8_t unit) const;
    void complain(std::string_view invariant, Instant t, std::string expected, std::string seen) const;
    [[nodiscard]] std::string name_of(VariableNumber v) const { return variables_[v].model->name; }
    [[nodiscard]] std::string describe(const Transaction& transaction) const;

    // wire_rules.cpp
    void check_silence(Instant t);
    void check_free(Instant t);
    void check_probe(Instant t, const Transaction& transaction, const Claim& claim);
    void check_early_probe(const Transaction& transaction, const Claim& claim);
    [[nodiscard]] Duration probe_period(const DeviceState& device, std::size_t request) const;
    void check_length(Instant t, const std::vector<std::uint64_t>& ended);

    // order_rules.cpp
    void take_claim(Transaction& transaction, const Claim& claim);
    void forget_possible_read_backs(std::size_t device);
    [[nodiscard]] std::optional<std::string> doubt(Transaction& transaction, const Claim& claim);
    [[nodiscard]] std::optional<std::string> doubt_read(Transaction& transaction);
    [[nodiscard]] std::optional<std::string> doubt_polled(Transaction& transaction);
    [[nodiscard]] std::optional<std::string> doubt_triggered(Transaction& transaction);
    [[nodiscard]] std::optional<Instant> release_before(const RequestState& request, Instant t) const;
    [[nodiscard]] Instant first_release_after(const RequestState& request, Instant t) const;
    [[nodiscard]] bool may_have_answered(std::size_t device) const;
    [[nodiscard]] bool is_due(const RequestState& request, Instant t) const;
    void switch_device(Instant t, std::size_t device, bool on);
    void drop_triggered(std::size_t device);
    void check_commands_first(const Transaction& transaction);
    void check_priority(const Transaction& transaction);
    [[nodiscard]] bool is_client(const Claim& claim) const;
    [[nodiscard]] bool admits_command(Instant t) const;
    void check_polling_first(const Transaction& transaction);
    [[nodiscard]] const RequestState* waiting_poll(Instant t) const;
    [[nodiscard]] bool sendable(std::size_t device, Instant since, Instant t) const;
    [[nodiscard]] bool compares(std::size_t device) const;

    // write_rules.cpp
    void take_write(Transaction& transaction, const Claim& claim);
    void take_group(Transaction& transaction);
    void take_group_commands(Transaction& transaction, bool were_modifying);
    void take_command(Transaction& transaction, value::CommandId id);
    [[nodiscard]] bool writes_command(const Transaction& transaction, const Command& command) const;
    void take_before(Transaction& transaction, const Claim& claim);
    void take_read_back(Transaction& transaction, const Claim& claim);
    void settle_before(const Transaction& transaction);
    void settle_read_back(const Transaction& transaction, Instant t);
    [[nodiscard]] Transaction* written_by(const sim::DeviceItems& items);
    [[nodiscard]] bool modifies_alone(const Command& command) const;
    void complain_of_write(const Transaction& transaction, bool open,
                           std::span<const VariableNumber> written);
    [[nodiscard]] std::optional<Instant> asked_since(std::size_t group) const;
    [[nodiscard]] bool changes_only(const Transaction& transaction, unsigned bit) const;
    void note_admitted(const Transaction& transaction);
    [[nodiscard]] bool queues_for_bucket(VariableNumber v, Instant t) const;
    void note_carried(const Transaction& transaction);
    [[nodiscard]] Duration hold_of(const DeviceState& device) const;
    [[nodiscard]] bool repeats_ambiguous(const Transaction& transaction,
                                         std::span<const VariableNumber> written) const;
    /// An earlier answer of that shape, of the function, or of the device may still come. Of several lengths
    /// one may have been refused, and which one is not known. See ledger.hpp.
    [[nodiscard]] bool in_doubt(Instant t, const AnswerLedger::Shape& shape) const {
        return one_at_a_time() && ledger_.in_doubt(t, shape);
    }
    [[nodiscard]] bool in_doubt(const Transaction& transaction) const {
        return in_doubt(transaction.start,
                        {.unit = transaction.asked.unit, .function = transaction.asked.function});
    }
    [[nodiscard]] bool in_doubt(Instant t, std::size_t device) const {
        return in_doubt(t, {.unit = devices_[device].model->address.value});
    }
    [[nodiscard]] bool may_be_replaced(const plan::Request& request, Instant t) const;
    [[nodiscard]] plan::ReadAlternatives alternatives_to(const plan::Request& request) const;
    [[nodiscard]] bool writes_range_of(const Asked& asked, const plan::Request& request) const;
    [[nodiscard]] std::set<VariableNumber> changed_by(const Transaction& transaction,
                                                      const RequestState& group) const;
    void check_group(const Transaction& transaction, const RequestState& group);
    void check_bits_taken(const Transaction& transaction, const RequestState& group);
    void check_written(const Transaction& transaction, VariableNumber v,
                       std::span<const std::uint16_t> items);
    void check_kept_bits(const Transaction& transaction, std::uint16_t changed);
    void check_executed(VariableNumber v, const Executed& executed);
    void check_expired(Instant t);
    [[nodiscard]] bool falsely_confirmed(Instant t);
    void drop_order(VariableNumber v, value::CommandId id, bool forbidden);
    [[nodiscard]] bool group_waits(const RequestState& group) const;
    [[nodiscard]] bool verified(std::span<const VariableNumber> members) const;

    // value_rules.cpp
    void set_bounds();
    void set_most_wait();
    void note_served(Transaction& transaction) const;
    void check_quality(Instant t, VariableNumber v, const value::Slot& slot) const;
    void check_sample(Instant t, VariableNumber v, const value::Slot& slot);
    void note_sample(VariableNumber v, const Transaction& source);
    void check_age(Instant t, VariableNumber v);
    void check_outage(Instant t, VariableNumber v) const;
    void check_stale(Instant t, VariableNumber v, const value::Slot& slot) const;
    [[nodiscard]] bool may_have_died(std::size_t device, Instant t) const;
    void check_advance(Instant t);
    [[nodiscard]] Duration most_wait(const RequestState& request, Instant since, Instant t) const;
    [[nodiscard]] Duration lost_since(Instant from, Instant t) const;
    template <class Count>
    void each_excess(Instant t, Count count) const;  // with what is in flight at that time
    [[nodiscard]] std::optional<Duration> bound(VariableNumber v, Instant t) const;
    [[nodiscard]] Duration beyond(const Transaction& transaction, Duration occupied) const;
    [[nodiscard]] Transaction* source_of(VariableNumber v, const value::Slot& slot);
    [[nodiscard]] bool was_held(const value::Slot& slot) const;
    [[nodiscard]] bool is_held(Instant t, VariableNumber v, const value::Slot& slot, Duration period) const;
    [[nodiscard]] Transaction* held_source_of(Instant t, VariableNumber v, const value::Slot& slot);
    [[nodiscard]] bool may_be_doubted(Instant t, std::size_t device) const;
    [[nodiscard]] std::vector<FalseHistory> false_histories(Instant t, const Transaction& transaction) const;
    void keep_false_histories(Instant t);
    [[nodiscard]] bool shows_false_history(Instant t, VariableNumber v, const value::Slot& slot);
    [[nodiscard]] bool shows(Instant t, Transaction& transaction, const FalseHistory& history,
                             VariableNumber v, const value::Slot& slot);
    [[nodiscard]] bool takes(const Transaction& transaction, VariableNumber v) const;
    void note_found(Transaction& transaction);
    [[nodiscard]] std::optional<Words> items_in(const Transaction& transaction, VariableNumber v,
                                                std::span<const std::uint16_t> values) const;
    [[nodiscard]] std::optional<Words> items_of(const Transaction& transaction, VariableNumber v) const;

    const Case& case_;
    const model::Line& line_;
    const plan::LineGuarantee& guarantee_;
    std::size_t index_;
    Complaints& complaints_;
    Arithmetic arithmetic_;

    std::vector<DeviceState> devices_;
    std::vector<VariableState> variables_;
    std::deque<plan::LinePlan> plans_;  // that is judged; own copies
    std::vector<RequestState> requests_;
    std::map<value::CommandId, Command> commands_;
    std::set<value::CommandId> done_;  // ids that had their outcome; bounded by the run's commands
    std::map<std::string_view, std::uint64_t> recoveries_;

    AnswerLedger ledger_;
    Adapter adapter_;
    ByteVector echo_;  // of the last request, whose echo is still expected
    enum class Link : std::uint8_t { none, up, closed, lost };
    Link link_ = Link::none;
    bool may_be_lost_ = false;  // the closed link is
    bool useless_ = false;      // the last connection brought no answer
    bool answers_ = false;      // on this connection
    bool heard_on_ = false;     // something
    Instant closed_at_ = Instant::min();
    std::set<std::uint8_t> closes_;           // units that met a close since one answered
    bool relayed_open_ = false;               // a relayed request is in flight
    std::optional<std::uint8_t> relayed_to_;  // the unit of the last one
    Instant epoch_ = Instant::min();          // the first link
    std::deque<Transaction> transactions_;    // the last ones
    ByteVector received_;                     // since the last request; of a stream, what is left of it
    Instant busy_until_ = Instant::min();     // end of the last character
    Instant last_start_ = Instant::min();
    Instant written_until_ = Instant::min();  // latest end of what commands, triggers and writes sent
    Instant relayed_end_ = Instant::min();    // of the last one
    Instant client_end_ = Instant::min();     // earliest end of the last one without a limit
    bool heard_since_ = false;
    Instant heard_at_ = Instant::min();
    bool paused_ = false;                         // between the pieces of the received bytes
    Instant stood_still_until_ = Instant::min();  // the host
    Instant next_sweep_ = Instant::min();
    std::deque<Served> served_;  // the last ones
    std::deque<Excess> excess_;
    Instant forgotten_ = Instant::min();  // end of the last one that is no more in it
    // Of each variable: T + R, with the worst dead device; nothing: no bound.
    std::vector<std::optional<Duration>> ages_;
    std::vector<std::optional<Duration>> dead_ages_;
    std::vector<std::optional<Duration>> fresh_;     // of each variable: the age at which it becomes stale
    Duration most_wait_{};                           // of a due poll, see check_advance()
    std::vector<std::optional<Duration>> reckoned_;  // C of each request of the plan
    double load_ = 0;                                // of all that is polled
    Duration once_{};                                // all requests once
};

}  // namespace takt::judge
