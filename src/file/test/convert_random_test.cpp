// Random tables: to projects and back nothing is lost, in any dialect.
#include <fmt/format.h>
#include <rapidcheck/gtest.h>

#include "converted.hpp"
#include "outline.hpp"
#include "takt/model/fields.hpp"
#include "yaml/source.hpp"

namespace takt::file {
namespace convert_random_test {

using model::Node;

// Cells of random variables that a project accepts.
class RandomRow {
public:
    explicit RandomRow(bool cp1251) : cp1251_(cp1251) {}

    Node make(int number) {
        type_ = *rc::gen::elementOf(std::vector<std::string>(model::kTypes.begin(), model::kTypes.end()));
        put("name", std::to_string(number) + text());
        put("type", type_);
        put_address();
        put_traffic();
        put_value();
        for (const auto key :
             {"hold_last", "used", "safe_to_repeat", "high_byte_first", "high_register_first"})
            if (key != std::string("safe_to_repeat") || written_) maybe(key, {"true", "False", "TRUE"});
        if (row_.find("high_byte_first") == nullptr && row_.find("high_register_first") == nullptr)
            maybe("byte_order", {"2143", "4321", "1234", "3 4 1 2"});
        if (chance()) put("unit", text().substr(0, 30));
        if (chance()) put("comment", text());
        return row_;
    }

private:
    static bool chance() { return *rc::gen::inRange(0, 3) == 0; }

    void put(std::string_view key, std::string value) {
        Node name;
        name.kind = Node::Kind::scalar;
        name.text = key;
        name.location = {.file = 1, .line = 1, .column = 1};
        Node cell = name;
        cell.text = std::move(value);
        row_.kind = Node::Kind::mapping;
        row_.entries.emplace_back(std::move(name), std::move(cell));
    }

    void maybe(std::string_view key, const std::vector<std::string>& values) {
        if (chance()) put(key, *rc::gen::elementOf(values));
    }

    std::string text() const {
        std::vector<std::string> letters{"a", "Z", "7", " ",   ",",    ";",   "\"", "'", "-",
                                         "#", ":", "{", "]",   "&",    "%",   "\\", "ж", "Ї",
                                         "ё", "№", "°", "нет", "sep=", "0x1", "~",  "µ"};
        if (!cp1251_) letters.insert(letters.end(), {"中", "😀", "é", "Ω", "\u2028"});
        std::string all;
        const auto count = *rc::gen::inRange(0, 8);
        for (int i = 0; i < count; ++i) all += *rc::gen::elementOf(letters);
        return all;
    }

    void put_address() {
        const bool bits = type_ == "bool" && *rc::gen::inRange(0, 2) == 0;
        bits_ = bits;
        area_ = bits ? *rc::gen::inRange(0, 2) : *rc::gen::inRange(2, 4);
        const auto number = *rc::gen::inRange(0, bits ? 4096 : 65530);
        const auto notation = *rc::gen::inRange(0, 3);
        referenced_ = notation == 0;
        if (notation == 0) {
            put("reference", fmt::format("{}{:05}", "0134"[area_], number + 1));
        } else if (bits && notation == 1) {
            put("coil", std::to_string(number));
        } else {
            put("register", notation == 1 ? fmt::format("0x{:x}", number) : std::to_string(number));
            if (type_ == "bool") put("bit", std::to_string(*rc::gen::inRange(0, 16)));
            return;
        }
        if (type_ == "bool" && !bits) put("bit", "3");
    }

    void put_traffic() {
        const bool named = !referenced_ && chance();
        if (named) put("area", std::string(model::kAreas[static_cast<std::size_t>(area_)]));
        static const char* const kReads[][3] = {{"1", "0x01"}, {"0x02", "2"}, {"4", "0x04"}, {"0x03", "3"}};
        const auto* const read = kReads[area_][*rc::gen::inRange(0, 2)];
        written_ = (area_ == 0 || (area_ == 3 && type_ != "bool")) && chance();
        const bool only_written = written_ && chance();
        put("read", only_written ? "none" : read);
        if (written_) put("write", area_ == 0 ? "0x0F" : "16");
        if (written_) maybe("write_on_change", {"true"});
        const bool triggered = written_ && chance();
        if (triggered) put("write_trigger", "пуск; \"1\"");
        if (!only_written) maybe("read_trigger", {"go", "старт"});
        maybe("status", {"st", "статус, общий"});
        maybe("period", {"1s", "1.5s", "250ms", "1h", "40 ms"});
        maybe("deadline", {"1s", "75us", "0.5 h"});
    }

    void put_value() {
        const bool text_type = type_ == "string";
        if (text_type) put("length", std::to_string(*rc::gen::inRange(20, 60)));
        if (type_ != "bool" && !text_type) {
            maybe("scale", {"0.1", "1e-3", "-2"});
            maybe("dead_band", {"0.5", "3"});
            if (written_) maybe("write_range", {"0..0", "0..", "..0"});
        }
        if (!chance()) return;
        if (text_type)
            put("default", "x" + text().substr(0, 30));
        else
            put("default", type_ == "bool" ? *rc::gen::elementOf(std::vector<std::string>{"true", "0", "1"})
                           : type_ == "float" || type_ == "double" ? "-1.25e3"
                                                                   : "0");
    }

    bool cp1251_;
    std::string type_;
    bool bits_ = false;
    int area_ = 0;
    bool referenced_ = false;
    bool written_ = false;
    Node row_;
};

// Cuts of texts may end within a character; such a text is no text.
bool is_whole(const std::vector<Node>& rows) {
    for (const auto& row : rows)
        for (const auto& [key, cell] : row.entries)
            if (find_foreign(cell.text)) return false;
    return true;
}

// Bytes in CP1251 that could as well be UTF-8: the writer refuses them, as the reader would take them for
// that.
bool reads_as_utf8(const Written& written) {
    return written.findings.size() == 1 && written.findings.front().code == "file.csv.reads_as_utf8";
}

RC_GTEST_PROP(Convert, TablesAndProjectsHoldTheSameVariables, ()) {
    TableFormat format;
    format.headings = static_cast<Headings>(*rc::gen::inRange(0, 5));
    format.separator = *rc::gen::elementOf(std::string(",;\t"));
    format.encoding = *rc::gen::element(Encoding::utf8, Encoding::cp1251);
    format.byte_order_mark = *rc::gen::arbitrary<bool>();
    std::vector<Node> rows;
    const auto count = *rc::gen::inRange(1, 6);
    for (int i = 0; i < count; ++i) rows.push_back(RandomRow(format.encoding == Encoding::cp1251).make(i));
    RC_PRE(is_whole(rows));

    Loaded table;
    table.document.files = {"p.yaml", "t.csv"};
    table.document.root.kind = Node::Kind::list;
    table.document.root.items = rows;
    const auto project = project_of_table(table, kAround);
    RC_ASSERT(errors_of(project) == Findings{});
    const auto expected = described(model::interpret(project.document).project);

    const auto yaml = write_project(project.document.root);
    const auto read = load_text("p.yaml", yaml);
    RC_LOG() << yaml;
    RC_ASSERT(errors_of(read) == Findings{});
    RC_ASSERT(described(model::interpret(read.document).project) == expected);

    const auto written = write_table(rows_of_device(rows_of_project(read.document), "D"), format);
    RC_LOG() << written.bytes;
    RC_PRE(!reads_as_utf8(written));
    RC_ASSERT(written.findings.empty());
    for (const auto addresses : {Addresses::zero_based, Addresses::automatic}) {
        const auto back = project_of(written.bytes, {.addresses = addresses});
        RC_ASSERT(errors_of(back) == Findings{});
        RC_ASSERT(described(model::interpret(back.document).project) == expected);
    }
}

RC_GTEST_PROP(Convert, AnyBytesAreATableOrFindings, ()) {
    const auto pieces = *rc::gen::container<std::vector<std::string>>(
        rc::gen::elementOf(std::vector<std::string>{"name",
                                                    "type",
                                                    "Адрес регистра",
                                                    "read",
                                                    "registers",
                                                    "default",
                                                    "line",
                                                    ",",
                                                    ";",
                                                    "\t",
                                                    "\n",
                                                    "\r\n",
                                                    "\"",
                                                    "40001",
                                                    "10h",
                                                    "нет",
                                                    "2-register int",
                                                    "03 (0x03)",
                                                    "sep=;",
                                                    "\xFF",
                                                    "\x98",
                                                    "\xEF\xBB\xBF",
                                                    std::string(1, '\0'),
                                                    "1,5",
                                                    "reference",
                                                    "Период, мс",
                                                    "-"}));
    std::string bytes;
    for (const auto& piece : pieces) bytes += piece;
    for (const auto addresses : {Addresses::automatic, Addresses::reference}) {
        const auto loaded = load_table_text("t.csv", bytes, {.addresses = addresses, .devices = true});
        locations_and_codes(loaded);
        const auto project = project_of_table(loaded, kAround);
        if (!errors_of(project).empty()) continue;
        const auto written = write_table(loaded.document.root.items, {.separator = ';'});
        RC_ASSERT(written.bytes.empty() != written.findings.empty());
        if (!written.findings.empty()) continue;
        const auto back = project_of(written.bytes, {.devices = true});
        RC_ASSERT(described(model::interpret(back.document).project) ==
                  described(model::interpret(project.document).project));
    }
}

}  // namespace convert_random_test
}  // namespace takt::file
