// The shapes of the responses to the requests of an entry.
#pragma once

#include "takt/bus/transaction.hpp"
#include "takt/table/view.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::table {

inline bus::AnswerShape read_shape(const EntryRecord& entry) {
    return bus::answer_shape(wire::Function{entry.read}, entry.quantity);
}

/// The read of a read-modify-write.
inline wire::ReadRequest read_before(const EntryRecord& entry) {
    return {wire::Function::read_holding_registers, DataAddress{entry.start}, entry.quantity};
}

inline bus::AnswerShape written_shape(const EntryRecord& entry) {
    return bus::answer_shape(wire::Function{entry.write}, entry.quantity);
}

}  // namespace takt::table
