// The live display of a running project: lines and devices, then the values, those that are not good first.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "takt/host/snapshot.hpp"
#include "takt/report/drawing/panel.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// The rows of a list that a user has chosen to see.
struct LiveSelection {
    std::string device;        ///< rows of this device only; empty: all
    std::string filter;        ///< as of name_matches()
    bool not_good = false;     ///< only values that are not good
    std::size_t first = 0;     ///< the row at the top; the display moves it to where there are rows
    std::size_t page = 1;      ///< rows that the last display had
    bool typing = false;       ///< the filter is being typed
    bool takes_keys = false;   ///< the last line lists the keys
    bool has_devices = false;  ///< there are devices to choose from
    std::vector<std::string> outputs = {};  ///< lines about outputs
};

/// The lines of the display; they fit the screen.
/// @param snapshot   with values and statistics
/// @param selection  its `first` and `page` follow what is shown
[[nodiscard]] std::vector<std::string> live_screen(const Texts& texts, const host::Snapshot& snapshot,
                                                   LiveSelection& selection, const Screen& screen);

/// Whether the filter selects a name.
[[nodiscard]] bool is_selected(const LiveSelection& selection, const std::string& name);

/// Moves `first` so that a page of `height` of `rows` rows is full where possible, and keeps `page`.
/// @returns the number of rows from `first` on that are shown
std::size_t turn_page(LiveSelection& selection, std::size_t rows, std::size_t height);

/// The last line of a display: the keys, or the filter while it is typed, and which rows are shown.
[[nodiscard]] std::string keys_line(const Texts& texts, const LiveSelection& selection, std::size_t rows,
                                    std::size_t shown);

}  // namespace takt::report
