// convert.
#include "commands.hpp"
#include "options/add_commands.hpp"
#include "options/shared_options.hpp"

namespace takt::app {
namespace {

const std::map<std::string, FileKind> kFileKinds{{"csv", FileKind::csv}, {"yaml", FileKind::yaml}};
const std::map<std::string, FileKind> kWrittenKinds{
    {"csv", FileKind::csv}, {"yaml", FileKind::yaml}, {"md", FileKind::markdown}};
const std::map<std::string, char> kSeparators{
    {"comma", ','}, {"semicolon", ';'}, {"tab", '\t'}, {",", ','}, {";", ';'}};
const std::map<std::string, file::Addresses> kAddresses{{"zero-based", file::Addresses::zero_based},
                                                        {"reference", file::Addresses::reference},
                                                        {"auto", file::Addresses::automatic}};
const std::map<std::string, file::Notation> kNotations{{"standard", file::Notation::standard},
                                                       {"coils_at_20001", file::Notation::coils_at_20001},
                                                       {"zero_based", file::Notation::zero_based}};
const std::map<std::string, file::Headings> kHeadings{{"keys", file::Headings::keys},
                                                      {"en", file::Headings::english},
                                                      {"ru", file::Headings::russian},
                                                      {"uk", file::Headings::ukrainian},
                                                      {"ide", file::Headings::ide}};
const std::map<std::string, file::TableKind> kTables{{"variables", file::TableKind::variables},
                                                     {"locals", file::TableKind::locals},
                                                     {"server", file::TableKind::served},
                                                     {"list", file::TableKind::list}};

void add_encoding(Command& command, const std::string& name, std::optional<file::Encoding>& encoding,
                  bool* byte_order_mark, const std::string& help) {
    command
        .text(
            name,
            [&encoding, byte_order_mark](const std::string& text) {
                encoding = text == "cp1251" ? file::Encoding::cp1251 : file::Encoding::utf8;
                if (byte_order_mark != nullptr) *byte_order_mark = text == "utf-8-bom";
            },
            help)
        .one_of({"utf-8", "utf-8-bom", "cp1251"})
        .value_name("ENCODING");
}

}  // namespace

void add_convert(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<ConvertOptions>();
    auto convert =
        line.root().command("convert", "help.convert", [&] { return app::convert(common, options); });
    convert.value("IN", options.inputs, "help.convert.input").required();
    convert.value("-o,--output", options.output, "help.convert.output").value_name("OUT");
    convert.flag("--force", options.force, "help.convert.force");
    add_word(convert, "--from", options.from, kFileKinds, "help.convert.from").value_name("KIND");
    add_word(convert, "--to", options.to, kWrittenKinds, "help.convert.to").value_name("KIND");
    convert.value("--line", options.line, "help.convert.line").value_name("NAME").show_default();
    convert.value("--device", options.device, "help.convert.device").value_name("NAME");
    convert
        .number(
            "--unit", [&](int unit) { options.unit = static_cast<std::uint8_t>(unit); }, "help.convert.unit")
        .range(0, 255);
    convert.value("--target", options.target, "help.convert.target")
        .value_name("TARGET")
        .show_default()
        .check([](const std::string& url) { check_target("--target", url); });
    add_word(convert, "--addresses", options.reading.addresses, kAddresses, "help.convert.addresses")
        .value_name("NOTATION")
        .marks(options.addresses_given);
    add_word(convert, "--notation", options.reading.notation, kNotations, "help.convert.notation")
        .value_name("NOTATION")
        .marks(options.notation_given);
    convert.flag("--strict", options.reading.strict, "help.convert.strict");
    add_word(convert, "--table", options.table, kTables, "help.convert.table")
        .value_name("TABLE")
        .marks(options.table_given);
    convert.flag("--map", options.map, "help.convert.map");
    add_word(convert, "--headings", options.writing.headings, kHeadings, "help.convert.headings")
        .value_name("HEADINGS");
    add_word(convert, "--separator", options.separator, kSeparators, "help.convert.separator")
        .value_name("SEPARATOR");
    add_encoding(convert, "--encoding", options.encoding, &options.byte_order_mark, "help.convert.encoding");
    add_word(convert, "--input-separator", options.reading.separator, kSeparators,
             "help.convert.input_separator")
        .value_name("SEPARATOR");
    add_encoding(convert, "--input-encoding", options.reading.encoding, nullptr,
                 "help.convert.input_encoding");
}

}  // namespace takt::app
