#include "writes/written_values.hpp"

namespace takt::poll {

void WrittenValues::add(std::size_t variable, const model::Variable& model, value::SlotId slot) {
    if (variable >= values_.size()) values_.resize(variable + 1);
    values_[variable] = std::make_unique<OfVariable>(OfVariable{.model = &model, .slot = slot});
    const auto& initial = store_[slot].value;
    if (!value::is_empty(initial) && as_written(model, initial)) values_[variable]->initial = initial;
}

std::uint64_t WrittenValues::want(std::size_t variable, const Written& written) {
    auto& of_variable = *values_[variable];
    store_.want(of_variable.slot, written.value);
    of_variable.words.assign(written.words.begin(), written.words.end());
    return of_variable.number = ++last_number_;
}

WrittenValues::Wanted WrittenValues::wanted(std::size_t variable) const {
    const auto& of_variable = *values_[variable];
    return {store_[of_variable.slot].wanted, of_variable.number};
}

void WrittenValues::restore(std::size_t variable, std::uint64_t number, const Wanted& before) {
    auto& of_variable = *values_[variable];
    if (of_variable.number != number) return;
    store_.want(of_variable.slot, before.value);
    of_variable.words.clear();
    of_variable.number = before.number;
}

bool WrittenValues::was_set(std::size_t variable) const {
    return !value::is_empty(store_[values_[variable]->slot].wanted);
}

const value::Value* WrittenValues::to_write(std::size_t variable) const {
    const auto& of_variable = *values_[variable];
    const auto& wanted = store_[of_variable.slot].wanted;
    if (!value::is_empty(wanted)) return &wanted;
    const auto& held = value::is_empty(of_variable.last_read) ? of_variable.initial : of_variable.last_read;
    return value::is_empty(held) ? nullptr : &held;
}

Result<Written> WrittenValues::encoded(std::size_t variable) const {
    const auto& of_variable = *values_[variable];
    const auto& value = *to_write(variable);
    if (of_variable.words.empty()) return as_written(*of_variable.model, value);
    Written written{.value = value};
    written.words.assign(of_variable.words);
    return written;
}

void WrittenValues::note_read(std::size_t variable, const value::Value& value) {
    if (writable(variable)) values_[variable]->last_read = value;
}

// Variables that are not read show what was sent; verified ones are compared with it.
void WrittenValues::note_sent(std::size_t variable, const value::Value& value) {
    auto& of_variable = *values_[variable];
    if (!of_variable.model->read || of_variable.model->verify) of_variable.sent = value;
}

void WrittenValues::take_over(std::size_t variable, const WrittenValues& old, std::size_t old_variable) {
    if (!writable(variable) || !old.writable(old_variable)) return;
    auto& now = *values_[variable];
    const auto& before = *old.values_[old_variable];
    now.last_read = before.last_read;
    now.sent = before.sent;
    now.number = before.number;
}

}  // namespace takt::poll
