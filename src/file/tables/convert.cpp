// Rows are distributed to devices by name, and these to lines. All rows of a device must have the same
// address and line. Triggers and statuses that the rows name become locals.
#include "takt/file/convert.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "tables/row_devices.hpp"
#include "tables/row_lines.hpp"
#include "takt/base/ascii.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/findings.hpp"
#include "takt/model/scalar.hpp"
#include "yaml/nodes.hpp"
#include "yaml/reporter.hpp"

namespace takt::file {
namespace {

using model::Kind;
using model::Node;
using model::SourceLocation;

// A project of one server with these variables and no bank.
model::Document served_alone(const Node& variables, const std::vector<std::string>& files) {
    auto unit = collection(Node::Kind::mapping);
    set(unit, "address", scalar("1"));
    set(unit, "banks", collection(Node::Kind::list));
    set(unit, "variables", variables);
    auto server = collection(Node::Kind::mapping);
    set(server, "name", scalar("slave"));
    set(server, "listen", scalar("*"));
    set(server, "units", list_of(std::move(unit)));
    model::Document document{.files = files, .root = collection(Node::Kind::mapping)};
    set(document.root, "takt", scalar("1"));
    set(document.root, "servers", list_of(std::move(server)));
    return document;
}

// A bank for each area of the variables, from the least item to the greatest. The interpretation resolves
// areas, references and types.
Node banks_of(const Node& variables, const std::vector<std::string>& files) {
    constexpr unsigned kLastItem = 65535;
    std::map<std::string_view, std::pair<unsigned, unsigned>> areas;
    const auto checked = model::interpret(served_alone(variables, files));
    for (const auto& variable : checked.project.servers.at(0).units.at(0).variables) {
        const unsigned first = variable.start();
        const unsigned last = std::min(first + variable.items() - 1U, kLastItem);
        const auto [at, added] =
            areas.emplace(model::kAreas[static_cast<std::size_t>(variable.area)], std::pair(first, last));
        at->second = {std::min(at->second.first, first), std::max(at->second.second, last)};
    }
    auto banks = collection(Node::Kind::list);
    for (const auto& [area, items] : areas) {
        auto bank = collection(Node::Kind::mapping);
        set(bank, "area", scalar(area));
        const auto range = std::to_string(items.first) + ".." + std::to_string(items.second);
        set(bank, "items", list_of(scalar(range)));
        banks.items.push_back(std::move(bank));
    }
    return banks;
}

// The device of a table whose rows name none.
struct TableDevice {
    std::size_t number = 0;
    Node settings;
};

// `Устройство, 16`: the name of a table as an IDE shows its device.
std::pair<std::string, std::string> name_and_address(const std::string& title) {
    const auto comma = title.rfind(',');
    if (comma == std::string::npos) return {title, {}};
    auto address = title.substr(comma + 1);
    address.erase(0, address.find_first_not_of(' '));
    if (!all_digits(address) || address.size() > 3 || comma == 0) return {title, {}};
    return {title.substr(0, comma), address};
}

// Distributes the rows of a table to their devices.
class Gathering {
public:
    /// @param files  of the document that the rows are from
    Gathering(const Surroundings& surroundings, const std::vector<std::string>& files, Reporter& reporter)
        : surroundings_(surroundings), files_(files), reporter_(reporter) {}

    /// @param table  the settings of the device of rows that name none
    void add(const Node& row, const TableDevice* table = nullptr) {
        auto& device = device_of(row, table, lines_.of(row));
        take_settings(device, row);
        device.variables.items.push_back(without_place(row));
        declare_locals(row);
    }

    void add_local(const Node& row) {
        const auto name = text_of(row, "name");
        if (!name.empty()) declared_.insert(name);
        locals_.items.push_back(row);
    }

    /// A device without variables, so that an empty table is a device too.
    void add_device(const TableDevice& table) { device_of(collection(Node::Kind::mapping), &table, 0); }

    /// Settings of a device, with its variables or without. These may be in another table.
    /// @param table  number of the table
    void add_settings(const Node& row, std::size_t table) {
        auto settings = device_settings(row);
        Node variables;
        if (auto* const list = find_value(settings, "variables")) variables = std::move(*list);
        std::erase_if(settings.entries, [](const auto& entry) { return entry.key.text == "variables"; });
        for (const std::string_view key : {"status", "poll_enable"})
            if (const auto* const cell = settings.find(key))
                declare_local(*cell, key == "status" ? "int" : "bool");
        if (const auto* const protocol = settings.find(kProtocolColumn)) lines_.take_protocol(0, *protocol);
        std::erase_if(settings.entries, [](const auto& entry) { return entry.key.text == kProtocolColumn; });
        settings_.push_back({std::move(settings), std::move(variables), table});
    }

    [[nodiscard]] std::size_t count_settings() const { return settings_.size(); }

    /// The settings of a device with that address, else with that name and no other address, for one
    /// device; nullptr: there are none. Every new device of an IDE has the same name.
    const Node* claim(const std::string& name, const std::string& address) {
        const auto has_address = [&](const Settings& its) {
            return !address.empty() && text_of(its.settings, "address") == address;
        };
        const auto has_name = [&](const Settings& its) {
            return text_of(its.settings, "name") == name &&
                   (address.empty() || its.settings.find("address") == nullptr);
        };
        const auto claimed = [](auto& all, const auto& is_it) -> const Node* {
            const auto found =
                std::ranges::find_if(all, [&](const Settings& its) { return its.is_free() && is_it(its); });
            if (found == all.end()) return nullptr;
            found->claimed = true;
            return &found->settings;
        };
        const auto* const by_address = claimed(settings_, has_address);
        return by_address != nullptr ? by_address : claimed(settings_, has_name);
    }

    /// The only settings that there are; nullptr if they have variables of their own.
    const Node* claim_only() {
        if (!settings_.front().is_free()) return nullptr;
        settings_.front().claimed = true;
        return &settings_.front().settings;
    }

    struct Settings {
        Node settings;
        Node variables;
        std::size_t table = 0;
        bool claimed = false;  // by a table of variables

        [[nodiscard]] bool is_free() const { return !claimed && variables.kind == Node::Kind::null; }
    };

    /// Settings that no table of variables claimed: devices with their own variables, or without any.
    [[nodiscard]] std::vector<Settings> unclaimed() const {
        auto all = settings_;
        std::erase_if(all, [](const Settings& its) { return its.claimed; });
        return all;
    }

    Node project() {
        check_addresses();
        std::vector<NamedVariables> named;
        for (auto& [settings, variables, line] : devices_)
            named.push_back({text_of(settings, "name"), text_of(settings, "address"), &variables});
        qualify_names(std::move(named), surroundings_.names, reporter_);
        auto root = collection(Node::Kind::mapping);
        set(root, "takt", scalar("1"));
        if (devices_.empty() && !serves_ && !locals_.items.empty())
            set(root, "lines", collection(Node::Kind::list));
        else if (!devices_.empty() || !serves_)
            add_lines(root);
        if (serves_) add_server(root);
        if (!locals_.items.empty()) set(root, "locals", std::move(locals_));
        return root;
    }

    /// The rows of a table of a server; it may have none.
    void add_served(const Node& rows) {
        serves_ = true;
        for (const auto& row : rows.items) served_.items.push_back(without_place(row));
    }

private:
    struct Device {
        Node settings;
        Node variables = {};
        std::size_t line = 0;
    };
    void add_lines(Node& root) {
        std::vector<Node> devices(lines_.count(), collection(Node::Kind::list));
        if (devices_.empty()) devices_.push_back({.settings = mapping_of(surroundings_.device)});
        for (auto& [settings, variables, line] : devices_) {
            variables.kind = Node::Kind::list;
            set(settings, "variables", std::move(variables));
            devices[line].items.push_back(std::move(settings));
        }
        set(root, "lines", lines_.take(std::move(devices)));
    }

    // One server with one unit. Beside a line it listens by TCP, else it has the connection of the line.
    void add_server(Node& root) {
        auto server = collection(Node::Kind::mapping);
        set(server, "name", scalar("slave"));
        const bool alone = root.find("lines") == nullptr;
        for (const auto& [key, text] : surroundings_.line)
            if (alone && key != "name") set(server, key == "host" ? "listen" : key, scalar(text));
        if (!alone) {
            set(server, "transport", scalar("tcp"));
            set(server, "listen", scalar("127.0.0.1"));
        }
        auto unit = collection(Node::Kind::mapping);
        for (const auto& [key, text] : surroundings_.device)
            if (key == "address") set(unit, key, scalar(text));
        set(unit, "banks", banks_of(served_, files_));
        set(unit, "variables", std::move(served_));
        set(server, "units", list_of(std::move(unit)));
        set(root, "servers", list_of(std::move(server)));
    }

    Device& device_of(const Node& row, const TableDevice* table, std::size_t line) {
        const bool unnamed = table != nullptr && row.find(kDeviceColumn) == nullptr;
        // A line feed cannot be in the name of a device.
        const auto name = unnamed ? "\n" + std::to_string(table->number) : text_of(row, kDeviceColumn);
        const auto [at, added] = index_.try_emplace(name, devices_.size());
        if (added) {
            devices_.push_back(
                {.settings = unnamed ? table->settings : mapping_of(surroundings_.device), .line = line});
            const auto* const cell = row.find(kDeviceColumn);
            if (cell != nullptr) set(devices_.back().settings, "name", *cell);
            if (const auto* const settings = unnamed ? nullptr : claim(name, {})) {
                for (const auto& [key, value] : settings->entries)
                    set(devices_.back().settings, key.text, value);
                if (const auto* const address = settings->find("address"))
                    addresses_.emplace(name, address->text);
            }
            locations_.push_back(cell != nullptr ? cell->location : row.location);
        }
        auto& device = devices_[at->second];
        if (device.line != line)
            disagreements_.report(*row.find(kLineColumn), kLineColumn, lines_.name(device.line));
        if (const auto* const cell = row.find(kUnitAddressColumn)) {
            const auto* const known = addresses_.contains(name) ? &addresses_[name] : nullptr;
            if (known != nullptr && *known != cell->text)
                reporter_.error(
                    "file.convert.two_addresses", cell->location,
                    {.value = cell->text,
                     .arguments = {{"device", text_of(device.settings, "name")}, {"first", *known}}});
            addresses_.emplace(name, cell->text);
            if (known == nullptr) set(device.settings, "address", *cell);
        }
        return device;
    }

    void check_addresses() {
        if (devices_.size() < 2) return;
        std::set<std::string> taken;
        for (const auto& [name, address] : addresses_) taken.insert(address);
        for (const auto& [name, at] : index_) {
            if (addresses_.contains(name) || name.starts_with('\n')) continue;
            reporter_.error("file.convert.no_address", locations_[at], {.value = name});
            // The default may be that of another device, which would be a second finding about the cell.
            for (int free = 1; !taken.insert(text_of(devices_[at].settings, "address")).second; ++free)
                set(devices_[at].settings, "address", scalar(std::to_string(free)));
        }
    }

    // The settings of a device are the same in all its rows.
    void take_settings(Device& device, const Node& row) {
        Node& settings = device.settings;
        for (const auto key : kDeviceSettings) {
            const auto* const cell = row.find(key);
            if (cell == nullptr) continue;
            if (key == kProtocolColumn) {
                lines_.take_protocol(device.line, *cell);
            } else if (const auto* const known = settings.find(key); known == nullptr) {
                set(settings, key, *cell);
                if (key == "poll_enable") declare_local(*cell, "bool");
            } else if (known->text != cell->text) {
                disagreements_.report(*cell, key, known->text);
            }
        }
    }

    void declare_local(const Node& cell, std::string_view type) {
        if (!declared_.insert(cell.text).second) return;
        auto local = collection(Node::Kind::mapping, cell.location);
        set(local, "name", cell);
        set(local, "type", scalar(type));
        locals_.items.push_back(std::move(local));
    }

    void declare_locals(const Node& row) {
        for (const auto& field : model::fields(model::Object::variable)) {
            if (field.kind != Kind::local_bool && field.kind != Kind::local_integer) continue;
            if (const auto* const cell = row.find(field.key))
                declare_local(*cell, field.kind == Kind::local_bool ? "bool" : "int");
        }
    }

    const Surroundings& surroundings_;
    const std::vector<std::string>& files_;
    Reporter& reporter_;
    Disagreements disagreements_{reporter_};
    RowLines lines_{surroundings_, reporter_, disagreements_};
    std::vector<Settings> settings_;
    std::vector<Device> devices_;
    std::vector<SourceLocation> locations_;         // first cell or row of each device
    std::map<std::string, std::size_t> index_;      // of devices_ by name
    std::map<std::string, std::string> addresses_;  // by name
    Node locals_ = collection(Node::Kind::list);
    bool serves_ = false;
    Node served_ = collection(Node::Kind::list);
    std::set<std::string> declared_;
};

// A project from tables of all kinds.
class TablesProject {
public:
    TablesProject(LoadedTables tables, const Surroundings& surroundings,
                  const std::vector<std::string>& titles)
        : tables_(std::move(tables)),
          titles_(titles),
          gathering_(surroundings, tables_.loaded.document.files, reporter_) {
        for (const auto& [key, text] : surroundings.device)
            if (key == "address") next_ = model::parse_integer(text)->magnitude;
    }

    Loaded make() {
        for (std::size_t i = 0; i < tables_.tables.size(); ++i) note(i);
        for (std::size_t i = 0; i < tables_.tables.size(); ++i) {
            const auto kind = tables_.tables[i].kind;
            if (kind == TableKind::served) gathering_.add_served(tables_.tables[i].rows);
            if (is_device(kind)) add_device(i);
        }
        add_unclaimed();
        tables_.loaded.document.root = gathering_.project();
        for (auto& finding : reporter_.take()) tables_.loaded.findings.push_back(std::move(finding));
        return std::move(tables_.loaded);
    }

private:
    static bool is_device(TableKind kind) { return kind == TableKind::variables || kind == TableKind::list; }

    // What other tables refer to: locals, addresses, and settings of devices.
    void note(std::size_t i) {
        const auto& [rows, kind] = tables_.tables[i];
        const auto address = name_and_address(titles_[i]).second;
        if (!address.empty()) taken_.insert(address);
        if (is_device(kind) && address.empty()) ++untitled_;
        for (const auto& row : rows.items) {
            if (kind == TableKind::locals) gathering_.add_local(row);
            if (kind != TableKind::devices) continue;
            gathering_.add_settings(row, i);
            if (const auto own = text_of(device_settings(row), "address"); !own.empty()) taken_.insert(own);
        }
    }

    std::string free_address(const std::string& device, const SourceLocation& location) {
        while (taken_.contains(std::to_string(next_))) ++next_;
        auto address = std::to_string(next_);
        taken_.insert(address);
        if (tables_.tables.size() > 1 || gathering_.count_settings() > 1)
            reporter_.warning("file.convert.address_assumed", location,
                              {.value = address, .arguments = {{"device", device}}});
        return address;
    }

    // Settings belong to the table of that name or address, or to the only one.
    const Node* settings_of(const std::string& name, const std::string& address) {
        const bool only = untitled_ == 1 && address.empty() && gathering_.count_settings() == 1;
        return only ? gathering_.claim_only() : gathering_.claim(name, address);
    }

    void add_device(std::size_t i) {
        auto& rows = tables_.tables[i].rows;
        auto [name, address] = name_and_address(titles_[i]);
        name_devices(rows.items, name);
        const bool named = std::ranges::any_of(
            rows.items, [](const Node& row) { return row.find(kDeviceColumn) != nullptr; });
        const auto* const settings = named ? nullptr : settings_of(name, address);
        const bool addressed = settings != nullptr && settings->find("address") != nullptr;
        if (address.empty() && !named && !addressed) {
            address = free_address(name, rows.location);
        }
        TableDevice device{i, mapping_of({{"name", name}, {"address", address}}, rows.location)};
        if (settings != nullptr)
            for (const auto& [key, value] : settings->entries) set(device.settings, key.text, value);
        if (!named) gathering_.add_device(device);
        for (const auto& row : rows.items) gathering_.add(row, &device);
    }

    void add_unclaimed() {
        auto number = tables_.tables.size();
        for (auto& [settings, variables, table, claimed] : gathering_.unclaimed()) {
            TableDevice device{number++, std::move(settings)};
            const auto [name, address] = name_and_address(titles_[table]);
            if (device.settings.find("name") == nullptr) set(device.settings, "name", scalar(name));
            if (device.settings.find("address") == nullptr)
                set(device.settings, "address",
                    scalar(address.empty() ? free_address(name, device.settings.location) : address));
            gathering_.add_device(device);
            for (const auto& row : variables.items) gathering_.add(row, &device);
        }
    }

    LoadedTables tables_;
    const std::vector<std::string>& titles_;
    Reporter reporter_;
    Gathering gathering_;
    std::set<std::string> taken_;  // addresses
    std::uint64_t next_ = 1;       // address to try
    std::size_t untitled_ = 0;     // tables of devices whose title has no address
};

}  // namespace

std::vector<std::pair<std::string, std::string>> connection_keys(const model::Line& line) {
    const auto word = [](auto value, const auto& words) {
        return std::string(words[static_cast<std::size_t>(value)]);
    };
    std::vector<std::pair<std::string, std::string>> keys{
        {"transport", word(line.transport, model::kTransports)}};
    const bool serial = line.transport == model::Transport::serial;
    keys.emplace_back(serial ? "port" : "host", line.port);
    if (!serial) keys.emplace_back("tcp_port", std::to_string(line.tcp_port));
    keys.emplace_back("framing", word(line.framing, model::kFramings));
    if (!serial) return keys;
    keys.emplace_back("baud", std::to_string(line.format.baud));
    keys.emplace_back("parity", word(line.format.parity, model::kParities));
    keys.emplace_back("stop_bits", std::to_string(line.format.stop_bits));
    keys.emplace_back("data_bits", std::to_string(line.format.data_bits));
    if (line.rs485 != model::Rs485::automatic) keys.emplace_back("rs485", word(line.rs485, model::kRs485));
    return keys;
}

model::Node device_settings(const model::Node& row) {
    constexpr std::pair<std::string_view, std::string_view> kRenamed[] = {{"register", "address"},
                                                                          {kUnitAddressColumn, "address"},
                                                                          {kDeviceColumn, "name"},
                                                                          {"period", "poll_period"}};
    Node settings = row;
    for (auto& [key, cell] : settings.entries)
        for (const auto& [column, name] : kRenamed)
            if (key.text == column) key.text = name;
    return settings;
}

Loaded project_of_table(Loaded table, const Surroundings& surroundings) {
    Reporter reporter;
    Gathering gathering(surroundings, table.document.files, reporter);
    for (const auto& [key, text] : surroundings.device)
        if (key == "name") name_devices(table.document.root.items, text);
    for (const auto& row : table.document.root.items) gathering.add(row);
    table.document.root = gathering.project();
    for (auto& finding : reporter.take()) table.findings.push_back(std::move(finding));
    return table;
}

Loaded project_of_tables(LoadedTables tables, const Surroundings& surroundings,
                         const std::vector<std::string>& titles) {
    return TablesProject(std::move(tables), surroundings, titles).make();
}

}  // namespace takt::file
