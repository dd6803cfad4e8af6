// The values that a line is to write.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "line/transfer.hpp"
#include "takt/value/store.hpp"

namespace takt::poll {

/// What the variables of a line hold as far as writing is concerned: wanted, last read, initial, last sent.
///
/// Each wanted value has a number, which grows with each want() on the line. So it is known whether a
/// variable was set since a write began. Variables are numbers of the caller; only those of add() have
/// values.
///
/// Allocates in add(). One owner, one thread; the store and the variables must outlive it.
class WrittenValues {
public:
    explicit WrittenValues(value::Store& store) : store_(store) {}

    /// The variable can be written. The restored value in its slot, else its default, is its initial value.
    void add(std::size_t variable, const model::Variable& model, value::SlotId slot);
    /// Whether it was added. The functions below require it, if they do not say otherwise.
    [[nodiscard]] bool writable(std::size_t variable) const {
        return variable < values_.size() && values_[variable];
    }

    [[nodiscard]] const model::Variable& model(std::size_t variable) const {
        return *values_[variable]->model;
    }

    /// A wanted value and its number. Number 0: it was never set.
    struct Wanted {
        value::Value value;
        std::uint64_t number = 0;
    };
    /// The value is wanted from now on.
    /// @returns its number
    std::uint64_t want(std::size_t variable, const Written& written);
    [[nodiscard]] Wanted wanted(std::size_t variable) const;
    [[nodiscard]] std::uint64_t number(std::size_t variable) const { return values_[variable]->number; }
    /// Wants `before` again, unless another value than that of `number` is wanted by now.
    void restore(std::size_t variable, std::uint64_t number, const Wanted& before);
    /// The number of the last want() of the line.
    [[nodiscard]] std::uint64_t last_number() const { return last_number_; }

    /// The value wanted last, else read last, else the initial one; nullptr: there is none of them.
    [[nodiscard]] const value::Value* to_write(std::size_t variable) const;
    /// The same, encoded. There is one.
    [[nodiscard]] Result<Written> encoded(std::size_t variable) const;
    [[nodiscard]] bool was_set(std::size_t variable) const;

    /// Also of a variable that was not added: no effect.
    void note_read(std::size_t variable, const value::Value& value);
    /// The value is sent. It is kept only if it is shown or verified later.
    void note_sent(std::size_t variable, const value::Value& value);
    /// As last sent: of a variable that is verified or not read.
    [[nodiscard]] const value::Value& sent(std::size_t variable) const { return values_[variable]->sent; }

    /// Numbers go on after those of `old`.
    void continue_numbers(const WrittenValues& old) { last_number_ = old.last_number_; }
    /// A variable has what a variable of `old` had. No effect if one of them was not added.
    void take_over(std::size_t variable, const WrittenValues& old, std::size_t old_variable);

private:
    struct OfVariable {
        const model::Variable* model = nullptr;
        value::SlotId slot;
        value::Value last_read;
        value::Value initial;  // empty: none
        value::Value sent;
        std::uint64_t number = 0;          // of its wanted value
        std::vector<std::uint16_t> words;  // Written::words of its wanted value; empty: not encoded here
    };

    value::Store& store_;
    std::vector<std::unique_ptr<OfVariable>> values_;  // by variable; empty if the line writes nothing
    std::uint64_t last_number_ = 0;
};

}  // namespace takt::poll
