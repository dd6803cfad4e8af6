// Columns of a chunk: sequences of numbers or texts as bytes. Every take_ function gets the number of entries
// that the put_ function wrote, and leaves a reader that is not good() where the bytes are damaged.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "history/history_bytes.hpp"

namespace takt::store {

/// Differences to the number before, divided by their greatest common divisor: a value with scale 0.5 or a
/// counter of litres in steps of 10 costs as much as its raw register.
void put_integers(ByteVector& out, std::span<const std::int64_t> numbers);
std::vector<std::int64_t> take_integers(VarintReader& in, std::size_t count);

/// Differences of differences: a regular sequence is all zeros.
void put_regular(ByteVector& out, std::span<const std::int64_t> numbers);
std::vector<std::int64_t> take_regular(VarintReader& in, std::size_t count);

/// As decimal numbers where all have at most nine decimals; else as floats or doubles, combined with the
/// one before by exclusive or, all first bytes first (as Gorilla does, for a compressor behind it).
void put_reals(ByteVector& out, std::span<const double> numbers);
std::vector<double> take_reals(VarintReader& in, std::size_t count);

/// The lengths of runs.
void put_bools(ByteVector& out, const std::vector<bool>& values);
std::vector<bool> take_bools(VarintReader& in, std::size_t count);

/// Each text once, and its number for each entry.
void put_texts(ByteVector& out, std::span<const std::string> texts);
std::vector<std::string> take_texts(VarintReader& in, std::size_t count);

}  // namespace takt::store
